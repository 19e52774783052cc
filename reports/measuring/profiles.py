"""Area, curvature and FFR of one state along its treated segment."""

import dataclasses

import numpy as np
import pandas as pd

from common.errors import InputError
from reports.measuring.curvature import line_curvature, mean_over_length
from reports.inputs.polyline import Polyline
from reports.inputs.reading import number, read_json, read_table
from reports.measuring.segment import map_segment, diameters_at, read_sections

PULLBACK_NUMBERS = ("s_mm", "x_mm", "y_mm", "z_mm", "pressure_pa", "ffr", "flow_m3_per_s")
POST = "post"  # the state after the real procedure; another image shows it, so its lumen ends elsewhere
ERROR_COLUMN = "ffr_error_estimate"  # column of pullback.csv; a field is empty where the error is not known
# statuses of ffr.json that are accepted: a steady flow, and one that keeps some artificial viscosity
ACCEPTED_STATUSES = ("converged", "converged with artificial viscosity")


@dataclasses.dataclass(frozen=True)
class StateProfiles:
    """One state over the segment: arrays (n,) with one value for each station.

    segment: the StateSegment. inside: whether a station has sections on both sides. sections: DataFrame of the branch's
    sections. anatomy_curvature_per_mm: mean of the curvature that the anatomy step wrote. solution: content of
    ffr.json. Without a flow, ffr and solution are None. If FFR comes from the 1D network, only ffr is None.
    """

    segment: object
    s_mm: np.ndarray
    inside: np.ndarray
    area_mm2: np.ndarray
    curvature_per_mm: np.ndarray
    ffr: np.ndarray | None
    sections: object
    anatomy_curvature_per_mm: float
    solution: dict | None


def _branch_rows(path, branch):
    """Rows (DataFrame) of a branch in pullback.csv, in the order of s_mm. Raises InputError if there are none."""
    table = read_table(path, PULLBACK_NUMBERS, ("branch", ERROR_COLUMN), "flow solve")
    rows = table[table["branch"] == branch].sort_values("s_mm", kind="stable").reset_index(drop=True)
    if rows.empty:
        found = ", ".join(sorted(set(table["branch"])))
        raise InputError("the pull-back has no such branch", path, branch, f"branches there: {found}")
    return rows


def read_pullback_error(path, branch):
    """Estimated errors (n,) of the FFR that `read_pullback` returns. NaN where the column is empty.

    Raises InputError for a value that is neither empty nor a finite number of at least 0.
    """
    rows = _branch_rows(path, branch)
    errors = pd.to_numeric(rows[ERROR_COLUMN], errors="coerce").to_numpy(float)
    bad = np.flatnonzero((rows[ERROR_COLUMN] != "").to_numpy() & ~((errors >= 0.0) & (errors < np.inf)))
    if bad.size:
        where = f"{path}: {branch} at {rows['s_mm'][bad[0]]:g} mm, column {ERROR_COLUMN}"
        raise InputError(
            "an error is no finite number of at least 0", where, rows[ERROR_COLUMN][bad[0]], "repeat: flow solve"
        )
    return errors


def read_pullback(path, branch):
    """A branch's pull-back: (Polyline with the flow's own arc length, FFR (n,)). Raises InputError."""
    rows = _branch_rows(path, branch)
    if not 0.0 < rows["ffr"].min() <= rows["ffr"].max() < 1.2:
        worst = rows["ffr"].min() if rows["ffr"].min() <= 0.0 else rows["ffr"].max()
        raise InputError("an FFR is not plausible", path, worst, "expected between 0 and 1.2: check the flow solution")
    line = Polyline(rows[["x_mm", "y_mm", "z_mm"]].to_numpy(), rows["s_mm"].to_numpy(), str(path))
    return line, rows["ffr"].to_numpy()


def read_solution(path):
    """ffr.json with a finite `ffr`; InputError for one whose status is none of ACCEPTED_STATUSES."""
    solution = read_json(path, "flow solve")
    number(solution, "ffr", path)
    status = str(solution.get("status", ""))
    if status not in ACCEPTED_STATUSES:
        raise InputError("a flow solution is not converged", path, status, "repeat the flow solve of this state")
    return solution


def ffr_error_estimate(solution):
    """The estimated error of a solution's FFR at the distal probe; None if it was solved without an estimate."""
    estimate = solution.get("error_estimate")
    return None if estimate is None else float(estimate["ffr"])


def state_profiles(files, state, segment, line, pre_sections, relative):
    """The StateProfiles of one state at the relative positions (n,) of its segment.

    line: this state's centreline. pre_sections: the sections before the procedure, which give the vessel's diameter.
    Raises InputError for a bad file, and ComputationError as map_segment does.
    """
    end_diameters = diameters_at(pre_sections, [segment.s_start_mm, segment.s_end_mm])
    state_segment = map_segment(segment, line, end_diameters, may_end_within=state == POST)
    s_mm = state_segment.stations(relative)
    sections = read_sections(files.anatomy(state) / "sections.csv", segment.branch)
    s_sections = sections["s_mm"].to_numpy()
    ffr, solution = None, files.network_ffr(state)
    if files.has_flow(state):
        flow_line, flow_ffr = read_pullback(files.flow(state) / "pullback.csv", segment.branch)
        ends = np.array([state_segment.s_start_mm, state_segment.s_end_mm])
        ends_on_line = np.clip(ends, line.s_mm[0], line.s_mm[-1])
        flow_ends = [flow_line.project(line.point_at(s))[0] for s in ends_on_line] + (ends - ends_on_line)
        ffr = np.interp(flow_ends[0] + relative * (flow_ends[1] - flow_ends[0]), flow_line.s_mm, flow_ffr)
        solution = read_solution(files.flow(state) / "ffr.json")
    return StateProfiles(
        segment=state_segment,
        s_mm=s_mm,
        inside=(s_mm >= s_sections[0]) & (s_mm <= s_sections[-1]),
        area_mm2=np.interp(s_mm, s_sections, sections["area_mm2"]),
        curvature_per_mm=line_curvature(line, np.clip(s_mm, line.s_mm[0], line.s_mm[-1])),
        ffr=ffr,
        sections=sections,
        anatomy_curvature_per_mm=mean_over_length(np.interp(s_mm, line.s_mm, line.anatomy_curvature_per_mm), s_mm),
        solution=solution,
    )

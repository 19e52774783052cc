"""Metrics of one case: area, curvature and FFR of every state over the treated segment, and their differences."""

import sys

import numpy as np

from common.documents.config import load_case
from common.errors import ComputationError, InputError
from common.patient.states import COMPARISONS, CT_IMAGED_STATES, STATES
from reports.measuring.curvature import mean_over_length
from reports.measuring.device_readouts import case_kind, deployment_summary, lesion_summary, patient_summary
from reports.measuring.device_readouts import lumen_warnings, procedure_summary, reference_summary
from reports.measuring.pressure_wire import ffr_at_wire, wire_summary
from reports.inputs.polyline import read_centreline
from reports.measuring.profiles import ffr_error_estimate, state_profiles
from reports.inputs.reading import entry, read_json
from reports.measuring.segment import read_sections, treated_segment

DEFAULT_MARGIN_MM = 2.0
DEFAULT_STATIONS = 101
FEWEST_STATIONS = 50
LEAST_COVERAGE = 0.5  # least share of the stations to compare; with fewer, a mean no longer represents the segment
QUANTITIES = ("area_mm2", "curvature_per_mm", "ffr")


def case_metrics(files, margin_mm=DEFAULT_MARGIN_MM, stations=DEFAULT_STATIONS, states=None, config=None):
    """The document of metrics.json (reports/tables.md) for the CaseFiles `files`.

    states: names of the states to measure; by default all with results. config: file config/cases/<case>.yaml, for
    the patient's data; None leaves these out.
    Raises InputError for missing or malformed files, ComputationError for a state that cannot be compared.
    """
    if margin_mm < 0.0:
        raise InputError("a margin is negative", "--margin-mm", margin_mm, "give 0 or more")
    if stations < FEWEST_STATIONS:
        raise InputError("too few stations", "--stations", stations, f"give {FEWEST_STATIONS} or more")
    states = files.states() if states is None else [state for state in STATES if state in states]
    if "pre" not in states:
        raise InputError(
            "the state before the procedure is missing", files.folder, states, "run anatomy and flow of pre"
        )
    case, lines = load_case(config) if config is not None else None, {}
    segment = treated_segment(files.scene, files.anatomy("pre") / "centreline.vtp", margin_mm)
    for state in states:
        lines[state] = read_centreline(files.anatomy(state) / "centreline.vtp", segment.branch)
    pre_sections = read_sections(files.anatomy("pre") / "sections.csv", segment.branch)
    relative = np.linspace(0.0, 1.0, stations)
    profiles = {state: state_profiles(files, state, segment, lines[state], pre_sections, relative) for state in states}
    used = common_stations(profiles, files.folder)
    if "post" in states:
        warn_if_partly_covered(profiles["post"], segment)
    return {
        "schema": "vci-metrics-1",
        "case": files.case,
        "kind": case_kind(files, case),
        "patient": patient_summary(files, case),
        "lesion": lesion_summary(files),
        "procedure": procedure_summary(files),
        "plan_reference": reference_summary(files),
        "deployment": deployment_summary(files) if "vci" in states else None,
        "segment": {
            "branch": segment.branch,
            "s_start_mm": segment.s_start_mm,
            "s_end_mm": segment.s_end_mm,
            "margin_mm": margin_mm,
            "proximal_point_mm": segment.proximal_mm.tolist(),
            "distal_point_mm": segment.distal_mm.tolist(),
        },
        "stations": {"count": stations, "used": int(used.sum()), "relative_position": relative[used].tolist()},
        "states": {state: state_document(profiles[state], used) for state in states},
        "differences": {
            f"{a}_minus_{b}": profile_differences(profiles[a], profiles[b], used)
            for a, b, _ in COMPARISONS
            if a in states and b in states
        },
        "measured": wire_summary(files, case),
        "registration": registration_summary(files, profiles["post"], segment) if "post" in states else None,
        "imaging": imaging_summary(files, states),
        "lumen_warnings": lumen_warnings(files, states),
    }


def imaging_summary(files, states):
    """{state: {method, point_spread_fwhm_mm, warnings}}: how each image was segmented; empty without images.

    A real patient's lumen before the procedure comes from a CT or from intravascular contours.
    """
    paths = {state: files.segmentation(state) for state in CT_IMAGED_STATES} if "ct" in states else {}
    source = files.lumen_record()
    if source and source[0] == "ct":
        paths["pre"] = source[1]
    summary = {}
    for state, path in paths.items():
        if path.exists():
            document = read_json(path, "anatomy ct")
            summary[state] = {key: entry(document, key, path) for key in ("method", "point_spread_fwhm_mm", "warnings")}
    if source and source[0] == "contours":
        said = entry(read_json(source[1], "anatomy contours"), "warnings", source[1])
        warnings = [{"code": "contours", "message": message} for message in said]
        summary["pre"] = {"method": "contours", "point_spread_fwhm_mm": None, "warnings": warnings}
    return summary


REGISTRATION_KEYS = (
    "method",
    "compare",
    "rotation_deg",
    "residual_mm",
    "usual_radius_mm",
    "share_of_both",
    "missing",
    "new",
)


def registration_summary(files, profile, segment):
    """The registration of the lumen after the real procedure to the lumen before: the keys REGISTRATION_KEYS.

    It also has `segment_mm`, the segment's length, and `covered_mm`, the length that the lumen after PCI covers.
    profile: the StateProfiles of the state `post`.
    """
    document = read_json(files.registration, "anatomy register")
    covered, length = covered_mm(profile, segment)
    return {key: entry(document, key, files.registration) for key in REGISTRATION_KEYS} | {
        "covered_mm": covered,
        "segment_mm": length,
    }


def covered_mm(profile, segment):
    """(length that a state covers, length of the segment) in mm before PCI.

    A station counts as covered if the state has sections on both sides of it.
    """
    length = segment.s_end_mm - segment.s_start_mm
    return float(profile.inside.mean() * length), float(length)


def warn_if_partly_covered(profile, segment):
    """Warns on standard error if the lumen after the real procedure ends within the segment."""
    covered, length = covered_mm(profile, segment)
    if profile.segment.line_ends_within:
        message = (
            f"the lumen after the procedure covers {covered:.1f} of the {length:.1f} mm of the treated segment and its"
        )
        print(f"{message} margins: every state is compared over that part only", file=sys.stderr, flush=True)


def common_stations(profiles, where):
    """Mask (n,) of the stations with sections on both sides in every state: all states are averaged over these.

    Raises ComputationError if fewer than half of the stations are left.
    """
    used = np.logical_and.reduce([profile.inside for profile in profiles.values()])
    if used.mean() < LEAST_COVERAGE:
        worst_state = min(profiles, key=lambda state: profiles[state].inside.sum())
        count = int(profiles[worst_state].inside.sum())
        remedy = f"{worst_state} has the fewest, {count}; at least half are wanted. The segment lies"
        remedy += " too near an end of the model, or beyond it: lengthen the vessel, or place the stent further in"
        raise ComputationError("too few stations can be compared", where, f"{int(used.sum())} of {len(used)}", remedy)
    return used


def state_document(profile, used):
    """The entry of one state in metrics.json, from its StateProfiles. used (n,): mask of the compared stations."""
    s_mm, segment = profile.s_mm[used], profile.segment
    area, curvature = profile.area_mm2[used], profile.curvature_per_mm[used]
    within = profile.sections[(profile.sections["s_mm"] >= s_mm[0]) & (profile.sections["s_mm"] <= s_mm[-1])]
    return {
        "segment": {
            "s_start_mm": segment.s_start_mm,
            "s_end_mm": segment.s_end_mm,
            "length_mm": segment.length_mm,
            "proximal_shift_mm": segment.proximal_shift_mm,
            "distal_shift_mm": segment.distal_shift_mm,
        },
        "s_mm": s_mm.tolist(),
        "area": {
            "mean_mm2": mean_over_length(area, s_mm),
            "minimum_mm2": float(min(area.min(), within["area_mm2"].min())),
            "profile_mm2": area.tolist(),
            "sections": len(within),
            "ostium_sections": int((within["flag"] == "ostium").sum()),
        },
        "curvature": {
            "mean_per_mm": mean_over_length(curvature, s_mm),
            "maximum_per_mm": float(curvature.max()),
            "mean_surveyed_per_mm": profile.anatomy_curvature_per_mm,
            "profile_per_mm": curvature.tolist(),
        },
        "ffr": None if profile.solution is None else ffr_document(profile, used),
    }


def ffr_document(profile, used):
    """The entry `ffr` of one state in metrics.json. used (n,): mask of the compared stations."""
    solution = profile.solution
    return {
        "distal": float(solution["ffr"]),
        "past_segment": None if profile.ffr is None or profile.segment.line_ends_within else float(profile.ffr[-1]),
        "at_wire": ffr_at_wire(solution),
        "profile": None if profile.ffr is None else profile.ffr[used].tolist(),
        "model": solution.get("model"),
        "error_estimate": ffr_error_estimate(solution),
        "reduced_model": (solution.get("reduced_model") or {}).get("ffr"),
    }


def profile_differences(a, b, used):
    """bias, sd and rmse of a - b along the segment for each quantity; rmse^2 = bias^2 + sd^2.

    a, b: StateProfiles; used (n,): mask of the compared stations. The entry `ffr` is None if one state has no FFR
    along the segment: it has no flow, or its FFR comes from the 1D network. `ffr_distal` is the difference at the
    distal probe, None only if a state has no FFR at all.
    """
    document, flow = {}, a.solution is not None and b.solution is not None
    for name in QUANTITIES:
        if name == "ffr" and (a.ffr is None or b.ffr is None):
            document[name] = None
            continue
        delta = (getattr(a, name) - getattr(b, name))[used]
        document[name] = {
            "bias": float(delta.mean()),
            "sd": float(delta.std()),
            "rmse": float(np.sqrt(np.mean(delta**2))),
        }
    document["ffr_distal"] = float(a.solution["ffr"]) - float(b.solution["ffr"]) if flow else None
    return document

"""Error estimate of FFR: the error that the mesh makes, and the effect of an artificial viscosity that is left."""

import dataclasses
import sys

import numpy as np

from common.errors import ComputationError
from flow.errors import error_field

# Each part of the dual-weighted residual may be wrong by this share of its value. Where the parts do not cancel, their
# sum was .5 to .8 of the true error. With a share of .5 the estimate was below the true error at Re 1,500, and for
# lesions of 80 and 85 % on four rings.
PART_UNCERTAINTY = 0.75
SAFETY_FACTOR = 1.5  # factor on the effect of the artificial viscosity
# Assumed order of the FFR error in the mesh width. The true error changes its sign and does not fall steadily with the
# number of rings (measured.md). So the difference of two meshes is no bound of the error; it shows how much FFR still
# depends on the mesh.
ASSUMED_ORDER = 2.0
LEAST_WIDTH_RATIO = 1.05  # two meshes are compared only if the ratio of their mesh widths, coarse over fine, is larger
INTERNAL_KEYS = ("probes", "basis")  # keys of an estimate that are not written to ffr.json


@dataclasses.dataclass
class EstimateBasis:
    """The flows and fields behind an estimate, from which errors.pointwise makes estimates at other places.

    field: errors.error_field.ErrorField, or None where it could not be solved for. pair: (fine, coarse, share), or None
    without a coarser mesh. fine and coarse are (sampler, outflows in m3/s). By Richardson's extrapolation the error of
    a quantity is share times its difference between fine and coarse.
    """

    field: object = None
    pair: object = None


def estimate_error(solved, document, tree, ffr_at_probes, coarser=None):
    """Error estimate of a SolvedMesh: {"ffr": at the probe `distal`, "probes": [at each probe], ...}, or None.

    solved, coarser: solvers.solved_mesh.SolvedMesh; document: content of boundary.json; tree: centreline tree without
    extensions; ffr_at_probes(sampler) -> FFR at the probes, `distal` first.

    The error by the mesh is the larger of two entries, `goal` and `mesh`. `goal` follows from the dual-weighted
    residual (`error_of_parts`). `mesh` is Richardson's extrapolation |fine - coarse| / (r^2 - 1) with the flow
    `coarser` on a coarser mesh, r^3 being the ratio of the numbers of cells. It needs the same eps in both flows, and
    an r above LEAST_WIDTH_RATIO.
    SAFETY_FACTOR times the effect of the artificial viscosity on FFR, the entry `artificial_viscosity`, is added. All
    these entries are values at `distal`. `goal` and this effect need linear solves. If these fail, `mesh` alone is the
    estimate. The estimate is then None if `mesh` is missing too, or if there is an artificial viscosity.
    """
    found, methods, parts, artificial = [], [], {}, None
    ratio, basis = 0.0, EstimateBasis()
    # another eps is another model: the two flows would not differ by the mesh alone
    if coarser and coarser.problem.artificial_viscosity == solved.problem.artificial_viscosity:
        ratio = _width_ratio(solved, coarser)
    try:
        parts_at_probes, basis.field = error_field.solve_error_field(solved, document, tree)
        parts_at_probes, artificial = parts_at_probes[:, :-1], parts_at_probes[:, -1]
        signed, sizes = parts_at_probes.sum(axis=1), np.abs(parts_at_probes).sum(axis=1)
        found.append(error_of_parts(parts_at_probes))
        methods.append(f"dual-weighted residual, and {PART_UNCERTAINTY:g} times the sizes of its parts")
        parts |= {"goal": float(found[0][0]), "goal_signed": float(signed[0]), "goal_sizes": float(sizes[0])}
    except ComputationError as error:
        print(f"no dual solution for the error estimate:\n{error}", file=sys.stderr, flush=True)
    if ratio > LEAST_WIDTH_RATIO:
        share = 1.0 / (ratio**ASSUMED_ORDER - 1)
        basis.pair = (solved.sampler, solved.outflows), (coarser.sampler, coarser.outflows), share
        ffr_fine, ffr_coarse = (np.asarray(ffr_at_probes(item.sampler)) for item in (solved, coarser))
        found.append(share * np.abs(ffr_fine - ffr_coarse))
        methods.append(f"two meshes, ratio of widths {ratio:.3f}, order {ASSUMED_ORDER:g}")
        values = {"mesh": found[-1], "ffr_coarse": ffr_coarse, "ffr_fine": ffr_fine}
        parts.update({key: float(value[0]) for key, value in values.items()})
    if not found:
        return None
    total = np.max(found, axis=0)
    if solved.problem.artificial_viscosity > 0:
        if artificial is None:  # two meshes of the same eps do not show its effect
            return None
        parts["artificial_viscosity"] = float(artificial[0])
        total = total + SAFETY_FACTOR * np.abs(artificial)
    method = ", ".join(methods)
    internal = {"probes": total.tolist(), "basis": basis}
    return {"ffr": float(total[0]), **parts, **internal, "method": method}


def error_of_parts(parts):
    """Estimated errors (p,) of FFR at p places from the parts (p, k) of errors.error_field.

    It is |sum of the parts| plus PART_UNCERTAINTY times the sum of |parts|, as each part may be wrong by that share.
    """
    return np.abs(parts.sum(axis=1)) + PART_UNCERTAINTY * np.abs(parts).sum(axis=1)


def shown_entries(estimate):
    """The entries of an estimate that ffr.json shows. They hold for the probe `distal`. None without an estimate."""
    return estimate and {key: value for key, value in estimate.items() if key not in INTERNAL_KEYS}


def _width_ratio(fine, coarse):
    """Ratio of the cells' widths, coarse over fine: the cube root of the ratio of the numbers of cells."""
    cells = [len(item.space.nodes()[1]) for item in (coarse, fine)]
    return (cells[1] / cells[0]) ** (1 / 3)

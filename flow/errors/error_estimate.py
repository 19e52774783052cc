"""Error estimate of FFR: what the mesh, and an artificial viscosity that is left, may have done to it."""

import dataclasses
import sys

import numpy as np

from common.errors import ComputationError
from flow.errors import error_field

# Share of itself by which each part of the dual-weighted residual may be off. Where they do not cancel it found .5 to
# .8 of the true error. With a share of .5 the estimate was below it at Re 1,500, and at 80 and 85 % on four rings.
PART_UNCERTAINTY = 0.75
SAFETY = 1.5  # times what an artificial viscosity does
SMALL_SHARE = 0.2  # of the tolerance: an artificial viscosity that takes no more of it may stay
# Assumed order of the FFR error in the mesh width. FFR's error does not fall steadily with the rings and changes its
# sign (measured.md), so the difference of two meshes is no bound: it says how much FFR still depends on the mesh.
ORDER = 2.0
LEAST_RATIO = 1.05  # of the mesh widths: below it two meshes say nothing
HIDDEN = ("probes", "basis")  # of an estimate, not written with it


@dataclasses.dataclass
class Basis:
    """What an estimate was made of: with it errors.pointwise makes it at other places.

    field: errors.error_field.Field of the steady flow, or None; pair: ((sampler, outflows) of the finer and of the
    coarser mesh, share of their difference), or None.
    """

    field: object = None
    pair: object = None


def of(solved, document, tree, at_probes, coarser=None):
    """{"ffr": total at the probe `distal`, "probes": totals at all, ...} of a solvers.solved_mesh.Solved, or None where
    too little is known.

    The mesh's part is the larger of `goal` (errors.error_field) and, with a Solved `coarser` of the same eps, of `mesh`
    (Richardson's). at_probes(sampler) -> FFR at the probes, `distal` first. `goal`: the size of the dual-weighted
    residual and PART_UNCERTAINTY times those of its parts (`of_parts`). `artificial_viscosity`: what it does to FFR,
    added with the safety factor. The parts are those of `distal`. Where the dual solution is not found two meshes
    alone estimate the error, if there are two and no artificial viscosity is left.
    """
    found, methods, parts, artificial = [], [], {}, None
    if coarser and coarser.problem.artificial != solved.problem.artificial:
        coarser = None  # flows of two models
    basis = Basis(None, _pair(solved, coarser))
    try:
        along, basis.field = error_field.of(solved, document, tree)
        along, artificial = along[:, :-1], along[:, -1]
        signed, sizes = along.sum(axis=1), np.abs(along).sum(axis=1)
        found.append(of_parts(along))
        methods.append(f"dual-weighted residual, and {PART_UNCERTAINTY:g} times the sizes of its parts")
        parts |= {"goal": float(found[0][0]), "goal_signed": float(signed[0]), "goal_sizes": float(sizes[0])}
    except ComputationError as error:
        print(f"no dual solution for the error estimate:\n{error}", file=sys.stderr, flush=True)
    richardson, compared = two_meshes(solved, coarser, at_probes) if coarser else (None, "")
    if richardson is not None:
        found.append(richardson["mesh"])
        methods.append(compared)
        parts.update({key: float(values[0]) for key, values in richardson.items()})
    if not found:
        return None
    total = np.max(found, axis=0)
    if solved.problem.artificial > 0:
        if artificial is None:  # two meshes know nothing of the artificial viscosity
            return None
        parts["artificial_viscosity"] = float(artificial[0])
        total = total + SAFETY * np.abs(artificial)
    method = ", ".join(methods)
    own = {"probes": total.tolist(), "basis": basis}
    return {"ffr": float(total[0]), **parts, **own, "method": method}


def may_stay(solved, document, tree, tolerance):
    """Whether the artificial viscosity of a Solved takes at most SMALL_SHARE of the tolerance of FFR at `distal`."""
    try:
        effect = error_field.of_artificial_viscosity(solved, document, tree)[0]
    except ComputationError:  # the factors do not fit the memory, say: then it is followed on
        return False
    return SAFETY * abs(effect) <= SMALL_SHARE * tolerance


def of_parts(along):
    """Estimates (p,) by the parts (p, k) of errors.error_field. Each may be off by PART_UNCERTAINTY of itself."""
    return np.abs(along.sum(axis=1)) + PART_UNCERTAINTY * np.abs(along).sum(axis=1)


def document(estimate):
    """The estimate at the probe `distal` alone, as in ffr.json; None stays."""
    return estimate and {key: value for key, value in estimate.items() if key not in HIDDEN}


def two_meshes(fine, coarse, at_probes):
    """({"mesh", "ffr_coarse", "ffr_fine"} at the probes, words): Richardson's estimate |fine - coarse| / (r^2 - 1), r^3
    the ratio of the numbers of cells; (None, "") below a ratio of 1.05."""
    ratio = _ratio(fine, coarse)
    if ratio <= LEAST_RATIO:
        return None, ""
    ffr_coarse, ffr_fine = (np.asarray(at_probes(item.sampler)) for item in (coarse, fine))
    mesh = np.abs(ffr_fine - ffr_coarse) / (ratio**ORDER - 1)
    words = f"two meshes, ratio of widths {ratio:.3f}, order {ORDER:g}"
    return {"mesh": mesh, "ffr_coarse": ffr_coarse, "ffr_fine": ffr_fine}, words


def _ratio(fine, coarse):
    """Of the widths of two meshes' cells."""
    cells = [len(item.space.nodes()[1]) for item in (coarse, fine)]
    return (cells[1] / cells[0]) ** (1 / 3)


def _pair(fine, coarse):
    """`pair` of a Basis; coarse may be None."""
    ratio = _ratio(fine, coarse) if coarse else 0.0
    if ratio <= LEAST_RATIO:
        return None
    return (fine.sampler, fine.outflows), (coarse.sampler, coarse.outflows), 1.0 / (ratio**ORDER - 1)

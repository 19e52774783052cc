"""Error estimate of FFR: what the mesh, and a jet viscosity that could not be taken away, may have done to it."""

import numpy as np

from flow import goal_error, locate

SAFETY = 1.5  # times the dual-weighted residual, which found .5 to .8 of the true error where its parts do not cancel
# Assumed order of the FFR error in the mesh width. FFR's error does not fall steadily with the rings and changes its
# sign (measured.md), so the difference of two meshes is no bound: it says how much FFR still depends on the mesh.
ORDER = 2.0
LEAST_RATIO = 1.05  # of the mesh widths: below it two meshes say nothing


def of(solved, document, tree, distal, coarser=None):
    """{"ffr": total, ...} of a flow.adaptive.Solved, or None where too little is known.

    The mesh's part is the larger of `goal` (flow.goal_error) and, with a Solved `coarser`, of `mesh` (Richardson's).
    distal(sampler) -> FFR at the probe `distal`. `goal`: the dual-weighted residual with its safety factor, or
    the sum of the sizes of its parts where they cancel.
    """
    along = goal_error.of(solved, document, tree)
    signed, sizes = float(along.sum()), float(np.abs(along).sum())
    parts = {"goal": max(SAFETY * abs(signed), sizes), "goal_signed": signed, "goal_sizes": sizes}
    if coarser:
        parts.update(two_meshes(solved, coarser, distal))
    total = of_mesh(parts)
    if solved.problem.mixing > 0:
        if len(solved.problem.passed) < 2:  # nothing to continue from: what is known of the mesh alone says too little
            return None
        parts["jet_mixing"] = jet_viscosity(solved, distal)
        total += parts["jet_mixing"]
    compared = "" if "mesh" not in parts else f", {parts.pop('method')}"
    method = f"dual-weighted residual times {SAFETY:g}, at least the sizes of its parts{compared}"
    return {"ffr": total, **parts, "method": method}


def of_mesh(parts):
    """The mesh's part of an estimate."""
    return max(parts["goal"], parts.get("mesh", 0.0))


def of_mean(steady, mixing, difference):
    """Estimate for the mean of a flow that changes in time: the mesh's part of `steady`, the estimate of the steady
    flow at c = mixing, and by how much the means of the two halves of its window differ; None where `steady` is None.
    """
    if steady is None:
        return None
    kept = ("goal", "goal_signed", "goal_sizes", "mesh", "ffr_coarse", "ffr_fine")
    parts = {key: steady[key] for key in kept if key in steady}
    total = of_mesh(parts) + difference
    method = f"of the mesh as in the steady flow at jet mixing {mixing:g}, plus the difference of half windows"
    return {"ffr": total, **parts, "mean": difference, "method": method}


def two_meshes(fine, coarse, distal):
    """Richardson's estimate |fine - coarse| / (r^2 - 1), r^3 the ratio of the numbers of cells; none below 1.05."""
    cells = [len(item.space.nodes()[1]) for item in (coarse, fine)]
    ratio = (cells[1] / cells[0]) ** (1 / 3)
    if ratio <= LEAST_RATIO:
        return {}
    ffr_coarse, ffr_fine = distal(coarse.sampler), distal(fine.sampler)
    return {
        "mesh": abs(ffr_fine - ffr_coarse) / (ratio**ORDER - 1),
        "ffr_coarse": ffr_coarse,
        "ffr_fine": ffr_fine,
        "method": f"two meshes, ratio of widths {ratio:.3f}, order {ORDER:g}",
    }


def jet_viscosity(solved, distal):
    """Change of FFR over the last c passed, continued in a straight line to c = 0."""
    (before, values_before, _), (last, values, _) = solved.problem.passed[-2:]
    found = [distal(locate.FieldSampler(solved.space, state)) for state in (values_before, values)]
    return abs(found[1] - found[0]) * last / (before - last)

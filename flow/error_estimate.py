"""Error estimate of FFR: what the mesh, and a jet viscosity that could not be taken away, may have done to it."""

from flow import locate

ORDER = 2.0  # assumed order of the FFR error in the mesh width: below what was observed, so the estimate errs upwards
LEAST_RATIO = 1.05  # of the mesh widths: below it two meshes say nothing


def of(fine, coarse, ffr_fine, distal):
    """{"ffr": total, ...}, or None where nothing is known; fine, coarse: flow.solve.Solved, coarse may be None.

    distal(sampler) -> FFR at the probe `distal`.
    """
    parts = {}
    if coarse:
        parts.update(_mesh(fine, coarse, ffr_fine, distal(coarse.sampler)))
    if fine.problem.mixing > 0:
        if len(fine.problem.passed) < 2:  # nothing to continue from: what is known of the mesh alone says too little
            return None
        parts["jet_mixing"] = _jet(fine, distal)
    known = [parts[name] for name in ("mesh", "jet_mixing") if name in parts]
    return {"ffr": sum(known), **parts} if known else None


def _mesh(fine, coarse, ffr_fine, ffr_coarse):
    """Richardson's estimate |fine - coarse| / (r^2 - 1), r^3 the ratio of the numbers of cells; none below 1.05."""
    cells = [len(item.space.nodes()[1]) for item in (coarse, fine)]
    ratio = (cells[1] / cells[0]) ** (1 / 3)
    if ratio <= LEAST_RATIO:
        return {}
    return {
        "mesh": abs(ffr_fine - ffr_coarse) / (ratio**ORDER - 1),
        "ffr_coarse": ffr_coarse,
        "ffr_fine": ffr_fine,
        "method": f"two meshes, ratio of widths {ratio:.3f}, order {ORDER:g}",
    }


def _jet(fine, distal):
    """Change of FFR over the last c passed, continued in a straight line to c = 0."""
    (before, values_before, _), (last, values, _) = fine.problem.passed[-2:]
    found = [distal(locate.FieldSampler(fine.space, state)) for state in (values_before, values)]
    return abs(found[1] - found[0]) * last / (before - last)

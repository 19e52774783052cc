"""The steps of an intervention in one slice: inflate, then deflate; a stent stays."""

import numpy as np

DEFLATION_STEPS = 5  # load steps in which the balloon's pressure is replaced by the stent's
CONTACT_GAP_MM = 0.1  # beyond this gap to the wall the smoothed pressure law of a balloon gives no pressure


def transfer_to_stent(model, where):
    """Replaces the balloon's pressure by the stent's, in DEFLATION_STEPS load steps. where: for messages."""
    start = model.loads()
    for share in np.linspace(0, 1, DEFLATION_STEPS + 1)[1:]:
        stent_share = start["stent_share"] + share * (1 - start["stent_share"])
        model.advance({"balloon_share": start["balloon_share"] * (1 - share), "stent_share": stent_share}, where)


def deflate(model, nearest_mm, step_mm, where):
    """Lowers the balloon's radius until it has left the wall, then removes the balloon.

    Lowering its pressure instead fails: below some pressure soft plaque in a stretched wall collapses, and no load step
    is small enough. nearest_mm(): function that gives the least distance (mm) of the lumen from the axis.
    """
    radius = model.loads()["balloon_radius"]
    while model.loads()["balloon_share"] and radius > 0 and radius > nearest_mm() - CONTACT_GAP_MM:
        radius = max(radius - step_mm, 0.0)
        model.advance({"balloon_radius": radius}, where)
    model.advance({"balloon_share": 0.0}, where)


def run_procedure(model, steps, s_mm, settings, stented, branch_name):
    """Runs the steps of the procedure in a placed SliceModel at arc length s_mm of the branch.

    stented: whether stents hold at this slice. Returns a list of {step, inflated_radius_mm, radius_mm}: the radii
    of circles of the lumen's area at full inflation and after deflation. Raises ComputationError if a load step does
    not converge.
    """
    history = []
    held_radius = 0.0
    model.set_loads({key: 0.0 for key in ("balloon_share", "stent_share", "pressure")})
    # The laws are evaluated even at share 0. With a stiffness and a cap of 0 they would be 0 / 0.
    model.set_loads(dict.fromkeys(("balloon_radius", "stent_radius"), 0.0))
    model.set_loads(dict.fromkeys(("balloon_stiffness", "balloon_cap", "stent_stiffness", "stent_cap"), 1.0))
    stent = None
    for step in steps:
        where = f"slice at s = {s_mm:.2f} mm of {branch_name}, step {step.name}"
        if step.stent and step.stent.covers(s_mm) and stented:
            stent = step.stent
        radius = step.free_radius(float(step.balloon.radius_at(s_mm)), stent)
        distance = np.linalg.norm(model.lumen_position(), axis=1)
        start = max(float(distance.min()) - 0.05, 0.0)
        if radius > start:
            model.set_loads(
                {
                    "balloon_radius": start,
                    "balloon_stiffness": step.balloon.stiffness_mpa_per_mm,
                    "balloon_cap": step.cap_mpa(_lumen_radius(model), stent),
                    "balloon_share": 1.0,
                }
            )
            count = max(int(np.ceil((radius - start) / settings["radius_step_mm"])), 1)
            for value in np.linspace(start, radius, count + 1)[1:]:
                cap = step.cap_mpa(_lumen_radius(model), stent)
                model.advance({"balloon_radius": float(value), "balloon_cap": cap}, where)
        inflated = _lumen_radius(model)
        if stent:
            # The stent lies between balloon and lumen. So it opens no further than the balloon's free radius, or than
            # the lumen.
            held_radius = max(held_radius, stent.recoil_share * min(inflated, radius))
            model.set_loads(
                {
                    "stent_radius": held_radius,
                    "stent_stiffness": settings["stent_stiffness_mpa_per_mm"],
                    "stent_cap": stent.cap_mpa,
                }
            )
        if stent:
            transfer_to_stent(model, where)
        else:
            deflate(
                model, lambda: np.linalg.norm(model.lumen_position(), axis=1).min(), settings["radius_step_mm"], where
            )
        history.append({"step": step.name, "inflated_radius_mm": inflated, "radius_mm": _lumen_radius(model)})
    return history


def _lumen_radius(model):
    """Radius (mm) of the circle with the lumen's area."""
    return float(np.sqrt(model.lumen_area() / np.pi))

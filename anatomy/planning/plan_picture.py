"""A picture of a plan: the lumen along each treated branch, its reference and lesions, and each device's place."""

import numpy as np
from matplotlib import pyplot as plt

from common.documents import plan_reader

from .. import picture_file
from ..lumen_results import read_sections, read_summary
from . import catalogue, outer_wall
from .plan import HEALTHY_PROFILE, OUTER_WALL
from .profile import Profile

WIDTH_INCHES, HEIGHT_INCHES, LANE_INCHES = (
    11,  # width of the picture
    4.2,  # height of the plot of a branch's diameters
    0.32,  # height of the line of one device above the plot
)


def run(anatomy_folder, plan_file, out):
    """Writes the picture to the path `out` (.png or .svg).

    anatomy_folder: folder made by `lumen process`. plan_file: plan.json for the lumen of this folder.
    """
    picture_file.check_format(out)
    summary, sections, plan = read_summary(anatomy_folder), read_sections(anatomy_folder), plan_reader.read(plan_file)
    by = plan.get("reference", {}).get("by", HEALTHY_PROFILE)
    if by == OUTER_WALL:
        sections = outer_wall.with_lumen_and_plaque_reference(sections, anatomy_folder / "lumen.vtp")
    placed = _devices_by_branch(plan)
    heights = [HEIGHT_INCHES + LANE_INCHES * len(devices) for devices in placed.values()]
    figure, axes = plt.subplots(
        len(placed), 1, figsize=(WIDTH_INCHES, sum(heights)), height_ratios=heights, squeeze=False, layout="constrained"
    )
    for axis, (branch, devices) in zip(axes[:, 0], placed.items()):
        _draw(axis, summary, sections, branch, devices, by)
    axes[0, 0].set_title(plan.get("case", ""), loc="left")
    picture_file.save(figure, out)


def _devices_by_branch(plan):
    """{branch: [(label, start, end, diameter at the device's pressure, kind)]} of a plan's devices; lengths in mm."""
    found = {}
    for step in plan["procedure"]:
        for device in step["devices"]:
            entry = plan["devices"][device["device"]]
            half = entry["length_mm"] / 2
            span = (device["centre_s_mm"] - half, device["centre_s_mm"] + half)
            balloon = plan_reader.inflating_balloon(plan["devices"], device["device"])
            wide = catalogue.diameter_at(balloon, device["pressure_bar"])
            label = f"{step['name']}: {device['device']}, {device['pressure_bar']:g} bar"
            found.setdefault(device["branch"], []).append((label, *span, wide, entry["kind"]))
    return found


def _draw(axes, summary, sections, branch, devices, by):
    profile = Profile(summary, sections, branch)
    axes.plot(profile.s, profile.diameter, color="k", lw=1.6, label="lumen (diameter of equal area)")
    low, high = np.array([[row["min_diameter_mm"], row["max_diameter_mm"]] for row in sections[branch]]).T
    axes.fill_between(profile.s, low, high, color="0.85", lw=0, label="smallest to largest chord")
    axes.plot(profile.s, profile.reference, "--", color="seagreen", lw=1.2, label=f"reference ({by})")
    axes.plot(profile.s, 0.7 * profile.reference, ":", color="crimson", lw=1.0, label="30 % narrower")
    for name, (start, end) in profile.mouths.items():
        axes.axvspan(start, end, color="gold", alpha=0.2, lw=0)
        axes.text((start + end) / 2, 0.02, name, ha="center", fontsize=7, transform=axes.get_xaxis_transform())
    top = max(float(high.max()), max(device[3] for device in devices)) * 1.05
    for lesion in (lesion for lesion in summary["lesions"] if lesion["branch"] == branch):
        axes.axvspan(lesion["s_start_mm"], lesion["s_end_mm"], color="crimson", alpha=0.06, lw=0)
        text = f"{lesion['name']} {profile.stenosis_at(lesion['s_mla_mm']):.0f} %"
        axes.annotate(text, (lesion["s_mla_mm"], lesion["mld_mm"]), (0, -12), textcoords="offset points",
                      ha="center", fontsize=8, color="crimson")  # fmt: skip
    for lane, (label, start, end, wide, kind) in enumerate(devices):
        colour = "tab:blue" if kind == "stent" else "0.5"
        at = top + 0.3 + 0.35 * lane
        axes.plot([start, end], [at, at], lw=5 if kind == "stent" else 2.5, color=colour, solid_capstyle="butt")
        axes.text(end + 0.5, at, f"{label}: {wide:.2f} mm", fontsize=7.5, va="center", color=colour)
        if kind == "stent":
            axes.plot([start, start, end, end], [0, wide, wide, 0], color=colour, lw=0.8, alpha=0.7)
    axes.set_ylim(0, top + 0.3 + 0.35 * len(devices))
    axes.set(xlabel=f"s along {branch} (mm)", ylabel="diameter (mm)")
    axes.margins(x=0.01)
    axes.legend(fontsize=7, loc="lower left")

"""A picture of the measured tree: its sections, names and lesions, and the diameter along each branch."""

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import LineCollection

from . import picture_file
from .lumen_results import read_sections, read_summary

POSITION = ("x_mm", "y_mm", "z_mm")
WIDTH_INCHES, LEAST_TREE_INCHES = 10, 3.0  # width of the picture, least height of the tree
PROFILE_INCHES, LEAST_PROFILE_INCHES = 4.5, 2.0  # height of the plot of one branch's diameters: alone, and among many


def run(anatomy_folder, out):
    """Writes the picture of a folder made by `lumen process` to the path `out` (.png or .svg)."""
    picture_file.check_format(out)
    summary, branches = read_summary(anatomy_folder), read_sections(anatomy_folder)
    project = _projection(np.vstack([_column(rows, *POSITION) for rows in branches.values()]))
    height = _tree_height_inches(project, branches)
    groups = _groups_of_branches(summary, branches)
    heights = [height] + [max(LEAST_PROFILE_INCHES, PROFILE_INCHES / len(groups))] * len(groups)
    figure, (tree, *profiles) = plt.subplots(
        len(heights), 1, figsize=(WIDTH_INCHES, sum(heights)), height_ratios=heights, layout="constrained"
    )
    figure.get_layout_engine().set(h_pad=0.1)
    labels = _draw_tree(figure, tree, project, summary, branches)
    _draw_profiles(profiles, groups, summary, branches)
    _place_labels(figure, tree, labels)
    picture_file.save(figure, out, dpi=130)


def _tree_height_inches(project, branches):
    """Height in inches, at least LEAST_TREE_INCHES, at which the tree fills its part of the picture."""
    points = project(np.vstack([_column(rows, *POSITION) for rows in branches.values()]))
    thick = max(row["equivalent_diameter_mm"] for rows in branches.values() for row in rows)
    width, height = np.ptp(points, axis=0) + thick
    return max(LEAST_TREE_INCHES, float(0.85 * WIDTH_INCHES * height / width))


def _projection(points):
    """Function that projects points on the plane of the two largest principal axes of `points` (n, 3).

    It returns (k, 2) for (k, 3). A principal axis may point either way. Its sign is chosen by a fixed rule, so that the
    same tree always has the same view.
    """
    centre = points.mean(axis=0)
    axes = np.linalg.svd(points - centre, full_matrices=False)[2][:2]
    axes *= np.sign(axes[np.arange(2), np.abs(axes).argmax(axis=1)])[:, None]
    return lambda p: (np.atleast_2d(p) - centre) @ axes.T


def _column(rows, *names):
    """Columns `names` of a table of sections as an array (rows, names)."""
    return np.array([[row[name] for name in names] for row in rows])


def _draw_tree(figure, axes, project, summary, branches):
    diameters = np.concatenate([_column(rows, "equivalent_diameter_mm")[:, 0] for rows in branches.values()])
    colours = matplotlib.colors.Normalize(diameters.min(), diameters.max())
    labels, wall = [], []
    for name, rows in branches.items():
        lines, drawn = _draw_branch(axes, project, rows, colours)
        x = project(_column(rows, *POSITION))
        wall.append(drawn)
        labels.append((_label(axes, name, x[len(x) // 3], fontsize=11, weight="bold"), 45))
    _draw_take_offs(axes, project, summary, branches)
    for number, lesion in enumerate(summary["lesions"], 1):
        labels.append((_draw_lesion(axes, project, number, lesion, branches[lesion["branch"]]), -120))
    middle = project(np.mean([end["centre_mm"] for end in summary["ends"]], axis=0))[0]
    for end in summary["ends"]:
        where = project(np.array(end["centre_mm"]))[0]
        axes.plot(*where, "s" if end["kind"] == "inlet" else "o", color="k", ms=6, zorder=4)
        text = f"{end['name']} ({end['diameter_mm']:.2f} mm)"
        labels.append((_label(axes, text, where, fontsize=9), 180 if where[0] < middle[0] else 0))  # away from the tree
    figure.colorbar(lines, ax=axes, label="equivalent diameter (mm)", fraction=0.03, shrink=0.7)
    axes.set(aspect="equal", xlabel="mm", ylabel="mm", title="tree, sections and lesions (plane of largest extent)")
    axes.margins(0.25, 0.25)
    return [(label, angle, np.vstack(wall)) for label, angle in labels]


def _place_labels(figure, axes, labels):
    """Moves labels so that they cover neither each other nor the vessel.

    labels: [(annotation, preferred angle in degrees, points of the vessel (k, 2))]. A label goes to the nearest free
    place round its point. 16 directions are tried, the preferred one first. Without a free place the label goes where
    it covers least.
    """
    figure.draw_without_rendering()
    renderer, placed_boxes = figure.canvas.get_renderer(), []
    for label, preferred, wall in labels:
        vessel_pixels = axes.transData.transform(wall)
        box = label.get_window_extent(renderer)
        centre = axes.transData.transform(label.xy)
        size, best = np.array([box.width, box.height]) * 0.5 + 2, None
        for distance in (12, 22, 34, 50, 70):
            for turn in range(16):
                angle = np.radians(preferred + 22.5 * ((turn + 1) // 2) * (-1) ** turn)
                direction = np.array([np.cos(angle), np.sin(angle)])
                # The distance is measured to the label's rim, not to its middle.
                reach = min(size / np.maximum(np.abs(direction), 1e-9))
                middle = centre + (reach + distance * figure.dpi / 72) * direction
                low, high = middle - size, middle + size
                overlap = sum(bool((low < b).all() and (high > a).all()) for a, b in placed_boxes)
                overlap = 1000 * overlap + int(
                    ((vessel_pixels > low - 4) & (vessel_pixels < high + 4)).all(axis=1).sum()
                )
                if best is None or overlap < best[0]:
                    best = (overlap, middle)
            if best[0] == 0:
                break
        placed_boxes.append((best[1] - size, best[1] + size))
        label.set_position((best[1] - centre) * 72 / figure.dpi)


def _draw_branch(axes, project, rows, colours):
    """Draws a branch: its silhouette, its axis, and its sections coloured by diameter.

    Returns the LineCollection of the sections, and points (k, 2) that the branch covers. colours: the colour scale.
    """
    x = project(_column(rows, *POSITION))
    radius = _column(rows, "equivalent_diameter_mm") / 2
    along = np.gradient(x, axis=0)
    across = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(np.linalg.norm(along, axis=1), 1e-9)[:, None]
    left, right = x - radius * across, x + radius * across
    axes.fill(*np.vstack([left, right[::-1]]).T, color="0.9", ec="0.6", lw=0.6, zorder=0)
    lines = LineCollection(np.stack([left, right], axis=1), cmap="viridis", norm=colours, linewidths=1.4)
    lines.set_array(2 * radius[:, 0])
    axes.add_collection(lines)
    axes.plot(*x.T, color="k", lw=0.8)
    _label_arc_length(axes, rows, x)
    return lines, np.vstack([left, 0.5 * (left + x), x, 0.5 * (x + right), right])


def _draw_take_offs(axes, project, summary, branches):
    """Draws a dotted line from each side branch's first section to the place on its parent's axis where it leaves."""
    for branch in summary.get("branches", ()):
        if branch["parent"] is None or not {branch["name"], branch["parent"]} <= branches.keys():
            continue
        root = min(branches[branch["parent"]], key=lambda row: abs(row["s_mm"] - branch["s_on_parent_mm"]))
        ends = project(_column([root, branches[branch["name"]][0]], *POSITION))
        axes.plot(*ends.T, ":", color="k", lw=0.9)


def _draw_lesion(axes, project, number, lesion, rows):
    part = [r for r in rows if lesion["s_start_mm"] <= r["s_mm"] <= lesion["s_end_mm"]]
    axes.plot(*project(_column(part, *POSITION)).T, color="crimson", lw=3, zorder=3)
    throat = min(rows, key=lambda r: abs(r["s_mm"] - lesion["s_mla_mm"]))
    where = project(_column([throat], *POSITION))[0]
    text = f"lesion {number}: {lesion['diameter_stenosis_percent']:.0f} %"
    return _label(axes, text, where, color="crimson", arrowprops={"arrowstyle": "-", "color": "crimson"})


def _label(axes, text, where, **style):
    """Writes a text centred on a point `where` (2,). Returns the annotation, which _place_labels() moves aside."""
    box = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.75}
    style = {"textcoords": "offset points", "ha": "center", "va": "center", "zorder": 5, **style}
    return axes.annotate(text, where, xytext=(0, 0), bbox=box, annotation_clip=False, **style)


def _label_arc_length(axes, rows, x):
    s = _column(rows, "s_mm")[:, 0]
    for mark in np.arange(10, s[-1], 10):
        i = np.abs(s - mark).argmin()
        axes.plot(*x[i], ".", color="k", ms=5)
        axes.annotate(f"{mark:.0f}", x[i], xytext=(3, -9), textcoords="offset points", fontsize=7)


def _groups_of_branches(summary, branches):
    """Names of the branches whose diameters share a plot: each branch with a lesion alone, all others together."""
    narrowed = {lesion["branch"] for lesion in summary["lesions"]}
    others = [name for name in branches if name not in narrowed]
    return [[name] for name in branches if name in narrowed] + ([others] if others else [])


def _draw_profiles(profiles, groups, summary, branches):
    """Draws the diameters along the branches of each group in its own axes, with the same scales in all."""
    for axes, names in zip(profiles, groups):
        for name in names:
            _draw_profile(axes, name, branches[name])
        lesions = [(k, lesion) for k, lesion in enumerate(summary["lesions"], 1) if lesion["branch"] in names]
        for place, (number, lesion) in enumerate(sorted(lesions, key=lambda one: one[1]["s_mla_mm"])):
            _draw_lesion_span(axes, number, lesion, label_row=place % 2)
        axes.legend(loc="upper right")
        axes.set_ylabel("mm")
        axes.sharex(profiles[0])
        axes.sharey(profiles[0])
        axes.tick_params(labelbottom=axes is profiles[-1])
    profiles[0].set_ylim(bottom=0)
    profiles[0].set_title("equivalent diameter; band: smallest to largest chord; x ostium, | end; dashed: reference")
    profiles[-1].set_xlabel("s (mm)")


def _draw_profile(axes, name, rows):
    s, diameter = _column(rows, "s_mm", "equivalent_diameter_mm").T
    (line,) = axes.plot(s, diameter, lw=1.6, label=name)
    axes.fill_between(
        s, *_column(rows, "min_diameter_mm", "max_diameter_mm").T, color=line.get_color(), alpha=0.15, lw=0
    )
    for flag, marker in (("ostium", "x"), ("end", "|")):
        marked = [r for r in rows if r["flag"] == flag]
        if marked:
            axes.plot(*_column(marked, "s_mm", "equivalent_diameter_mm").T, marker, color=line.get_color(), ms=4)


def _draw_lesion_span(axes, number, lesion, label_row):
    """Shades a lesion and writes its stenosis below the throat, in the lower (0) or the upper (1) row of labels."""
    span = (lesion["s_start_mm"], lesion["s_end_mm"])
    axes.axvspan(*span, color="crimson", alpha=0.08)
    references = (lesion["proximal_reference_diameter_mm"], lesion["distal_reference_diameter_mm"])
    axes.plot(span, references, "--", color="crimson")
    text = f"{number}: {lesion['diameter_stenosis_percent']:.0f} %"
    where = (lesion["s_mla_mm"], 0.03 + 0.09 * label_row)
    axes.text(*where, text, ha="center", fontsize=8, color="crimson", transform=axes.get_xaxis_transform())

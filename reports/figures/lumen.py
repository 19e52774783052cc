"""Shaded pictures of the lumen before and after, coloured by FFR, with the stent in place."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from scipy.spatial import cKDTree

from reports.figures.style import LABELS, save_figure
from reports.inputs.case_files import states_in_3d
from reports.inputs.reading import read_table
from reports.measuring.profiles import PULLBACK_NUMBERS
from reports.inputs.surface import read_device, read_lumen

MOST_TRIANGLES = 9000
LIGHT_DIRECTION = np.array([0.35, 0.45, 0.82]) / np.linalg.norm(
    [0.35, 0.45, 0.82]
)  # towards the light, in the view's axes
AMBIENT_BRIGHTNESS = 0.35  # brightness of a triangle that no light falls on
FAR_WALL_OPACITY, NEAR_WALL_OPACITY = 1.0, 0.30  # opacity of the wall; struts are visible through the near wall
COLOUR_MAP = "viridis"
NO_FFR_COLOUR = (0.75, 0.75, 0.75, 1.0)  # colour of a lumen without FFR
FIGURE_WIDTH = 10.0  # inches
SCALE_BAR_MM = 10.0


def lumen_figure(files, metrics, folder):
    """Writes <case>_lumen.{svg,png}: one panel for each state, all in the same view and scale.

    Each lumen is coloured by FFR. The lumen after virtual PCI also shows the stents.
    """
    states = states_in_3d(metrics["states"])
    surfaces = {state: read_lumen(files.lumen(state), MOST_TRIANGLES) for state in states}
    values = {state: nearest_ffr(files, state, surfaces[state].points) for state in states if files.has_flow(state)}
    scale = Normalize(min(0.8, min(v.min() for v in values.values())), 1.0)
    devices = [device for device in map(read_device, files.strut_files()) if device] if "vci" in states else []
    axes3 = view_axes(surfaces["pre"].points)
    low = np.min([(s.points @ axes3.T).min(0) for s in surfaces.values()], axis=0)[:2] - 1.0
    high = np.max([(s.points @ axes3.T).max(0) for s in surfaces.values()], axis=0)[:2] + 1.0
    width, height = high - low
    rows, columns, size = panel_grid(len(states), width / height)
    figure, grid = plt.subplots(rows, columns, figsize=size, squeeze=False)
    for axes in grid.ravel():
        axes.set_axis_off()
    for axes, state in zip(grid.ravel(), states):
        draw_lumen(axes, surfaces[state], values.get(state), scale, axes3, devices if state == "vci" else [])
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        ffr = metrics["states"][state]["ffr"]
        axes.set_title(f"{LABELS[state]}   " + (f"FFR {ffr['distal']:.2f}" if ffr else "(areas only)"))
    draw_scale_bar(grid.ravel()[len(states) - 1], low)
    mappable = plt.cm.ScalarMappable(scale, COLOUR_MAP)
    bar = figure.colorbar(mappable, ax=grid, shrink=0.6, aspect=30, pad=0.01)
    bar.set_label("FFR")
    bar.outline.set_visible(False)
    save_figure(figure, folder, f"{metrics['case']}_lumen")


def panel_grid(count, aspect):
    """(rows, columns, figure size in inches) for `count` panels. aspect: width / height of a panel.

    The number of columns is chosen so that the figure is nearly 16:9 and few places stay empty.
    """
    best = None
    for columns in range(1, count + 1):
        rows = -(-count // columns)
        penalty = abs(np.log(columns * aspect / rows / (16 / 9))) + 2.0 * np.log(rows * columns / count)
        if best is None or penalty < best[0]:
            best = (penalty, rows, columns)
    _, rows, columns = best
    return rows, columns, (FIGURE_WIDTH, (FIGURE_WIDTH - 1.0) / columns / aspect * rows + 0.35 * rows)


def nearest_ffr(files, state, points):
    """FFR (n,) at points (n, 3) in mm of a state's lumen, from the nearest point of pullback.csv in any branch."""
    table = read_table(files.flow(state) / "pullback.csv", PULLBACK_NUMBERS, ("branch",), "flow solve")
    _, nearest = cKDTree(table[["x_mm", "y_mm", "z_mm"]].to_numpy()).query(points)
    return table["ffr"].to_numpy()[nearest]


def view_axes(points):
    """Right-handed axes of the view, the rows of a (3, 3) array, for a vessel's points (n, 3).

    x lies along the vessel's longest extent. z lies along its least extent and points at the viewer. The points
    themselves fix the signs, so that the same vessel is always seen from the same side.
    """
    centred = points - points.mean(0)
    _, vectors = np.linalg.eigh(centred.T @ centred)
    axes3 = vectors.T[::-1].copy()
    for axis in axes3[:2]:
        skewness = np.sum((centred @ axis) ** 3)
        largest = axis[np.abs(axis).argmax()]
        # A symmetric vessel has no skewness. Then the axis' largest component fixes the sign.
        if (skewness if abs(skewness) > 1e-6 * np.sum(np.abs(centred @ axis) ** 3) else largest) < 0:
            axis *= -1.0
    axes3[2] = np.cross(axes3[0], axes3[1])
    return axes3


def draw_lumen(axes, surface, values, scale, axes3, devices):
    """Draws the far wall, the devices and the see-through near wall, each from back to front.

    values (n,): FFR at the surface's points; without them the wall is grey. axes3 (3, 3): see view_axes.
    """
    colours = np.full((len(surface.triangles), 4), NO_FFR_COLOUR)
    if values is not None:
        colours = plt.get_cmap(COLOUR_MAP)(scale(values[surface.triangles].mean(1)))
    wall = project_triangles(surface, axes3)
    draw_triangles(axes, wall, ~wall["near"], colours, FAR_WALL_OPACITY)
    for device in devices:
        strut = project_triangles(device, axes3)
        grey = np.full((len(device.triangles), 4), [0.16, 0.16, 0.2, 1.0])
        draw_triangles(axes, strut, strut["near"], grey, 1.0)
    draw_triangles(axes, wall, wall["near"], colours, NEAR_WALL_OPACITY if devices else 1.0)


def project_triangles(surface, axes3):
    """{corners (m, 3, 2), depth (m,), shade (m,), near (m,)} of the triangles of a Surface, seen along axes3[2].

    corners and depth are in mm, in the axes of the view. shade: brightness, 0 to 1. near: whether a triangle faces the
    viewer.
    """
    corners = (surface.points @ axes3.T)[surface.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    shade = AMBIENT_BRIGHTNESS + (1.0 - AMBIENT_BRIGHTNESS) * np.abs(normal @ LIGHT_DIRECTION)
    return {"corners": corners[:, :, :2], "depth": corners[:, :, 2].mean(1), "shade": shade, "near": normal[:, 2] > 0}


def draw_triangles(axes, projected, mask, colours, opacity):
    """Draws the triangles of `mask` (m,), furthest first. projected: result of project_triangles; colours (m, 4): rgba.

    The SVG holds them as one image of pixels, since thousands of shapes would make a huge file.
    """
    rows = np.flatnonzero(mask)
    rows = rows[np.argsort(projected["depth"][rows], kind="stable")]
    faces = colours[rows].copy()
    faces[:, :3] *= projected["shade"][rows, None]
    faces[:, 3] = opacity
    edges = faces if opacity == 1.0 else "none"  # edges close the thin gaps between opaque triangles
    axes.add_collection(
        PolyCollection(projected["corners"][rows], facecolors=faces, edgecolors=edges, linewidths=0.3, rasterized=True)
    )


def draw_scale_bar(axes, low):
    """Draws a bar of length SCALE_BAR_MM at the lower left corner `low` of a view (x and y in mm)."""
    axes.plot([low[0], low[0] + SCALE_BAR_MM], [low[1] + 0.3] * 2, color="#333333", linewidth=2, solid_capstyle="butt")
    axes.annotate(f"{SCALE_BAR_MM:g} mm", (low[0] + SCALE_BAR_MM, low[1] + 0.3), (4, 0), textcoords="offset points")
    axes.texts[-1].set(va="center", fontsize=8.5, color="#333333")

"""Figure of the stations, the cross-sections at which states are compared, on the vessel before and after PCI."""

import matplotlib.pyplot as plt
import numpy as np

from reports.figures.lumen import draw_lumen, draw_scale_bar, view_axes
from reports.figures.style import COLOURS, LABELS, save_figure
from reports.inputs.polyline import read_centreline
from reports.inputs.surface import read_lumen

STATES = ("pre", "vci", "reference", "post")
SHOWN_STATIONS = 10  # about this many stations are drawn, evenly spaced along the segment
MOST_TRIANGLES = 6000
MARGIN_MM, LABEL_MM = 4.0, 0.9  # length of vessel shown beyond the segment; gap between a section's line and its label
FIGURE_WIDTH, LARGEST_PANEL_HEIGHT = 7.6, 3.6  # inches
TANGENT_STEP_MM = 0.5  # the axis' direction at a station is measured between points this far to either side
LINE_LENGTH_FACTOR = 1.25  # length of a section's line as a multiple of the lumen's diameter
LABEL_SIZE_INCHES = np.array([0.52, 0.27])  # width and height of a label of two lines
LABEL_STEP_MM, MOST_LABEL_STEPS = 0.2, 40  # a label that covers another one is moved out by such steps


def stations_figure(files, metrics, folder):
    """Writes <case>_stations.{svg,png}: a panel for each state, with distance and area written at some stations."""
    states = [state for state in STATES if state in metrics["states"]]
    chosen = np.unique(np.linspace(0, metrics["stations"]["used"] - 1, SHOWN_STATIONS + 1).round().astype(int))
    marks = {state: station_marks(files, metrics, state, chosen) for state in states}
    axes3 = view_axes(np.concatenate([mark["points"] for mark in marks.values()]))
    flat = np.concatenate([mark["points"] @ axes3.T for mark in marks.values()])
    low, high = flat.min(0)[:2] - MARGIN_MM, flat.max(0)[:2] + MARGIN_MM
    height = min(LARGEST_PANEL_HEIGHT, FIGURE_WIDTH * (high - low)[1] / (high - low)[0] + 0.3)
    figure, grid = plt.subplots(len(states), 1, figsize=(FIGURE_WIDTH, height * len(states)), squeeze=False)
    for axes, state in zip(grid[:, 0], states):
        axes.set_axis_off()
        draw_lumen(axes, read_lumen(files.lumen(state), MOST_TRIANGLES), None, None, axes3, [])
        mm_per_inch = max((high - low) / (FIGURE_WIDTH, height))
        draw_sections(axes, marks[state], axes3, COLOURS[state], LABEL_SIZE_INCHES * mm_per_inch)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", title=LABELS[state])
    draw_scale_bar(grid[-1, 0], low + 0.3)
    save_figure(figure, folder, f"{metrics['case']}_stations")


def station_marks(files, metrics, state, chosen):
    """{points (n, 3), tangents (n, 3), area_mm2 (n,), distance_mm (n,)} of some stations on a state's axis.

    chosen (n,): indices of the stations. distance_mm: distance from the proximal end of the segment, along the vessel
    before PCI.
    """
    line = read_centreline(files.anatomy(state) / "centreline.vtp", metrics["segment"]["branch"])
    entry, segment = metrics["states"][state], metrics["segment"]
    s = np.array(entry["s_mm"])[chosen]
    length = segment["s_end_mm"] - segment["s_start_mm"]
    return {
        "points": line.point_at(s),
        "tangents": line.point_at(s + TANGENT_STEP_MM) - line.point_at(s - TANGENT_STEP_MM),
        "area_mm2": np.array(entry["area"]["profile_mm2"])[chosen],
        "distance_mm": length * np.array(metrics["stations"]["relative_position"])[chosen],
    }


def draw_sections(axes, marks, axes3, colour, label_size_mm):
    """Draws a line across the vessel at each station; beside it the distance along the segment and the area.

    marks: result of `station_marks`. axes3 (3, 3): the axes of the view. label_size_mm (2,): width and height of a
    label. A label that would cover an earlier one is moved on along its line, which is drawn on up to it.
    """
    points, tangents = marks["points"] @ axes3.T, marks["tangents"] @ axes3.T
    across = np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    across *= np.where(across[:, 1:] < 0, -1.0, 1.0)  # labels above the vessel
    half = LINE_LENGTH_FACTOR * np.sqrt(marks["area_mm2"] / np.pi)
    rows = zip(points[:, :2], across, half, marks["area_mm2"], marks["distance_mm"])
    placed = []
    for point, direction, half_length, area, distance in rows:
        ends = np.array([point - half_length * direction, point + half_length * direction])
        axes.plot(*ends.T, color=colour, linewidth=1.3, zorder=5)
        label = _free_place(ends[1] + LABEL_MM * direction, direction, placed, label_size_mm)
        placed.append(label)
        axes.plot(*np.array([ends[1], label - LABEL_MM * direction]).T, color=colour, linewidth=0.5, zorder=5)
        axes.text(*label, f"{distance:.1f} mm\n{area:.1f} mm²", ha="center", va="center", fontsize=7, zorder=6)


def _free_place(place, direction, placed, size_mm):
    """The first place (2,) from `place` on along `direction` where a label of size_mm (2,) covers none of `placed`."""
    for step in range(MOST_LABEL_STEPS):
        moved = place + step * LABEL_STEP_MM * direction
        if not any(np.all(np.abs(moved - other) < size_mm) for other in placed):
            return moved
    return place

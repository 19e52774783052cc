"""A case's curves: pull-back of FFR along the branch, area and curvature along the treated segment."""

import math

import matplotlib.pyplot as plt
import numpy as np

from reports.figures.style import COLOURS, LABELS, SEGMENT_COLOUR, draw_state, save_figure
from reports.measuring.pressure_wire import FFR_THRESHOLD
from reports.measuring.profiles import read_pullback, read_pullback_error

FIGURE_SIZE = (6.6, 3.6)  # inches
# readings of the pressure wire: key in metrics.json, words of the legend, fill colour of the mark
WIRE_MARKS = (("ffr_pre", "before PCI", "none"), ("ffr_post", "after PCI", COLOURS["measured"]))
ERROR_BAND_OPACITY = 0.25  # opacity of the band of estimated error round a curve
HEADROOM = 0.12  # room above the curves for the word "stent", as a share of the height below it
LEGEND_ROW, LEGEND_MARGIN = 0.18, 0.12  # inches: height of a row of the legend, and of the space round it
# Each vertical axis ends at the first value in a small vessel, at the second in any other. Fixed ends let a reader
# compare patients, although each figure shows only one. The areas are those of lumens 3.6 and 5.6 mm wide. The
# curvatures are those of bends with radii of 6.7 and 2.9 mm. A loss of FFR is 1 minus the lowest FFR.
AREA_TOPS_MM2, CURVATURE_TOPS_PER_MM, FFR_LOSSES = (10.0, 25.0), (0.15, 0.35), (0.25, 0.5)


def axis_end(largest, ends):
    """The end of an axis that shows values from 0 to `largest`.

    It is the smaller of both `ends` if that suffices, else the least multiple of the larger one that suffices.
    """
    small, usual = ends
    return small if largest <= small else usual * max(1, math.ceil(largest / usual))


def pullback_figure(files, metrics, folder):
    """Writes <case>_pullback.{svg,png}: FFR of all states from the inlet to the end of the stented branch.

    Each curve has a band of its estimated error. Marks show FFR measured by a pressure wire in this branch.
    """
    figure, axes = plt.subplots(figsize=FIGURE_SIZE)
    shade_segment(axes, metrics["segment"])
    lowest = 1.0
    for state in (name for name, entry in metrics["states"].items() if entry["ffr"] is not None):
        path, branch = files.flow(state) / "pullback.csv", metrics["segment"]["branch"]
        (line, ffr), error = read_pullback(path, branch), read_pullback_error(path, branch)
        draw_state(axes, state, line.s_mm, ffr)
        if np.isfinite(error).any():
            axes.fill_between(
                line.s_mm, ffr - error, ffr + error, color=COLOURS[state], alpha=ERROR_BAND_OPACITY, linewidth=0
            )
        lowest = min(lowest, ffr.min(), max(0.0, np.nanmin([lowest, *(ffr - error)])))
    lowest = min(lowest, draw_wire(axes, metrics))
    axes.axhline(FFR_THRESHOLD, color="#b0413e", linewidth=0.9, linestyle=(0, (2, 2)))
    axes.annotate("0.80", (1.0, FFR_THRESHOLD), (3, 0), xycoords=("axes fraction", "data"), textcoords="offset points")
    axes.texts[-1].set(color="#b0413e", va="center", fontsize=8.5)
    lower = 1.0 - axis_end(1.0 - lowest, FFR_LOSSES)
    axes.set(title="FFR pull-back", ylabel="FFR", ylim=(lower, 1.0 + HEADROOM * (1.0 - lower)), xmargin=0.0)
    axes.set_xlabel(f"distance along {metrics['segment']['branch']} (mm)")
    legend_below(figure)
    save_figure(figure, folder, f"{metrics['case']}_pullback")


def draw_wire(axes, metrics):
    """Draws the pressure wire's FFR as marks: an open mark before the procedure, a filled one after it.

    Returns the lowest reading, or 1 if the wire was not in the stented branch.
    """
    measured = metrics.get("measured")
    if not measured or measured["branch"] != metrics["segment"]["branch"]:
        return 1.0
    readings = [(measured[key], moment, face) for key, moment, face in WIRE_MARKS if measured[key] is not None]
    for ffr, moment, face in readings:
        label = f"{LABELS['measured']} {moment}: {ffr:.2f}"
        axes.plot(measured["s_mm"], ffr, "D", color=COLOURS["measured"], markerfacecolor=face, label=label, zorder=5)
    return min(ffr for ffr, _, _ in readings)


def legend_below(figure):
    """Puts the legend in two columns below a figure's only axes, where it hides no curve."""
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=2, fontsize=8.5)
    bottom = (LEGEND_MARGIN + LEGEND_ROW * math.ceil(len(labels) / 2)) / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, bottom, 1, 1 - bottom))


def shade_segment(axes, segment):
    """Shades the treated segment without its margins. segment: the entry `segment` of metrics.json."""
    margin = segment["margin_mm"]
    axes.axvspan(segment["s_start_mm"] + margin, segment["s_end_mm"] - margin, color=SEGMENT_COLOUR, zorder=0)
    middle = 0.5 * (segment["s_start_mm"] + segment["s_end_mm"])
    axes.annotate("stent", (middle, 1.0), (0, -3), xycoords=("data", "axes fraction"), textcoords="offset points")
    axes.texts[-1].set(ha="center", va="top", color="#8f866c", fontsize=8.5)


def segment_figure(metrics, folder, name, title, label, profile, mean, ends):
    """Writes <case>_<name>.{svg,png}: one quantity along the segment in all states, with the means in the legend.

    The lumens differ in length, so all states are drawn over the length before PCI, by relative position. profile and
    mean take a state's entry in metrics.json. profile returns the values at the stations, mean the mean as a text.
    label: name of the vertical axis; ends: its two possible ends (see `axis_end`).
    """
    figure, axes = plt.subplots(figsize=FIGURE_SIZE)
    length = metrics["segment"]["s_end_mm"] - metrics["segment"]["s_start_mm"]
    x = [length * value for value in metrics["stations"]["relative_position"]]
    margin = metrics["segment"]["margin_mm"]
    shade_segment(axes, {"s_start_mm": 0.0, "s_end_mm": length, "margin_mm": margin})
    for state, entry in metrics["states"].items():
        draw_state(axes, state, x, profile(entry))
        axes.lines[-1].set_label(f"{axes.lines[-1].get_label()}: mean {mean(entry)}")
    axes.set(title=title, ylabel=label, xlabel="distance along the segment (mm, length before PCI)", xmargin=0.0)
    top = axis_end(max(max(profile(entry)) for entry in metrics["states"].values()), ends)
    axes.set_ylim(0.0, (1.0 + HEADROOM) * top)
    legend_below(figure)
    save_figure(figure, folder, f"{metrics['case']}_{name}")


def area_figure(metrics, folder):
    """Writes <case>_area.{svg,png}: cross-sectional area along the segment."""
    segment_figure(
        metrics,
        folder,
        "area",
        "Cross-sectional area of the lumen",
        "CSA (mm²)",
        lambda entry: entry["area"]["profile_mm2"],
        lambda entry: f"{entry['area']['mean_mm2']:.2f} mm²",
        AREA_TOPS_MM2,
    )


def curvature_figure(metrics, folder):
    """Writes <case>_curvature.{svg,png}: curvature of the centreline along the segment."""
    segment_figure(
        metrics,
        folder,
        "curvature",
        "Curvature of the centreline",
        "curvature (1/mm)",
        lambda entry: entry["curvature"]["profile_per_mm"],
        lambda entry: f"{entry['curvature']['mean_per_mm']:.3f} /mm",
        CURVATURE_TOPS_PER_MM,
    )

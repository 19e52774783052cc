"""Figure of the differences in area (Diff^A) and curvature (Diff^C) along the segment, by patient and on average."""

import matplotlib.pyplot as plt
import numpy as np

from reports.figures.style import COLOURS, LABELS, SHORT_LABELS, save_figure
from reports.study.differences import compared_pairs, station_differences

PANELS = (
    ("diff_area_mm2", "Difference of area, Diff$^A$", "mm²"),
    ("diff_curvature_per_mm", "Difference of curvature, Diff$^C$", "1/mm"),
)
COMMON_POSITIONS = np.linspace(0.0, 1.0, 101)  # relative positions at which patients are averaged
FEWEST_FOR_BAND = 3
ROW_HEIGHT, LEGEND_ROW, LEGEND_MARGIN = 3.0, 0.2, 0.2  # inches: row of panels, row of legend, space round it


def differences_figure(documents, folder):
    """Writes differences.{svg,png}: a row for each lumen after PCI that predictions are compared with."""
    pairs = compared_pairs(documents)
    truths = list(dict.fromkeys(b for _, b, _ in pairs))
    legend_height = LEGEND_MARGIN + LEGEND_ROW * -(-len({a for a, _, _ in pairs}) // 2)
    height = ROW_HEIGHT * len(truths) + legend_height
    figure, grid = plt.subplots(len(truths), 2, figsize=(11.0, height), squeeze=False, sharex=True, sharey="col")
    for row, truth in zip(grid, truths):
        for axes, (column, title, unit) in zip(row, PANELS):
            axes.axhline(0.0, color="#555555", linewidth=0.8)
            for a in (a for a, b, _ in pairs if b == truth):
                draw_differences(axes, documents, a, truth, column)
            axes.set(title=f"{title}, minus {SHORT_LABELS[truth]}", ylabel=unit, xmargin=0.0)
    for axes in grid[-1]:
        axes.set_xlabel("relative position along the segment (0 proximal, 1 distal)")
    legend = {label: line for row in grid for line, label in zip(*row[0].get_legend_handles_labels())}
    figure.legend(legend.values(), legend.keys(), loc="lower center", ncol=2)
    figure.get_layout_engine().set(rect=(0, legend_height / height, 1, 1 - legend_height / height))
    save_figure(figure, folder, "differences")


def draw_differences(axes, documents, a, b, column):
    """Draws one thin line for each patient and a thick one for their mean: state a minus state b.

    For three or more patients a band shows one standard deviation to either side of the mean.
    """
    curves = []
    for document in documents:
        if {a, b} <= set(document["states"]):
            stations = station_differences(document, a, b)
            position, values = stations["relative_position"], stations[column]
            curves.append(np.interp(COMMON_POSITIONS, position, values, left=np.nan, right=np.nan))
            axes.plot(position, values, color=COLOURS[a], linewidth=0.8, alpha=0.6)
    known_in_all = np.isfinite(curves).all(axis=0)
    mean = np.mean(curves, axis=0)[known_in_all]
    label = f"{LABELS[a]}: mean of {len(curves)} patients" if len(curves) > 1 else f"{LABELS[a]}: one patient"
    axes.plot(COMMON_POSITIONS[known_in_all], mean, color=COLOURS[a], linewidth=2.2, label=label)
    if len(curves) >= FEWEST_FOR_BAND:
        sd = np.std(curves, axis=0, ddof=1)[known_in_all]
        axes.fill_between(
            COMMON_POSITIONS[known_in_all], mean - sd, mean + sd, color=COLOURS[a], alpha=0.15, linewidth=0
        )

"""Figures of the whole study: Bland-Altman plots, differences along the stent, FFR before and after."""

import matplotlib.pyplot as plt
import numpy as np

from common.patient.states import COMPARISONS, TRUE_STATES
from reports.study.agreement import QUANTITIES, paired_values, published_results
from reports.study.bland_altman import bland_altman
from reports.study.differences import compared_pairs
from reports.study.inclusion import analysed_documents
from reports.figures.differences import differences_figure
from reports.figures.style import COLOURS, ERROR_LABELS, LABELS, MARKERS, save_figure
from reports.measuring.pressure_wire import FFR_THRESHOLD

# title, unit, least width of the horizontal axis: a narrower axis would show nothing but rounding errors
QUANTITY_AXES = {
    "ffr": ("FFR", "", 0.1),
    "mean_area": ("Mean CSA", " (mm²)", 2.0),
    "minimum_area": ("Smallest CSA", " (mm²)", 2.0),
    "mean_curvature": ("Mean curvature", " (1/mm)", 0.04),
}
ROW_HEIGHT, LEGEND_ROW, LEGEND_MARGIN = 3.0, 0.2, 0.2  # inches: row of panels, row of legend, space round it
PUBLISHED_COLOUR = "#b9b9b9"


def study_figures(documents, folder):
    """Writes agreement.{svg,png}, differences.{svg,png} and ffr_before_after.{svg,png}.

    agreement needs a case with a reference, a lumen after PCI or a measured FFR. differences needs a case in which a
    prediction is compared with a lumen after PCI. Both show the included patients (`analysed_documents`).
    ffr_before_after shows all patients.
    """
    with_truth = [one for one in documents if one.get("measured") or set(TRUE_STATES) & set(one["states"])]
    if with_truth:
        agreement_figure(analysed_documents(with_truth), folder)
    with_prediction = [one for one in documents if compared_pairs([one])]
    if with_prediction:
        differences_figure(analysed_documents(with_prediction), folder)
    ffr_figure(documents, folder)


def agreement_figure(documents, folder):
    """Writes agreement.{svg,png}: Bland-Altman plots of FFR, areas and curvature, with a row for each kind of error.

    All panels of a quantity have the same axes, so that a reader can compare the kinds of error. The published
    agreement is a `clinical` error, so it is drawn in that row.
    """
    comparisons = {kind: [(a, b) for a, b, error in COMPARISONS if error == kind] for kind in ERROR_LABELS}
    shown = [
        kind
        for kind in ERROR_LABELS
        if any(has_pairs(documents, quantity, comparisons[kind]) for quantity in QUANTITIES)
    ]
    entries = sum(has_pairs(documents, common_quantity(kind), [pair]) for kind in shown for pair in comparisons[kind])
    legend_height = LEGEND_MARGIN + LEGEND_ROW * -(-(entries + ("clinical" in shown)) // 2)
    height = ROW_HEIGHT * len(shown) + legend_height
    figure, grid = plt.subplots(
        len(shown), len(QUANTITIES), figsize=(13.5, height), squeeze=False, sharex="col", sharey="col"
    )
    for row, kind in zip(grid, shown):
        for axes, quantity in zip(row, QUANTITIES):
            if not has_pairs(documents, quantity, comparisons[kind]):
                axes.set_axis_off()
                continue
            agreement_panel(axes, documents, quantity, comparisons[kind])
        first = next(axes for axes in row if axes.axison)
        first.set_ylabel(f"{ERROR_LABELS[kind]}\n{first.get_ylabel()}")
    for axes, quantity in zip(grid[0], QUANTITIES):
        widen_horizontal_axis(axes, QUANTITY_AXES[quantity][2])
    if "clinical" in shown:
        for axes, quantity in zip(grid[shown.index("clinical")], QUANTITIES):
            draw_published(axes, published_results()["quantities"].get(quantity))
    columns = [row[list(QUANTITIES).index(common_quantity(kind))] for row, kind in zip(grid, shown)]
    legend = {label: handle for axes in columns for handle, label in zip(*axes.get_legend_handles_labels())}
    if "clinical" in shown:
        legend["published bias and limits (n = 9)"] = plt.Rectangle((0, 0), 1, 1, color=PUBLISHED_COLOUR, alpha=0.4)
    figure.legend(legend.values(), legend.keys(), loc="lower center", ncol=2)
    bottom = legend_height / height
    figure.get_layout_engine().set(rect=(0, bottom, 1, 1 - bottom))
    save_figure(figure, folder, "agreement")


def common_quantity(kind):
    """The quantity that all cases with this kind of error have, so that the legend names every comparison.

    A pressure wire measures FFR only. A lumen always has an area, but it may have no flow.
    """
    return "ffr" if kind == "measured" else "mean_area"


def has_pairs(documents, quantity, pairs):
    """Whether any case allows one of the comparisons (a, b) of a quantity."""
    return any(paired_values(documents, quantity, a, b)[0] for a, b in pairs)


def draw_published(axes, source):
    """Draws the published bias and limits of agreement behind a panel. source: entry of published.json, or None.

    The axis keeps its ends. If it grew to the published limits, this study's errors might be too small to tell apart.
    The limits are written below the panel too, since the band may reach beyond the axis.
    """
    if not source or not axes.axison:
        return
    axes.set_ylim(axes.get_ylim())
    axes.axhspan(source["loa_lower"], source["loa_upper"], color=PUBLISHED_COLOUR, alpha=0.22, linewidth=0)
    axes.axhline(source["bias"], color=PUBLISHED_COLOUR, linewidth=1.2)
    words = f"published: {source['bias']:g} ({source['loa_lower']:g} to {source['loa_upper']:g})".replace("-", "−")
    axes.set_xlabel(f"{axes.get_xlabel()}\n{words}")


def agreement_panel(axes, documents, quantity, pairs):
    """Bland-Altman plot of one quantity: a - b against the mean of both, for each pair of states (a, b)."""
    axes.axhline(0.0, color="#555555", linewidth=0.8)
    for a, b in pairs:
        cases, first, second = paired_values(documents, quantity, a, b)
        if cases:
            draw_pairs(axes, a, b, np.array(first), np.array(second))
    title, unit, _ = QUANTITY_AXES[quantity]
    axes.xaxis.set_major_locator(plt.MaxNLocator(5))
    axes.tick_params(labelbottom=True)  # in every row, although the rows share the axis
    axes.set(title=title, xlabel=f"mean of both{unit}", ylabel=f"difference{unit}")


def widen_horizontal_axis(axes, least):
    """Makes the horizontal axis at least `least` wide, about its middle, in all panels that share it."""
    low, high = axes.get_xlim()
    if high - low < least:
        axes.set_xlim(0.5 * (low + high - least), 0.5 * (low + high + least))


def draw_pairs(axes, first_state, second_state, a, b):
    """Draws the points of one comparison, with its bias (solid) and limits of agreement (dashed).

    a, b: values (n,) of the patients in `first_state` and in `second_state`.
    """
    result, colour = bland_altman(a, b), COLOURS[first_state]
    label = f"{LABELS[first_state]} - {LABELS[second_state]} (n = {result.n})"
    axes.plot(
        0.5 * (a + b),
        a - b,
        MARKERS[first_state],
        color=colour,
        markersize=6,
        alpha=0.85,
        label=label,
    )
    axes.axhline(result.bias, color=colour, linewidth=1.3)
    if result.sd is not None:
        for limit in (result.loa_lower, result.loa_upper):
            axes.axhline(limit, color=colour, linewidth=1.0, linestyle=(0, (4, 2)))


def ffr_figure(documents, folder):
    """Writes ffr_before_after.{svg,png}: FFR of each state after PCI against FFR before PCI, a mark for each case."""
    figure, axes = plt.subplots(figsize=(4.6, 4.2))
    lowest = 0.78
    markers_after = {state: marker for state, marker in MARKERS.items() if state != "pre"}
    for state, marker in markers_after.items():
        pairs = [
            (document["states"]["pre"]["ffr"]["distal"], document["states"][state]["ffr"]["distal"])
            for document in documents
            if state in document["states"] and document["states"][state]["ffr"] is not None
        ]
        if pairs:
            x, y = np.array(pairs).T
            face = COLOURS[state] if state == "vci" else "none"
            axes.plot(x, y, marker, color=COLOURS[state], markerfacecolor=face, markersize=7, label=LABELS[state])
            lowest = min(lowest, x.min(), y.min())
    low = np.floor(20 * (lowest - 0.01)) / 20
    axes.plot([low, 1], [low, 1], color="#9a9a9a", linewidth=0.9)
    axes.axhline(FFR_THRESHOLD, color="#b0413e", linewidth=0.9, linestyle=(0, (2, 2)))
    axes.axvline(FFR_THRESHOLD, color="#b0413e", linewidth=0.9, linestyle=(0, (2, 2)))
    axes.set(xlabel="FFR before PCI", ylabel="FFR after PCI", xlim=(low, 1.005), ylim=(low, 1.005), aspect="equal")
    axes.set_title("FFR before and after")
    axes.legend(loc="lower right", fontsize=8.5, frameon=True, framealpha=1.0, edgecolor="none")
    save_figure(figure, folder, "ffr_before_after")

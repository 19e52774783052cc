"""Figures of the whole study: Bland-Altman plots and FFR before and after."""

import matplotlib.pyplot as plt
import numpy as np

from reports.agreement import QUANTITIES, paired_values, published
from reports.bland_altman import bland_altman
from reports.figures.curves import FFR_THRESHOLD
from reports.figures.style import COLOURS, LABELS, save
from reports.metrics import COMPARISONS

# title, unit, and the least width of the horizontal axis, lest rounding fill it
TITLES = {
    "ffr": ("FFR", "", 0.1),
    "mean_area": ("Mean CSA", " (mm²)", 2.0),
    "mean_curvature": ("Mean curvature", " (1/mm)", 0.04),
}
MARKERS = {"vci": "o", "rc": "^"}
PUBLISHED_COLOUR = "#b9b9b9"


def study_figures(documents, folder):
    """Writes agreement.{svg,png}, where a case has a reference, and ffr_before_after.{svg,png}."""
    if any("reference" in document["states"] for document in documents):
        agreement_figure(documents, folder)
    ffr_figure(documents, folder)


def agreement_figure(documents, folder):
    """Bland-Altman plots of FFR, mean area and mean curvature: predictions minus reference against their mean."""
    figure, grid = plt.subplots(1, 3, figsize=(11.0, 3.6))
    paper = published()["quantities"]
    for axes, quantity in zip(grid, QUANTITIES):
        source = paper[quantity]
        axes.axhspan(source["loa_lower"], source["loa_upper"], color=PUBLISHED_COLOUR, alpha=0.22, linewidth=0)
        axes.axhline(source["bias"], color=PUBLISHED_COLOUR, linewidth=1.2)
        axes.axhline(0.0, color="#555555", linewidth=0.8)
        for a, b in COMPARISONS:
            cases, first, second = paired_values(documents, quantity, a, b)
            if cases:
                draw_pairs(axes, a, np.array(first), np.array(second))
        title, unit, least = TITLES[quantity]
        low, high = axes.get_xlim()
        if high - low < least:
            axes.set_xlim(0.5 * (low + high - least), 0.5 * (low + high + least))
        axes.xaxis.set_major_locator(plt.MaxNLocator(5))
        axes.set(title=title, xlabel=f"mean of both{unit}", ylabel=f"prediction - reference{unit}")
    handles, labels = grid[0].get_legend_handles_labels()
    band = plt.Rectangle((0, 0), 1, 1, color=PUBLISHED_COLOUR, alpha=0.4)
    names = [*labels, "published bias and limits (n = 9)"]
    figure.legend([*handles, band], names, loc="lower center", ncol=3)
    figure.get_layout_engine().set(rect=(0, 0.09, 1, 0.91))
    save(figure, folder, "agreement")


def draw_pairs(axes, state, a, b):
    """Points of one comparison, with its bias (solid) and limits of agreement (dashed)."""
    result, colour = bland_altman(a, b), COLOURS[state]
    label = f"{LABELS[state]} - reference (n = {result.n})"
    axes.plot(0.5 * (a + b), a - b, MARKERS[state], color=colour, markersize=6, alpha=0.85, label=label)
    axes.axhline(result.bias, color=colour, linewidth=1.3)
    if result.sd is not None:
        for limit in (result.loa_lower, result.loa_upper):
            axes.axhline(limit, color=colour, linewidth=1.0, linestyle=(0, (4, 2)))


def ffr_figure(documents, folder):
    """FFR after PCI, predicted and reference, against FFR before it."""
    figure, axes = plt.subplots(figsize=(4.6, 4.2))
    lowest = 0.78
    for state, marker in (("vci", "o"), ("rc", "^"), ("reference", "s")):
        pairs = [
            (document["states"]["pre"]["ffr"]["distal"], document["states"][state]["ffr"]["distal"])
            for document in documents
            if state in document["states"]
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
    axes.legend(loc="lower right", fontsize=8.5)
    save(figure, folder, "ffr_before_after")

"""Figure of the seconds of the virtual procedure: box plots by stage, by step and in all, with the published ones."""

import matplotlib.pyplot as plt

from reports.figures.style import COLOURS, save_figure
from reports.study.agreement import published_results
from reports.study.seconds import seconds_by_group, stage_seconds

PANELS = (("stage", "Seconds by stage"), ("step", "Seconds by step"), ("all", "In all"))
PUBLISHED_COLOUR = "#8a8a8a"


def seconds_figure(timings, folder):
    """Writes seconds.{svg,png} from the DataFrame of timings.csv. Writes nothing if no procedure was simulated."""
    stages = stage_seconds(timings)
    if stages.empty:
        return
    groups, paper = seconds_by_group(stages), published_results()["seconds"]
    figure, row = plt.subplots(1, 3, figsize=(11.0, 3.4), width_ratios=(3, 3, 1))
    for axes, (by, title) in zip(row, PANELS):
        names = [name for kind, name in groups if kind == by]
        axes.boxplot([groups[by, name] for name in names], widths=0.5, medianprops={"color": COLOURS["vci"]})
        draw_published(axes, [paper[by].get(name) for name in names])
        axes.set_xticks(range(1, len(names) + 1), [name.replace("_", " ") for name in names])
        axes.tick_params(axis="x", labelsize=8)
        axes.set(title=title)
    for panels in (row[:2], row[2:]):  # the whole procedure lasts longer, so its panel has a scale of its own
        top = 1.15 * max(axes.dataLim.y1 for axes in panels)
        plt.setp(panels, ylim=(0, top))
    row[0].set_ylabel("s")
    row[0].legend(loc="center right", fontsize=8.5)
    row[2].set_xlabel(f"published:\n{in_print(paper['all']['procedure'])} s", fontsize=8.5)
    save_figure(figure, folder, "seconds")


def draw_published(axes, values):
    """Draws the published seconds over the boxes: the mean as a diamond, its ± as a bar where the source has one.

    values: {mean, sd} of each box in s, as in published.json, or None where the source has no value; sd may be missing.
    """
    known = [(k, one) for k, one in enumerate(values, 1) if one]
    style = {"color": PUBLISHED_COLOUR, "markersize": 4, "zorder": 3}
    axes.plot([k for k, _ in known], [one["mean"] for _, one in known], "D", label="published mean", **style)
    for k, one in known:
        if "sd" in one:
            axes.errorbar(k, one["mean"], yerr=one["sd"], capsize=7, **style)


def in_print(value):
    """A published value {mean, sd} as the source prints it, such as "24.92 ± 1.00"."""
    decimals = published_results()["decimals"]
    return " ± ".join(f"{value[key]:.{decimals}f}" for key in ("mean", "sd"))

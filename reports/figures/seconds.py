"""Figure of the seconds of the virtual procedure: box plots by stage, by step and in all, with the published means."""

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
        known = [(k, paper[by][name]) for k, name in enumerate(names, 1) if name in paper[by]]
        axes.plot(
            [k for k, _ in known],
            [one["mean"] for _, one in known],
            "D",
            color=PUBLISHED_COLOUR,
            label="published mean",
        )
        axes.set_xticks(range(1, len(names) + 1), [name.replace("_", " ") for name in names])
        axes.tick_params(axis="x", labelsize=8)
        axes.set(title=title)
    for panels in (row[:2], row[2:]):  # the whole procedure lasts longer, so its panel has a scale of its own
        top = 1.15 * max(axes.dataLim.y1 for axes in panels)
        plt.setp(panels, ylim=(0, top))
    row[0].set_ylabel("s")
    row[0].legend(loc="center right", fontsize=8.5)
    save_figure(figure, folder, "seconds")

"""Figure of the inclusion: from the cases of the cohort to the analysed cases."""

import textwrap

import matplotlib.pyplot as plt
from matplotlib.patches import FancyBboxPatch

from reports.figures.style import save

SIZE = (8.2, 6.4)  # inches
WRAP = 60  # most letters in a line of case names
WIDTH, LEFT, RIGHT = 0.46, 0.235, 0.765  # a box's width and both columns' middles, as shares of the figure
COHORT, INCLUDED, ASIDE, OF_THEM = 0.92, 0.46, (0.78, 0.63), (0.41, 0.24, 0.08)  # heights of the boxes' middles
FRAME, LINE = 0.03, 0.031  # heights of a box's frame and of a line in it, as shares of the figure
FILL, EDGE, LEFT_OUT = "#eef4f9", "#0a3d62", "#f8f1ec"


def inclusion_figure(table, folder):
    """Writes inclusion.{svg,png} from the table inclusion.csv.

    Excluded cases are at the upper right, results of the included cases at the lower right.
    """
    rows = [(words, count, names) for words, count, names in table.itertuples(index=False)]
    figure, axes = plt.subplots(figsize=SIZE)
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.set_axis_off()
    below = box(axes, LEFT, COHORT, *rows[0])[0]
    top = box(axes, LEFT, INCLUDED, *rows[3])[1]
    arrow(axes, (LEFT, below), (LEFT, top))
    for y, row in zip(ASIDE, rows[1:3]):
        box(axes, RIGHT, y, *row, fill=LEFT_OUT)
        arrow(axes, (LEFT, y), (RIGHT - WIDTH / 2, y))
    edge, bend = LEFT + WIDTH / 2, 0.5
    for y, row in zip(OF_THEM, rows[4:]):
        box(axes, RIGHT, y, *row)
        axes.plot([edge, bend, bend], [INCLUDED, INCLUDED, y], color=EDGE, linewidth=1.0)
        arrow(axes, (bend, y), (RIGHT - WIDTH / 2, y))
    save(figure, folder, "inclusion")


def box(axes, x, y, words, count, names, fill=FILL):
    """Draws a box about (x, y) with words, the number of cases and their names. Returns its lower and upper y."""
    lines = [words[:1].upper() + words[1:], f"n = {count}", *textwrap.wrap(names.replace(" ", ", "), WRAP)[:3]]
    height = FRAME + LINE * len(lines)
    patch = FancyBboxPatch((x - WIDTH / 2, y - height / 2), WIDTH, height, boxstyle="round,pad=0,rounding_size=0.012")
    patch.set(facecolor=fill, edgecolor=EDGE, linewidth=1.0)
    axes.add_patch(patch)
    for k, line in enumerate(lines):
        weight, size = ("bold", 9.5) if k == 0 else ("normal", 9.5 if k == 1 else 8)
        at = y + height / 2 - 0.5 * FRAME - LINE * (k + 0.5)
        axes.text(x, at, line, ha="center", va="center", fontsize=size, fontweight=weight)
    return y - height / 2, y + height / 2


def arrow(axes, start, end):
    """An arrow from one point to another."""
    look = {"arrowstyle": "-|>", "color": EDGE, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=look)

"""Figure of the inclusion: from the cases of the cohort to the analysed cases."""

import textwrap

import matplotlib.pyplot as plt
from matplotlib.patches import FancyBboxPatch

from reports.figures.style import save_figure

FIGURE_SIZE = (8.2, 6.4)  # inches
LINE_LETTERS = 60  # most letters in a line of case names
BOX_WIDTH, LEFT_X, RIGHT_X = 0.46, 0.235, 0.765  # a box's width and both columns' middles, as shares of the figure
# y of the middles of the boxes, from 0 at the bottom of the figure to 1 at its top.
COHORT_Y, INCLUDED_Y, EXCLUDED_Y, RESULTS_Y = 0.92, 0.46, (0.78, 0.63), (0.41, 0.24, 0.08)
FRAME_HEIGHT, LINE_HEIGHT = 0.03, 0.031  # heights of a box's frame and of a line in it, as shares of the figure
FILL_COLOUR, EDGE_COLOUR, EXCLUDED_COLOUR = "#eef4f9", "#0a3d62", "#f8f1ec"


def inclusion_figure(table, folder):
    """Writes inclusion.{svg,png} from the table inclusion.csv.

    Excluded cases are at the upper right, results of the included cases at the lower right.
    """
    rows = [(words, count, names) for words, count, names in table.itertuples(index=False)]
    figure, axes = plt.subplots(figsize=FIGURE_SIZE)
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.set_axis_off()
    below = draw_box(axes, LEFT_X, COHORT_Y, *rows[0])[0]
    top = draw_box(axes, LEFT_X, INCLUDED_Y, *rows[3])[1]
    draw_arrow(axes, (LEFT_X, below), (LEFT_X, top))
    for y, row in zip(EXCLUDED_Y, rows[1:3]):
        draw_box(axes, RIGHT_X, y, *row, fill=EXCLUDED_COLOUR)
        draw_arrow(axes, (LEFT_X, y), (RIGHT_X - BOX_WIDTH / 2, y))
    edge, bend = LEFT_X + BOX_WIDTH / 2, 0.5
    for y, row in zip(RESULTS_Y, rows[4:]):
        draw_box(axes, RIGHT_X, y, *row)
        axes.plot([edge, bend, bend], [INCLUDED_Y, INCLUDED_Y, y], color=EDGE_COLOUR, linewidth=1.0)
        draw_arrow(axes, (bend, y), (RIGHT_X - BOX_WIDTH / 2, y))
    save_figure(figure, folder, "inclusion")


def draw_box(axes, x, y, words, count, names, fill=FILL_COLOUR):
    """Draws a box round (x, y) with words, the number of cases and their names. Returns its lower and upper y."""
    lines = [words[:1].upper() + words[1:], f"n = {count}", *textwrap.wrap(names.replace(" ", ", "), LINE_LETTERS)[:3]]
    height = FRAME_HEIGHT + LINE_HEIGHT * len(lines)
    patch = FancyBboxPatch(
        (x - BOX_WIDTH / 2, y - height / 2), BOX_WIDTH, height, boxstyle="round,pad=0,rounding_size=0.012"
    )
    patch.set(facecolor=fill, edgecolor=EDGE_COLOUR, linewidth=1.0)
    axes.add_patch(patch)
    for k, line in enumerate(lines):
        weight, size = ("bold", 9.5) if k == 0 else ("normal", 9.5 if k == 1 else 8)
        at = y + height / 2 - 0.5 * FRAME_HEIGHT - LINE_HEIGHT * (k + 0.5)
        axes.text(x, at, line, ha="center", va="center", fontsize=size, fontweight=weight)
    return y - height / 2, y + height / 2


def draw_arrow(axes, start, end):
    """Draws an arrow from the point `start` to the point `end`, both (x, y)."""
    arrow_style = {"arrowstyle": "-|>", "color": EDGE_COLOUR, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=arrow_style)

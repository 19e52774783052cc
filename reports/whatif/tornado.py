"""Figure of a case: how its FFR and stent area depend on each input, and their 95 % interval if all inputs vary."""

import matplotlib.pyplot as plt
import numpy as np

from reports.figures.style import save_figure
from reports.measuring.pressure_wire import FFR_THRESHOLD
from reports.whatif.tables import QUANTITY_LABELS, STATE_LABELS, read_intervals, range_in_words, read_sensitivity

LOW_COLOUR, HIGH_COLOUR, INTERVAL_COLOUR = "#56b4e9", "#0a5a94", "#f3efe4"
BAR_SHARE = 0.62  # height of a bar, as a share of its row's height
ROW_HEIGHT, FRAME_HEIGHT, FIGURE_WIDTH = 0.3, 1.15, 8.2  # inches: height of a row, of a panel's frame; width
LEGEND_HEIGHT = 0.35  # inches: height of the legend
PANELS = (("pre", "ffr"), ("vci", "ffr"), ("vci", "minimal_stent_area_mm2"))
# least length of an axis, in the quantity's unit, so that small effects do not look large
LEAST_SPAN = {"ffr": 0.02, "minimal_stent_area_mm2": 0.2}


def sensitivity_figure(files, folder):
    """Writes <case>_sensitivity.{svg,png}: a panel each for FFR before, FFR after and the stent's area.

    A panel is left out where the table has no rows for it.
    """
    table, intervals = read_sensitivity(files.folder), read_intervals(files.folder)
    panels = [(state, quantity, panel_rows(table, state, quantity)) for state, quantity in PANELS]
    panels = [panel for panel in panels if len(panel[2])]
    heights = [ROW_HEIGHT * len(rows) + FRAME_HEIGHT for _, _, rows in panels]
    figure, grid = plt.subplots(
        len(panels),
        1,
        figsize=(FIGURE_WIDTH, sum(heights) + LEGEND_HEIGHT),
        squeeze=False,
        gridspec_kw={"height_ratios": heights},
    )
    for axes, (state, quantity, rows) in zip(grid[:, 0], panels):
        draw_bars(axes, rows, interval_of_most_inputs(intervals, state, quantity), quantity)
        name = QUANTITY_LABELS[quantity].partition(" (")[0]
        axes.set_title(f"{name[:1].upper()}{name[1:]} {STATE_LABELS[state]}")
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour) for colour in (LOW_COLOUR, HIGH_COLOUR, INTERVAL_COLOUR)]
    labels = ["input at its low end", "at its high end", "middle 95 % of the samples, all inputs varied"]
    figure.legend(handles, labels, loc="lower center", ncol=3, fontsize=8.5)
    bottom = LEGEND_HEIGHT / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, bottom, 1, 1 - bottom))
    save_figure(figure, folder, f"{files.case}_sensitivity")


def panel_rows(table, state, quantity):
    """The rows of one quantity in one state, sorted by the input's effect, the smallest first."""
    rows = table[(table["state"] == state) & (table["quantity"] == quantity)].dropna(
        subset=["at_low", "at_high"], how="all"
    )
    swing = rows[["at_low", "at_planned", "at_high"]].max(axis=1) - rows[["at_low", "at_planned", "at_high"]].min(
        axis=1
    )
    return rows.assign(swing=swing).sort_values(["swing", "input"], ascending=[True, False])


def interval_of_most_inputs(intervals, state, quantity):
    """The row with the interval of a quantity in a state, from the sample that varied the most inputs; or None."""
    for source in ("deployment", "flow"):
        found = intervals.get(source)
        if found is not None:
            rows = found[(found["state"] == state) & (found["quantity"] == quantity)]
            if len(rows):
                return rows.iloc[0]
    return None


def draw_bars(axes, rows, interval, quantity):
    """Draws a bar for each input, from the quantity at the input's low end to that at its high end.

    rows: result of panel_rows; interval: result of interval_of_most_inputs, shaded if it is known.
    """
    planned = rows["at_planned"].iloc[0]
    if interval is not None and np.isfinite(interval["lower"]):
        axes.axvspan(interval["lower"], interval["upper"], color=INTERVAL_COLOUR, zorder=0)
    for end, colour in (("at_low", LOW_COLOUR), ("at_high", HIGH_COLOUR)):
        axes.barh(range(len(rows)), rows[end] - planned, left=planned, color=colour, height=BAR_SHARE)
    axes.axvline(planned, color="#333333", linewidth=1.0)
    if quantity == "ffr":
        axes.axvline(FFR_THRESHOLD, color="#b0413e", linewidth=0.9, linestyle=(0, (2, 2)))
    shown = [planned, *rows["at_low"].dropna(), *rows["at_high"].dropna()]
    shown += [] if interval is None else [interval["lower"], interval["upper"]]
    low, high = np.nanmin(shown), np.nanmax(shown)
    middle, span = 0.5 * (low + high), max(1.08 * (high - low), LEAST_SPAN[quantity])
    labels = [f"{row['words']}, {range_in_words(row)}" for _, row in rows.iterrows()]
    axes.set(yticks=range(len(rows)), yticklabels=labels, xlim=(middle - span / 2, middle + span / 2))
    axes.xaxis.set_major_locator(plt.MaxNLocator(5))
    axes.set_xlabel(QUANTITY_LABELS[quantity])
    axes.grid(axis="y", visible=False)

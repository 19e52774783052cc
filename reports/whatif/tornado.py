"""Figure of a case: how its FFR and stent area depend on each input, and their interval over all inputs."""

import matplotlib.pyplot as plt
import numpy as np

from reports.figures.style import save
from reports.measuring.measured import FFR_THRESHOLD
from reports.whatif.tables import QUANTITIES, STATES, intervals, range_in_words, tornado

LOW, HIGH, BAND = "#56b4e9", "#0a5a94", "#f3efe4"
BAR, ROW, FRAME, WIDTH = (
    0.62,
    0.3,
    1.15,
    8.2,
)  # bar's share of a row; inches of a row, of a panel's frame, of the figure
LEGEND = 0.35  # inches: height of the legend
PANELS = (("pre", "ffr"), ("vci", "ffr"), ("vci", "minimal_stent_area_mm2"))
# least range of an axis in the quantity's unit, so that small effects do not look large
LEAST_SPAN = {"ffr": 0.02, "minimal_stent_area_mm2": 0.2}


def sensitivity_figure(files, folder):
    """Writes <case>_sensitivity.{svg,png}: panels for FFR before, FFR after, and the stent's area if it was varied."""
    table, spread = tornado(files.folder), intervals(files.folder)
    panels = [(state, quantity, of_panel(table, state, quantity)) for state, quantity in PANELS]
    panels = [panel for panel in panels if len(panel[2])]
    heights = [ROW * len(rows) + FRAME for _, _, rows in panels]
    figure, grid = plt.subplots(
        len(panels), 1, figsize=(WIDTH, sum(heights) + LEGEND), squeeze=False, gridspec_kw={"height_ratios": heights}
    )
    for axes, (state, quantity, rows) in zip(grid[:, 0], panels):
        draw(axes, rows, interval_of(spread, state, quantity), quantity)
        name = QUANTITIES[quantity].partition(" (")[0]
        axes.set_title(f"{name[:1].upper()}{name[1:]} {STATES[state]}")
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour) for colour in (LOW, HIGH, BAND)]
    labels = ["input at its low end", "at its high end", "middle 95 % of the samples, all inputs varied"]
    figure.legend(handles, labels, loc="lower center", ncol=3, fontsize=8.5)
    bottom = LEGEND / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, bottom, 1, 1 - bottom))
    save(figure, folder, f"{files.case}_sensitivity")


def of_panel(table, state, quantity):
    """The rows of one quantity in one state, sorted by the input's effect, the smallest first."""
    rows = table[(table["state"] == state) & (table["quantity"] == quantity)].dropna(
        subset=["at_low", "at_high"], how="all"
    )
    swing = rows[["at_low", "at_planned", "at_high"]].max(axis=1) - rows[["at_low", "at_planned", "at_high"]].min(
        axis=1
    )
    return rows.assign(swing=swing).sort_values(["swing", "input"], ascending=[True, False])


def interval_of(spread, state, quantity):
    """The row with the interval of a quantity in a state, from the sample that varied the most inputs; or None."""
    for source in ("deployment", "flow"):
        found = spread.get(source)
        if found is not None:
            rows = found[(found["state"] == state) & (found["quantity"] == quantity)]
            if len(rows):
                return rows.iloc[0]
    return None


def draw(axes, rows, interval, quantity):
    """Draws a bar for each input, from the quantity at the input's low end to that at its high end.

    rows: from of_panel; interval: from interval_of, shaded if it is known.
    """
    planned = rows["at_planned"].iloc[0]
    if interval is not None and np.isfinite(interval["lower"]):
        axes.axvspan(interval["lower"], interval["upper"], color=BAND, zorder=0)
    for end, colour in (("at_low", LOW), ("at_high", HIGH)):
        axes.barh(range(len(rows)), rows[end] - planned, left=planned, color=colour, height=BAR)
    axes.axvline(planned, color="#333333", linewidth=1.0)
    if quantity == "ffr":
        axes.axvline(FFR_THRESHOLD, color="#b0413e", linewidth=0.9, linestyle=(0, (2, 2)))
    seen = [planned, *rows["at_low"].dropna(), *rows["at_high"].dropna()]
    seen += [] if interval is None else [interval["lower"], interval["upper"]]
    low, high = np.nanmin(seen), np.nanmax(seen)
    middle, span = 0.5 * (low + high), max(1.08 * (high - low), LEAST_SPAN[quantity])
    labels = [f"{row['words']}, {range_in_words(row)}" for _, row in rows.iterrows()]
    axes.set(yticks=range(len(rows)), yticklabels=labels, xlim=(middle - span / 2, middle + span / 2))
    axes.xaxis.set_major_locator(plt.MaxNLocator(5))
    axes.set_xlabel(QUANTITIES[quantity])
    axes.grid(axis="y", visible=False)

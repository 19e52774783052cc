"""One style for all figures. The line styles, colours and labels of the states come from common/patient/states.py."""

import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)

from common.files import replacing  # noqa: E402
from common.patient.states import MEASURED, TABLE  # noqa: E402

COLOURS = {state.name: state.colour for state in TABLE}
LINE_STYLES = {state.name: state.line_style for state in TABLE}
MARKERS = {state.name: state.marker for state in TABLE}
LABELS = {state.name: state.label for state in TABLE}
SHORT_LABELS = {state.name: state.short_label for state in TABLE}
COLOURS[MEASURED] = "#b0413e"  # the pressure wire's reading: a mark, not a curve
LABELS[MEASURED], SHORT_LABELS[MEASURED] = "Pressure wire", "wire"
ERROR_LABELS = {
    "method": "Method",
    "imaging_before": "Imaging before",
    "imaging_after": "Imaging after",
    "clinical": "All together (clinical)",
}
ERROR_LABELS["measured"] = "Computed minus measured"
SEGMENT_COLOUR = "#f2efe6"

matplotlib.rcParams.update(
    {
        "svg.hashsalt": "vci",
        "svg.fonttype": "none",
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica", "sans-serif"],
        "font.size": 9.5,
        "axes.titlesize": 10.5,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": "#8a8a8a",
        "axes.labelcolor": "#333333",
        "axes.linewidth": 0.8,
        "axes.grid": True,
        "grid.color": "#e6e6e6",
        "grid.linewidth": 0.7,
        "axes.axisbelow": True,
        "xtick.color": "#555555",
        "ytick.color": "#555555",
        "legend.frameon": False,
        "lines.linewidth": 1.8,
        "figure.dpi": 100,
        "savefig.dpi": 160,
        "figure.constrained_layout.use": True,
    }
)


def draw_state(axes, state, x, y):
    """Draws a state's curve y over x in the state's colour and line style, with its label."""
    axes.plot(x, y, color=COLOURS[state], linestyle=LINE_STYLES[state], label=LABELS[state])


def save_figure(figure, folder, name):
    """Writes <name>.svg and <name>.png, without dates, and closes the figure. Returns their paths."""
    paths = [folder / f"{name}.svg", folder / f"{name}.png"]
    for path, metadata in zip(paths, ({"Date": None, "Creator": None}, {"Software": None})):
        with replacing(path) as partial:
            figure.savefig(partial, format=path.suffix[1:], metadata=metadata)
            if path.suffix == ".svg":
                text = _with_numbered_clip_paths(partial.read_text(encoding="utf-8"), name)
                partial.write_text(text, encoding="utf-8")
    plt.close(figure)
    return paths


def _with_numbered_clip_paths(svg, name):
    """The text of an SVG file with the ids <name>_clip0, <name>_clip1, ... of its clip paths, in order of appearance.

    matplotlib makes some of these ids from memory addresses, so that they differ from run to run.
    """
    ids = dict.fromkeys(re.findall(r'<clipPath id="([^"]+)"', svg))
    numbers = {one: f"{name}_clip{k}" for k, one in enumerate(ids)}
    return re.sub(r"\bp[0-9a-f]{10}\b", lambda found: numbers.get(found[0], found[0]), svg)

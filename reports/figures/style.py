"""One style for all figures. Each state has a line style and a colour, safe for colour-blind readers (Okabe-Ito)."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)

from common.files import replacing  # noqa: E402

COLOURS = {
    "pre": "#6b6b6b",
    "vci": "#0072b2",
    "rc": "#d97b00",
    "rc_stent": "#9c5b00",
    "reference": "#009e73",
    "ct": "#a3478f",
    "ct_vci": "#56b4e9",
    "ct_rc": "#e0a94a",
    "post": "#111111",
}
COLOURS["measured"] = "#b0413e"  # the pressure wire's reading: a mark, not a curve
LINE_STYLES = {
    "pre": (0, (4, 2)),
    "vci": "-",
    "rc": (0, (1.2, 1.2)),
    "rc_stent": (0, (1.2, 2.4)),
    "reference": (0, (6, 1.5, 1.2, 1.5)),
    "ct": (0, (3, 1)),
    "ct_vci": (0, (2, 1)),
    "ct_rc": (0, (1, 1.5)),
    "post": (0, (8, 1.5)),
}
LABELS = {
    "pre": "Before PCI",
    "vci": "Virtual PCI (VCI)",
    "rc": "Radius correction",
    "rc_stent": "Radius correction, stent alone",
    "reference": "Reference (finite elements)",
    "ct": "CT of the reference",
    "ct_vci": "VCI from CT",
    "ct_rc": "Radius correction from CT",
    "post": "After the real PCI",
    "measured": "Pressure wire",
}
SHORT_LABELS = {
    "pre": "before",
    "vci": "VCI",
    "rc": "radius correction",
    "rc_stent": "radius correction, stent alone",
    "reference": "reference",
    "ct": "CT",
    "post": "after PCI",
}
SHORT_LABELS |= {"ct_vci": "VCI from CT", "ct_rc": "radius correction from CT", "measured": "wire"}
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
    plt.close(figure)
    return paths

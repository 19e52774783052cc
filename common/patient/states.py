"""The states of a case: one table of the lumens whose areas and flow are compared (docs/design.md#states).

docs/extending.md lists what else a new state needs.
"""

import dataclasses

CT_PRE = "ct_pre"  # the lumen found in the CT before PCI: predictions start from it, but it has no flow of its own
MEASURED = "measured"  # a pressure wire in COMPARISONS; name of the wire's probe in boundary.json and ffr.json


@dataclasses.dataclass(frozen=True)
class State:
    """One state: how figures and pages show it, which cases have it, and what it is in a comparison.

    name: its folder in a case's folder, and its key in metrics.json.
    label, short_label: its name in legends and headings, and within a sentence or a narrow cell.
    colour: "#rrggbb". line_style, marker: as matplotlib takes them; a tuple (offset, dashes) is in line widths.
    cases: the cases that have it. "every"; "stent_alone": those with the setting metrics.stent_alone; "reference":
    synthetic ones with a finite-element truth; "ct": those of them whose CT is simulated; "post": those with a lumen
    after the real procedure.
    predicted_from: of a prediction, the lumen before PCI that it starts from, "pre" or CT_PRE; otherwise "".
    truth: whether it is a true lumen after PCI.
    ct_volume: whether cases with a CT have a CT volume of it.
    """

    name: str
    label: str
    short_label: str
    colour: str
    line_style: str | tuple
    marker: str
    cases: str
    predicted_from: str = ""
    truth: bool = False
    ct_volume: bool = False


# Tables, figures and pages show the states in this order. Colours are safe for colour-blind readers (Okabe-Ito).
TABLE = (
    State(
        name="pre",  # the lumen before PCI
        label="Before PCI",
        short_label="before",
        colour="#6b6b6b",
        line_style=(0, (4, 2)),
        marker="v",
        cases="every",
        ct_volume=True,
    ),
    State(
        name="vci",  # after virtual PCI
        label="Virtual PCI (VCI)",
        short_label="VCI",
        colour="#0072b2",
        line_style="-",
        marker="o",
        cases="every",
        predicted_from="pre",
    ),
    State(
        name="rc",  # radius correction by the largest balloon
        label="Radius correction",
        short_label="radius correction",
        colour="#d97b00",
        line_style=(0, (1.2, 1.2)),
        marker="^",
        cases="every",
        predicted_from="pre",
    ),
    State(
        name="rc_stent",  # radius correction by the stents alone
        label="Radius correction, stent alone",
        short_label="radius correction, stent alone",
        colour="#9c5b00",
        line_style=(0, (1.2, 2.4)),
        marker="v",
        cases="stent_alone",
        predicted_from="pre",
    ),
    State(
        name="reference",  # the finite-element truth
        label="Reference (finite elements)",
        short_label="reference",
        colour="#009e73",
        line_style=(0, (6, 1.5, 1.2, 1.5)),
        marker="s",
        cases="reference",
        truth=True,
        ct_volume=True,
    ),
    State(
        name="ct",  # the lumen found in the reference's CT
        label="CT of the reference",
        short_label="CT",
        colour="#a3478f",
        line_style=(0, (3, 1)),
        marker="D",
        cases="ct",
    ),
    State(
        name="ct_vci",  # as vci, from the lumen found in the CT before PCI
        label="VCI from CT",
        short_label="VCI from CT",
        colour="#56b4e9",
        line_style=(0, (2, 1)),
        marker="o",
        cases="ct",
        predicted_from=CT_PRE,
    ),
    State(
        name="ct_rc",  # as rc, from the lumen found in the CT before PCI
        label="Radius correction from CT",
        short_label="radius correction from CT",
        colour="#e0a94a",
        line_style=(0, (1, 1.5)),
        marker="^",
        cases="ct",
        predicted_from=CT_PRE,
    ),
    State(
        name="post",  # the lumen found after the real PCI
        label="After the real PCI",
        short_label="after PCI",
        colour="#111111",
        line_style=(0, (8, 1.5)),
        marker="P",
        cases="post",
        truth=True,
    ),
)

# (a, b, error): state a minus state b shows this error. Tables and figures show the comparisons in this order.
# method: the prediction minus the truth.
# imaging_before: the prediction from the lumen found in CT minus that from the true lumen.
# imaging_after: the truth as seen in CT minus the truth.
# clinical: all three errors together, because a clinical study has only images. The lumen after PCI comes from a
# CT or from the real procedure.
# measured: the computed FFR minus that of a pressure wire, at the wire's sensor.
COMPARISONS = (
    ("vci", "reference", "method"),
    ("rc", "reference", "method"),
    ("rc_stent", "reference", "method"),
    ("ct_vci", "vci", "imaging_before"),
    ("ct_rc", "rc", "imaging_before"),
    ("ct", "reference", "imaging_after"),
    ("ct_vci", "ct", "clinical"),
    ("ct_rc", "ct", "clinical"),
    ("vci", "post", "clinical"),
    ("rc", "post", "clinical"),
    ("rc_stent", "post", "clinical"),
    ("pre", MEASURED, "measured"),
    ("post", MEASURED, "measured"),
    ("vci", MEASURED, "measured"),
    ("rc", MEASURED, "measured"),
)


def states_of(cases):
    """Names of the states with this entry `cases` (see State), in the table's order; empty for another word."""
    return tuple(state.name for state in TABLE if state.cases == cases)


STATES = tuple(state.name for state in TABLE)
CT_STATES = states_of("ct")
PREDICTED = tuple(state.name for state in TABLE if state.predicted_from)
PREDICTED_FROM_PRE = tuple(state.name for state in TABLE if state.predicted_from == "pre")
PREDICTED_FROM_CT = tuple(state.name for state in TABLE if state.predicted_from == CT_PRE)
TRUE_STATES = tuple(state.name for state in TABLE if state.truth)  # if a case has both, the first counts
AFTER_PCI = tuple(name for name in STATES if name not in ("pre", *PREDICTED))  # what predictions are compared with
CT_IMAGED_STATES = tuple(state.name for state in TABLE if state.ct_volume)

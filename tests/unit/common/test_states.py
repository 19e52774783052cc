"""The table of states names each once, and the comparisons and the documentation name the same."""

import pathlib
import re

from common.patient.states import COMPARISONS, MEASURED, STATES, TABLE, states_of

DESIGN = pathlib.Path(__file__).resolve().parents[3] / "docs" / "design.md"


def test_each_state_has_a_name_of_its_own():
    assert len(set(STATES)) == len(STATES) and MEASURED not in STATES


def test_comparisons_name_states():
    assert {a for a, _, _ in COMPARISONS} <= set(STATES)
    assert {b for _, b, _ in COMPARISONS} <= {*STATES, MEASURED}
    assert len({(a, b) for a, b, _ in COMPARISONS}) == len(COMPARISONS)


def test_states_of_cases():
    assert states_of("every") == ("pre", "vci", "rc") and states_of("none") == ()
    assert sorted(name for cases in {state.cases for state in TABLE} for name in states_of(cases)) == sorted(STATES)


def test_documentation_has_a_row_for_each_state():
    section = DESIGN.read_text().split("\n## States\n")[1].split("\n## ")[0]
    cells = [row.split("|")[1] for row in section.splitlines() if row.startswith("| `")]
    assert sorted(name for cell in cells for name in re.findall(r"`(\w+)`", cell)) == sorted(STATES)

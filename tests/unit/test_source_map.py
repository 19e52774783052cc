"""docs/source-map.md: every equation, figure and table of the source has a row, and what the rows name exists."""

import pathlib
import re
import sys

import pytest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "verification")]

import source_tables  # noqa: E402

NAMED = re.compile(r"`([\w./-]+/[\w.-]+\.(?:hpp|cpp|py|smk|json))`(?:: ((?:`\w+`(?:, )?)+))?")
DECLARED = {
    "py": r"^(?:def|class) {0}\b",
    "smk": r"^rule {0}:",
    # a type, or a function with its result before and its arguments behind it
    "hpp": r"\b(?:class|struct) {0}\b|^[\w:<>&*, ]+ {0}\(",
    "cpp": r"^[\w:<>&*, ]+ (?:{0}\(|{0}::)",
}


def rows(text):
    """(number, here) of each row of the tables whose first columns are number, what, here."""
    found, reading = [], False
    for line in text.splitlines():
        if not line.startswith("|"):
            reading = False
        elif line.startswith("| number | what | here |"):
            reading = True
        elif reading and not line.startswith("| ---"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            found.append((cells[0], cells[2]))
    return found


def missing(text, root):
    """What the page names and the repository does not have: files, and names that a file does not declare."""
    found = []
    for path, names in NAMED.findall(text):
        file = root / path
        if not file.is_file():
            found.append(path)
            continue
        pattern = DECLARED.get(file.suffix[1:])
        for name in re.findall(r"`(\w+)`", names):
            if not re.search(pattern.format(name), file.read_text(), re.M):
                found.append(f"{path}: {name}")
    return found


@pytest.fixture
def page(repo_root):
    return (repo_root / "docs" / "source-map.md").read_text()


def test_every_equation_figure_and_table_has_its_row(page):
    numbers = [str(n) for n in range(1, 26)] + [f"Figure {n}" for n in range(1, 9)]
    assert [number for number, _ in rows(page)] == [*numbers, "Published means and agreement", "Supplementary table 1"]


def test_a_row_names_a_file_or_says_why_there_is_none(page):
    for number, here in rows(page):
        assert NAMED.search(here) or here.startswith("none: "), number
        assert len(here) > 10, number


def test_the_tables_that_the_report_shows_too_are_those_of_its_file(page):
    assert source_tables.PAGE.names(page) == {"equations", "figures"}
    assert source_tables.PAGE.filled(page, None) == page, "run tests/verification/source_tables.py"


def test_what_the_page_names_exists(page, repo_root):
    assert len(NAMED.findall(page)) > 30
    assert missing(page, repo_root) == []


@pytest.mark.parametrize(
    "text, found",
    [
        ("`vci/linalg/pcg.cpp`: `solve_gcp`", ["vci/linalg/pcg.cpp: solve_gcp"]),
        ("`vci/linalg/gcp.cpp`: `solve_pcg`", ["vci/linalg/gcp.cpp"]),
        ("`reports/study/cohort.py`: `cohort_table`, `cohort`", ["reports/study/cohort.py: cohort"]),
        ("`workflow/rules/flow.smk`: `shell`", ["workflow/rules/flow.smk: shell"]),
        ("`vci/contact/contact.hpp`: `PenaltyResponse`, `gap`", ["vci/contact/contact.hpp: gap"]),
    ],
)
def test_a_name_that_is_gone_is_found(repo_root, text, found):
    assert missing(text, repo_root) == found

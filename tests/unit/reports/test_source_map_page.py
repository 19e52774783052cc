"""The report's table of the source's figures, tables and equations: each has a row, and its links lead somewhere."""

import html
import re

import pytest

from common.errors import InputError
from reports.page import source_map
from reports.page.benchmarks import TITLES
from reports.page.build import environment
from reports.page.case_context import CURVES
from reports.page.folder import BENCHMARKS, INDEX, TEMPLATE_FOLDER, case_page

NAMES = ["lad01", "rca03"]


def every_id(names=NAMES):
    """Pages of cases `names` with all sections that the file names."""
    found = {page: set() for page in (INDEX, BENCHMARKS, *map(case_page, names))}
    for row in source_map.read_source_map():
        for place in row["places"]:
            for page, _ in source_map.place_pages({**place, "cases": []}, names):
                found[page].add(place["section"])
    return found


def shown(ids, names=NAMES):
    """The rows of the table by their number in the source."""
    return {row["number"]: row for row in source_map.source_map_rows(ids, names)}


def section(ids, names=NAMES):
    """The section's HTML on one line, its characters not escaped."""
    rows = source_map.source_map_rows(ids, names)
    return html.unescape(" ".join(environment().get_template("source_map.html.j2").render(source_map=rows).split()))


def test_each_figure_table_and_equation_has_a_row():
    numbers = [*(f"Figure {n}" for n in range(1, 9)), "Published means and agreement", "Supplementary table 1"]
    rows = source_map.read_source_map()
    assert [row["number"] for row in rows] == [*numbers, *(f"Equation {n}" for n in range(1, 26))]
    for row in rows:
        known = row["places"] or "code" in row or len(row["remark"]) > 40
        assert known, f"{row['number']}: neither a place nor code nor a reason"


def test_each_place_is_an_element_of_a_template():
    templates = "".join(file.read_text() for file in TEMPLATE_FOLDER.glob("*.j2"))
    known = set(re.findall(r'\bid="([\w-]+)"', templates)) | {name for name, _ in CURVES}
    known |= {f"benchmark-{name}" for name in TITLES}
    assert 'id="{{ curve.name }}"' in templates and 'id="benchmark-{{ benchmark.name }}"' in templates
    for row in source_map.read_source_map():
        assert not {place["section"] for place in row["places"]} - known, row["number"]


def test_a_link_leads_to_the_first_page_that_has_the_place():
    ids = every_id()
    assert shown(ids)["Figure 5"]["links"][0] == {
        "href": "cases/lad01.html#ct-figure",
        "words": "CT slices",
        "case": "lad01",
    }
    ids[case_page("lad01")].remove("ct-figure")
    assert shown(ids)["Figure 5"]["links"][0]["href"] == "cases/rca03.html#ct-figure"
    assert shown(ids)["Supplementary table 1"]["links"][0]["href"] == "#patients"
    assert shown(ids)["Figure 3"]["links"][1]["href"] == "cases/rca03.html#stages-figure", "of this patient alone"
    assert '<a href="cases/rca03.html#ct-figure">CT slices</a> (rca03); ' in section(ids)


def test_what_this_run_lacks_is_said_with_what_it_needs():
    ids = every_id()
    figure = shown(ids)["Figure 7"]
    assert not figure["links"] and figure["missing"][0]["needs"] == "the command make study CASES=culotte_lad"
    assert "the culotte step by step: not in this run, needs the command make study CASES=culotte_lad; " in section(ids)
    ids[INDEX].remove("differences")
    assert shown(ids)["Equation 24"] == {
        "number": "Equation 24",
        "what": "Diff^A, difference of area",
        "links": [],
        "missing": [{"words": "along the stent, of each patient", "needs": "a lumen after PCI"}],
        "code": "<code>reports/study/differences.py</code>: <code>station_table</code>, <code>difference_table</code>",
        "remark": "",
    }
    assert "#differences" not in section(ids)


def test_a_figure_that_is_not_there_has_its_reason():
    text = section(every_id())
    assert text.count("Not shown: the article's full text could not be opened here") == 2
    assert "it needs 3 to 60 times the time of the default" in text and "nearly as much as the whole study" in text


def test_an_equation_of_the_method_is_shown_by_its_file_and_function():
    row = section(every_id())
    row = row[row.index("Equation 12</th>") : row.index("Equation 13</th>")]
    assert "<code>vci/linalg/pcg.cpp</code>: <code>solve_pcg</code>" in row and "not in this run" not in row
    assert source_map.inline_html("`a<b` and [its page](x.md)") == "<code>a&lt;b</code> and its page"


@pytest.mark.parametrize(
    "old, new", [("number: Figure 1", "number: Fig. 1"), ("page: patient", "page: case"), ("words: CT", "text: CT")]
)
def test_a_wrong_row_is_refused(monkeypatch, tmp_path, old, new):
    text = source_map.SOURCE_MAP_FILE.read_text()
    assert old in text
    (tmp_path / "source_map.yaml").write_text(text.replace(old, new, 1))
    monkeypatch.setattr(source_map, "SOURCE_MAP_FILE", tmp_path / "source_map.yaml")
    with pytest.raises(InputError):
        source_map.read_source_map()

"""The study for machines: its numbers, and the research object that describes its files."""

import hashlib
import json

import pandas as pd
import pytest

from common.errors import InputError
from reports.inputs.case_files import CaseFiles
from reports.record.crate import crate
from reports.record.numbers import report_numbers, state_means

JUNIT = """<testsuites><testsuite><testcase classname="tests.unit.vci.test_x" name="a" time="0.1"/>
<testcase classname="tests.unit.vci.test_x" name="b"><failure message="1 != 2"/></testcase></testsuite></testsuites>"""


@pytest.fixture
def results(tmp_path):
    """A folder of results of one case and another's figure."""
    results = tmp_path / "results"
    files = {"report/index.html": "page", "report/report.json": "{}", "cases/a/metrics.json": "{}", "cases/b/x": ""}
    files |= {"report/cases/a.html": "page of a", "report/.partial-1/cases/a.html": "", "report/data/.timestamp": ""}
    files |= {"figures/a_lumen.png": "picture", "figures/b_lumen.png": "picture", "figures/agreement.svg": "<svg/>"}
    for name in ("agreement", "half_maximum", "nearer", "contrast", "differences", "inclusion", "patients", "cohort"):
        rows = "case,included,vci_ffr_distal,pre_ffr_distal\na,True,0.9,0.7\nc,True,0.8,\nmild,False,0.98,0.85\n"
        files[f"study/{name}.csv"] = rows
    provenance = {
        "schema": "vci-provenance-1",
        "software": {"revision": "abc", "system": "Debian", "packages": {"python3": "3.11"}},
        "cases": {"a": {"inputs": {"config/cases/a.yaml": "12"}, "products": {"metrics.json": "34"}}},
    }
    files["study/provenance.json"] = json.dumps(provenance)
    for name, text in files.items():
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).write_text(text)
    return results


def test_numbers_are_those_of_the_tables(results, tmp_path):
    (tmp_path / "junit.xml").write_text(JUNIT)
    case = CaseFiles("a", results / "cases" / "a")
    found = report_numbers([case], results / "study", "small", [tmp_path / "junit.xml"], [{"case": "b"}])
    assert found["states"]["vci"]["ffr_distal"] == {
        "n": 2,
        "mean": pytest.approx(0.85),
        "sd": pytest.approx(0.0707, abs=1e-4),
    }
    assert found["states"]["pre"]["ffr_distal"] == {"n": 1, "mean": 0.7, "sd": None}
    excluded = found["states_excluded"]["vci"]["ffr_distal"]
    assert excluded == {"n": 1, "mean": 0.98, "sd": None}, "apart from the included"
    assert [row["case"] for row in found["patients"]] == ["a", "c", "mild"] and found["patients"][1][
        "pre_ffr_distal"
    ] is None
    assert (found["evidence"]["passed"], found["evidence"]["failed"]) == (1, 1)
    assert found["failed"] == [{"case": "b"}]
    assert found["plans"] == {"a": []} and found["cohort"] == "small"
    known = hashlib.sha256((results / "study" / "provenance.json").read_bytes()).hexdigest()
    assert found["provenance_sha256"] == known
    json.dumps(found, allow_nan=False)


def test_a_missing_table_is_named(results):
    (results / "study" / "nearer.csv").unlink()
    with pytest.raises(InputError, match="nearer"):
        report_numbers([], results / "study", "", [])


def test_no_case_of_a_state_leaves_it_out():
    assert state_means(pd.DataFrame({"vci_ffr_distal": [None, None]})) == {}


def test_the_crate_describes_every_file_of_this_study_and_no_other(results, repo_root):
    document = crate(results, ["a"], repo_root / "CITATION.cff", "2026-01-02", "small")
    entities = {entity["@id"]: entity for entity in document["@graph"]}
    assert len(entities) == len(document["@graph"]), "no two entities of one name"
    parts = [part["@id"] for part in entities["./"]["hasPart"]]
    assert {"report/index.html", "cases/a/metrics.json", "figures/a_lumen.png", "figures/agreement.svg"} <= set(parts)
    assert "report/cases/a.html" in parts and not [name for name in parts if "/." in name]
    assert not [name for name in parts if "/b" in name], "what an earlier run left of another case"
    assert entities["cases/a/metrics.json"]["sha256"] == "34", "as provenance.json has it"
    page = entities["report/index.html"]
    assert page["sha256"] == hashlib.sha256(b"page").hexdigest() and page["contentSize"] == "4"
    assert entities["ro-crate-metadata.json"]["about"] == {"@id": "./"}
    assert entities["./"]["license"]["@id"] in entities and entities["./"]["citation"]["@id"] in entities


def test_every_reference_of_the_crate_leads_somewhere(results, repo_root):
    document = crate(results, ["a"], repo_root / "CITATION.cff", "2026-01-02", "")
    names = {entity["@id"] for entity in document["@graph"]}

    def references(value):
        if isinstance(value, dict):
            return [value["@id"]] if set(value) == {"@id"} else sum(map(references, value.values()), [])
        return sum(map(references, value), []) if isinstance(value, list) else []

    outside = [name for name in references(document["@graph"]) if name not in names]
    assert outside == ["https://w3id.org/ro/crate/1.1"], "the standard alone"

"""The table of faults: what counts as half-made, and what the page says of it."""

import importlib

import pytest

from common.documents import config


@pytest.fixture
def run(repo_root, monkeypatch):
    """The script tests/faults/run.py as a module."""
    monkeypatch.syspath_prepend(str(repo_root / "tests" / "faults"))
    return importlib.import_module("run")


def test_what_is_missing_is_not_half_made_but_what_is_cut_off_is(run):
    right = {"vci/lumen.vtp": "a", "vci/deployment.json": "b"}
    assert run.faults.differing_products({"vci/lumen.vtp": "a"}, right) == []
    assert run.faults.differing_products({"vci/lumen.vtp": "other"}, right) == ["vci/lumen.vtp"]
    assert run.faults.differing_products({"vci/lumen.vtp": "a", "vci/lumen.tmp": "c"}, right) == ["vci/lumen.tmp"]


def test_a_json_file_that_was_cut_off_is_told(run, tmp_path):
    study = object.__new__(run.Study)
    study.folder = tmp_path
    folder = tmp_path / "results" / "cases" / "one"
    (folder / "logs").mkdir(parents=True)
    (folder / "metrics.json").write_text('{"states": ')
    (folder / "logs" / "x.log").write_text("log")
    (folder / ".partial-3-lumen.vtp").write_text("half")
    assert study.products() == {"one/metrics.json": "not readable"}


def test_page_has_a_row_a_fault_and_sums_the_kills(run, tmp_path):
    ended = {"exit_code": 1, "resumed_exit_code": 0, "products": 33, "differ": [], "said": "No space left"}
    kill = {**ended, "name": "kills", "fault": "SIGKILL", "exit_code": -9, "said": "", "half_made": []}
    rows = [
        {**kill, "step": "flow of vci"},
        {**kill, "step": "virtual deployment", "half_made": ["a", "b"]},
        {**ended, "name": "full_disk", "fault": "the disk is full", "half_made": [], "differ": ["c"]},
        {"name": "read_only", "fault": "read-only", "not_tried": "mounting needs root"},
    ]
    run.write_table(tmp_path / "faults.csv", rows)
    page = run.faults_page(run.read_table(tmp_path / "faults.csv"), 1)
    assert "| SIGKILL at 2 random moments | -9 | – | 2 | to the end | 0 |" in page
    assert "| the disk is full | 1 | `No space left` | 0 | to the end | 1 |" in page
    assert "| read-only | not tried: mounting needs root | | | | |" in page
    assert "flow of vci (1), virtual deployment (1)" in page and "33 products" in page


def test_the_study_that_is_disturbed_has_a_valid_configuration(run, tmp_path):
    """Its case is the shipped one with settings of its own, which a change of the schema may make invalid."""
    case = run.Study(tmp_path).folder / "config" / "cases" / "quick_focal.yaml"
    config.load_case(case)
    assert "ffr_tolerance: 0.1" in case.read_text()

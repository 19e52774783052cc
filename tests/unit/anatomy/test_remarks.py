"""What is said about a proposed plan."""

import json

import pytest

from anatomy import remarks, sizing

SIDE = {"kind": "outlet", "branch": "side1", "diameter_mm": 2.2}


def said(summary, families):
    return remarks.of_proposal(summary, sizing.propose(summary, families, "case"))


def test_nothing_where_nothing_is_left_open(families, summary):
    assert said(summary, families) == []


@pytest.mark.parametrize(
    "change, words",
    [
        ({"diameter_stenosis_percent": 14.0}, "14 % only"),
        ({"s_start_mm": 3.0, "s_end_mm": 9.0}, "reaches 1.5 mm past lesion1 at its proximal end"),
        ({"s_start_mm": 41.0, "s_end_mm": 47.0}, "reaches 1.5 mm past lesion1 at its distal end"),
    ],
)
def test_lesion_that_is_mild_or_near_an_end(families, summary, change, words):
    summary["lesions"][0].update(change)
    assert [words in remark for remark in said(summary, families)] == [True]


def test_lesion_that_is_left(families, summary):
    other = {"name": "lesion2", "branch": "side1", "s_start_mm": 3.0, "s_mla_mm": 4.0, "s_end_mm": 6.0}
    summary["lesions"].append({**other, "diameter_stenosis_percent": 58.0})
    (remark,) = said(summary, families)
    assert "lesion2 (58 % on side1 at 4.0 mm)" in remark
    summary["lesions"][1]["diameter_stenosis_percent"] = 40.0
    assert said(summary, families) == []


@pytest.mark.parametrize(
    "mouth, width, words",
    [
        (21.0, 2.2, "lies across side1 (2.2 mm wide)"),
        (21.0, 1.5, None),
        (28.5, 8.0, "ends in the mouth of side1 (24.5 to 32.5 mm)"),
        (35.0, 2.2, None),
    ],
)
def test_side_branch_at_the_stent(families, summary, mouth, width, words):
    summary["branches"][1].update(parent="main", s_on_parent_mm=mouth)
    summary["ends"] = [{**SIDE, "diameter_mm": width}]
    found = said(summary, families)
    assert any(words in remark for remark in found) if words else found == []


def test_end_in_a_mild_lesion_that_no_length_avoids(families, summary):
    other = {"name": "lesion2", "branch": "main", "s_start_mm": 26.5, "s_mla_mm": 35.0, "s_end_mm": 44.0}
    summary["lesions"].append({**other, "diameter_stenosis_percent": 20.0})
    assert ["26.5 to 44.0 mm" in remark for remark in said(summary, families)] == [True]


def test_the_command_says_them(run_module, repo_root, summary, tmp_path):
    summary["lesions"][0]["diameter_stenosis_percent"] = 14.0
    (tmp_path / "anatomy.json").write_text(json.dumps(summary))
    case = repo_root / "config" / "cases" / "real_artery.yaml"
    done = run_module("anatomy", "plan", case, "--anatomy", tmp_path, "--out", tmp_path / "plan.json")
    assert done.returncode == 0 and "warning: " in done.stderr and "14 % only" in done.stderr

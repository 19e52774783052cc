"""The half-maximum arm: its own lumens, the network's FFR, and its place beside the study's own segmentation."""

import json

import pytest

from reports.__main__ import main
from reports.inputs.case_files import CaseFiles
from reports.measuring.metrics import case_metrics
from reports.page.agreement import agreement_groups
from reports.study.agreement import agreement_table

STATES = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
FFR = {"ct": 0.97, "ct_vci": 0.93, "ct_rc": 0.94}


@pytest.fixture
def with_arm(make_case, add_arm):
    folder = make_case("tube", states=STATES)
    add_arm(folder)
    return folder


def rows_of(*documents):
    """Rows of agreement.csv as the page reads them."""
    return json.loads(agreement_table(documents).to_json(orient="records"))


def test_only_the_lumens_from_ct_are_the_arms(with_arm):
    own = case_metrics(CaseFiles("tube", with_arm))
    arm = case_metrics(CaseFiles("tube", with_arm, "half_maximum"))
    area = {name: found["states"]["ct"]["area"]["mean_mm2"] for name, found in (("own", own), ("arm", arm))}
    assert area["arm"] == pytest.approx(own["states"]["rc"]["area"]["mean_mm2"]) and area["arm"] > area["own"] + 0.1
    assert arm["states"]["vci"] == own["states"]["vci"] and arm["states"]["pre"] == own["states"]["pre"]
    assert (
        arm["imaging"]["reference"]["method"] == "half_maximum" and own["imaging"]["reference"]["method"] == "psf_edge"
    )


def test_ffr_is_the_networks_and_has_no_profile(with_arm):
    found = case_metrics(CaseFiles("tube", with_arm, "half_maximum"))
    for state, ffr in FFR.items():
        entry = found["states"][state]["ffr"]
        assert (entry["distal"], entry["error_estimate"], entry["profile"]) == (ffr, 0.003, None)
        assert entry["model"] == "1D network, calibrated"
    difference = found["differences"]["ct_vci_minus_ct"]
    assert difference["ffr"] is None and difference["ffr_distal"] == pytest.approx(-0.04)


def test_without_the_networks_answer_areas_alone_are_compared(with_arm):
    (with_arm / "half_maximum" / "ffr.json").unlink()
    found = case_metrics(CaseFiles("tube", with_arm, "half_maximum"))
    assert found["states"]["ct"]["ffr"] is None and found["states"]["vci"]["ffr"] is not None
    quantities = {(row["quantity"], row["comparison"]) for row in rows_of(found)}
    assert ("mean_area", "ct_vci_minus_ct") in quantities and ("ffr", "ct_vci_minus_ct") not in quantities


def test_both_segmentations_stand_beside_each_other(with_arm, tmp_path):
    out = with_arm / "half_maximum" / "metrics.json"
    main(
        ["metrics", "--case", "tube", "--case-dir", str(with_arm), "--segmentation", "half_maximum", "--out", str(out)]
    )
    own, arm = rows_of(case_metrics(CaseFiles("tube", with_arm))), rows_of(json.loads(out.read_text()))
    (group,) = agreement_groups(own, [], arm)
    rows = {(row["prediction"], row["name"]): row for row in group["segmentations"]}
    assert len(rows) == 8
    for own_or_arm, table in ((0, own), (1, arm)):
        bias = {row["comparison"]: row["bias"] for row in table if row["quantity"] == "mean_area"}
        errors = rows[("vci", "Mean CSA")]["errors"]
        assert errors["clinical"][own_or_arm]["bias"] == bias["ct_vci_minus_ct"]
        assert errors["imaging_after"][own_or_arm]["bias"] == bias["ct_minus_reference"]
    assert rows[("rc", "FFR")]["errors"]["clinical"][1]["largest_estimate"] == 0.003
    (without,) = agreement_groups(own, [], [])
    assert without["segmentations"] == [], "no table without the arm"

"""Which prediction is nearer: the verdict in words, from paired errors."""

import json

import numpy as np
import pytest

from reports.page.agreement import agreement_rows, row_digits
from reports.page.verdict.lines import too_few
from reports.page.digits import lower_first, signed
from reports.study.nearer import nearer_table, paired_test
from reports.study.agreement import agreement_table

NEAR, FAR = 0.01 * np.arange(1, 10), 0.01 * np.arange(1, 10) + 0.002 * np.arange(1, 10)


@pytest.mark.parametrize(
    "vci, rc, word, nearer",
    [
        (NEAR, FAR, "nearer", 9),
        (FAR, NEAR, "farther", 0),
        (NEAR, NEAR[::-1], "no difference shown", 4),
        (NEAR, NEAR, "no difference shown", 0),
    ],
)
def test_the_word_of_nine_patients(vci, rc, word, nearer):
    found = paired_test(vci, rc, 0.0)
    assert (found["vci_is"], found["patients_vci_nearer"], found["n"]) == (word, nearer, 9)
    assert found["error_vci"] == pytest.approx(np.mean(vci)) and found["error_rc"] == pytest.approx(np.mean(rc))


def test_the_p_of_pairs_that_all_point_one_way():
    assert paired_test(NEAR, FAR, 0.0)["p"] == pytest.approx(2 / 2**9)
    assert paired_test(NEAR[:6], FAR[:6], 0.0)["p"] == pytest.approx(2 / 2**6)


def test_five_patients_are_too_few():
    found = paired_test(NEAR[:5], FAR[:5], 0.0)
    assert found["p"] is None and found["vci_is"] == "no difference shown" and found["patients_vci_nearer"] == 5


def test_five_patients_without_a_tie_are_too_few():
    """Ties say nothing, so nine patients of whom four are ties are no more than five."""
    found = paired_test(NEAR, FAR, np.array([0.1] * 4 + [0.0] * 5))
    assert found["ties"] == 4 and found["p"] is None and found["vci_is"] == "no difference shown"
    assert too_few(found) == "5 patients without a tie are too few"


def patient(case, vci, rc, ct=True, estimate=0.0):
    """metrics.json of a patient. The truth is 0.9; vci, rc: errors. Case "2" has no FFR of radius correction."""

    def state(value, flow=True):
        ffr = {"distal": value, "error_estimate": estimate} if flow else None
        area, curvature = {"mean_mm2": value, "minimum_mm2": value}, {"mean_per_mm": value}
        return {"ffr": ffr, "area": area, "curvature": curvature}

    predicted = {"vci": state(0.9 + vci), "rc": state(0.9 + rc, flow=case != "2")}
    from_ct = {f"ct_{name}": values for name, values in predicted.items()} | {"ct": state(0.9)}
    return {"case": case, "states": predicted | {"reference": state(0.9)} | (from_ct if ct else {})}


def test_a_row_a_quantity_and_truth_over_the_patients_that_have_both():
    documents = [patient(str(k), 0.01 * k, -0.02 * k, ct=k < 7) for k in range(1, 9)]
    table = nearer_table(documents).set_index(["quantity", "truth"])
    assert set(table.index) == {
        (name, truth)
        for name in ("ffr", "mean_area", "minimum_area", "mean_curvature")
        for truth in ("reference", "ct")
    }
    assert table["error"].xs("ct", level="truth").eq("clinical").all()
    assert table.loc[("minimum_area", "reference"), "n"] == 8 and table.loc[("ffr", "reference"), "n"] == 7
    row = table.loc[("mean_area", "reference")]
    assert row["vci_is"] == "nearer" and row["error_rc"] == pytest.approx(0.09)
    assert table.loc[("mean_area", "ct"), "n"] == 6 and table.loc[("ffr", "ct"), "p"] != table.loc[("ffr", "ct"), "p"]


def test_differences_within_the_flows_error_are_ties():
    """VCI is nearer in every patient, by 0.002 to 0.018. In FFR, differences below the error of the flow are ties."""
    documents = [patient(f"p{k}", NEAR[k], FAR[k], estimate=0.011) for k in range(9)]
    table = nearer_table(documents).set_index(["quantity", "truth"])
    ffr, area = table.loc[("ffr", "reference")], table.loc[("mean_area", "reference")]
    assert (ffr["vci_is"], ffr["patients_vci_nearer"], ffr["ties"]) == ("no difference shown", 4, 5)
    assert (area["vci_is"], area["patients_vci_nearer"], area["ties"]) == ("nearer", 9, 0)
    documents[0]["states"]["rc"]["ffr"]["error_estimate"] = None
    assert nearer_table(documents).set_index(["quantity", "truth"]).loc[("ffr", "reference"), "ties"] == 5
    documents[8]["states"]["rc"]["ffr"]["error_estimate"] = None  # error not known: a difference of any size is a tie
    assert nearer_table(documents).set_index(["quantity", "truth"]).loc[("ffr", "reference"), "ties"] == 6


def test_small_biases_have_two_digits():
    documents = [patient(str(k), 0.0001 * k, -0.02 * k) for k in (1, 3)]
    rows = json.loads(agreement_table(documents).to_json(orient="records"))
    by_name = {(row["name"], row["comparison"]): row for row in agreement_rows(rows)}
    row = by_name[("Mean CSA", "vci_minus_reference")]
    assert signed(row["bias"], row["digits"]) == "+0.00020" and signed(row["sd"], row["digits"]) == "+0.00014"
    assert by_name[("Mean CSA", "ct_rc_minus_ct")]["digits"] == 3


@pytest.mark.parametrize(
    "bias, sd, digits", [(-0.0123, 3e-6, 4), (0.0123, 0.0045, 4), (0.2, 0.3, 3), (0.0, 0.00031, 5), (0.1, None, 3)]
)
def test_a_tiny_sd_takes_one_decimal_more_than_the_bias(bias, sd, digits):
    assert row_digits({"quantity": "ffr", "bias": bias, "sd": sd}) == digits


def test_a_label_within_a_sentence():
    assert lower_first("Reference (finite elements)") == "reference (finite elements)"
    assert lower_first("CT of the reference") == "CT of the reference"

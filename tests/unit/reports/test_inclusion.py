"""Statistics cover the included patients. Excluded patients have statistics of their own."""

import pytest

from reports.study.agreement import agreement_table
from reports.study.differences import COHORT_ROW_NAME, difference_table
from reports.study.inclusion import analysed_documents, patient_groups
from reports.study.nearer import nearer_table
from reports.page.agreement import excluded_patients


def patient(case, before, vci, reference=0.9):
    """metrics.json of a patient: one value for all quantities before, predicted and after PCI. before None: no flow."""

    def state(value):
        area = {"mean_mm2": value, "minimum_mm2": value, "profile_mm2": [value, value]}
        curvature = {"mean_per_mm": value, "profile_per_mm": [value, value]}
        return {"ffr": {"distal": value, "error_estimate": value / 100}, "area": area, "curvature": curvature}

    states = {"vci": state(vci), "rc": state(vci), "reference": state(reference)}
    states = {"pre": state(before or 0.5), **{name: one | {"s_mm": [0.0, 1.0]} for name, one in states.items()}}
    if before is None:
        states["pre"]["ffr"] = None
    along = {"bias": vci - reference, "sd": 0.0, "rmse": abs(vci - reference)}
    differences = {f"{a}_minus_reference": {"area_mm2": along, "curvature_per_mm": along} for a in ("vci", "rc")}
    stations = {"relative_position": [0.0, 1.0]}
    return {"case": case, "states": states, "differences": differences, "stations": stations, "measured": None}


@pytest.fixture
def documents():
    """Two included patients and two excluded ones: FFR 0.80 before PCI, and no flow before PCI."""
    return [
        patient("a", 0.70, 0.92),
        patient("mild", 0.80, 0.60),
        patient("b", 0.799, 0.94),
        patient("unknown", None, 0.70),
    ]


def test_nobody_of_the_others_is_in_the_statistics(documents):
    table = agreement_table(documents).set_index(["patients", "quantity", "comparison"])
    row = table.loc[("included", "ffr", "vci_minus_reference")]
    assert row["n"] == 2 and row["bias"] == pytest.approx(0.03) and row["largest_estimate"] == pytest.approx(0.0094)
    assert table.loc[("excluded", "ffr", "vci_minus_reference"), "bias"] == pytest.approx(-0.25)
    found = nearer_table(documents).set_index(["patients", "quantity", "truth"])
    assert found.loc[("included", "mean_area", "reference"), "error_vci"] == pytest.approx(0.03)
    assert found.loc[("excluded", "mean_area", "reference"), "n"] == 2


def test_each_group_has_its_own_mean_along_the_stent(documents):
    table = difference_table(documents)
    table = table[table["comparison"] == "vci_minus_reference"].set_index(["patients", "case"])
    assert list(table.index.get_level_values("case")) == ["a", "b", COHORT_ROW_NAME, "mild", "unknown", COHORT_ROW_NAME]
    assert table.loc[("included", COHORT_ROW_NAME), "diff_area_mean_mm2"] == pytest.approx(0.03)
    assert table.loc[("excluded", COHORT_ROW_NAME), "n"] == 2


def test_figures_show_the_included_or_else_the_others(documents):
    assert [one["case"] for one in analysed_documents(documents)] == ["a", "b"]
    assert [one["case"] for one in analysed_documents(documents[1:2])] == ["mild"]
    assert analysed_documents([]) == [] and [name for name, _ in patient_groups(documents[:1])] == ["included"]


def test_who_is_left_out_and_why():
    rows = [
        {"case": "a", "ffr_criterion": 0.799},
        {"case": "mild", "ffr_criterion": 0.8},
        {"case": "x", "ffr_criterion": None},
    ]
    assert excluded_patients(rows) == [("mild", "FFR before PCI 0.80"), ("x", "FFR before PCI not known")]


def test_the_pressure_wire_decides(documents):
    computed, measured = documents[1], documents[0]
    computed["measured"], measured["measured"] = {"ffr_pre": 0.79}, {"ffr_pre": 0.81}
    assert [(name, [one["case"] for one in found]) for name, found in patient_groups(documents[:2])] == [
        ("included", ["mild"]),
        ("excluded", ["a"]),
    ]
    computed["measured"] = {"ffr_pre": None}
    assert [name for name, _ in patient_groups([computed])] == ["excluded"]

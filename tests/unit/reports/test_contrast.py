"""Case by case: the error of each method against the lumen after PCI, and which method is nearer."""

import pytest

from reports.study.contrast import UNDECIDED, UNKNOWN, contrast_table


def state(ffr, area, error=0.002):
    flow = None if ffr is None else {"distal": ffr, "error_estimate": error}
    return {
        "ffr": flow,
        "area": {"mean_mm2": area, "minimum_mm2": area - 1.0},
        "curvature": {"mean_per_mm": 0.01 * area},
    }


def document(case, truth="reference", **states):
    """metrics.json of a case. Case "a" also has radius correction by the stent alone."""
    states = {"vci": state(0.88, 7.2), "rc": state(0.91, 7.5), truth: state(0.89, 7.0)} | states
    profiles = {"vci": 0.3, "rc": 0.2}
    if case == "a":
        states["rc_stent"], profiles["rc_stent"] = state(0.86, 6.0), 1.1
    differences = {f"{name}_minus_{truth}": {"area_mm2": {"rmse": rms}} for name, rms in profiles.items()}
    return {"case": case, "states": states, "differences": differences}


def test_errors_have_signs_and_the_smaller_size_is_nearer():
    table = contrast_table([document("a"), document("b", truth="post")]).set_index(["case", "quantity"])
    assert len(table) == 10
    row = table.loc[("a", "ffr")]
    assert (row["error_vci"], row["error_rc"], row["error_rc_stent"]) == pytest.approx((-0.01, 0.02, -0.03))
    assert row["nearer"] == "VCI" and row["nearer_by"] == pytest.approx(0.01)
    row = table.loc[("a", "area_profile")]
    assert row["nearer"] == "radius correction" and row["nearer_by"] == pytest.approx(0.1)
    assert table.loc[("b", "mean_area"), "truth"] == "post" and table["error_rc_stent"].notna().sum() == 5


@pytest.mark.parametrize("error, nearer", [(0.0099, "VCI"), (0.011, UNDECIDED), (None, UNKNOWN)])
def test_ffr_is_decided_beyond_the_flows_own_error_only(error, nearer):
    table = contrast_table([document("a", vci=state(0.88, 7.2, error=error))]).set_index("quantity")
    assert table.loc["ffr", "nearer"] == nearer
    assert table.loc["mean_area", "nearer"] == "VCI"


def test_what_has_no_truth_or_no_flow_has_no_row():
    bare = {"case": "c", "states": {"vci": state(0.9, 7.0), "rc": state(0.9, 7.0)}, "differences": {}}
    without_flow = document("d", vci=state(None, 7.2))
    table = contrast_table([bare, without_flow])
    assert set(table["case"]) == {"d"} and "ffr" not in set(table["quantity"])
    assert list(contrast_table([]).columns) == list(table.columns)

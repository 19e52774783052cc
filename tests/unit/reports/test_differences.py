"""Diff^A and Diff^C against tubes whose areas are known, and the figure of them."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from reports.__main__ import main
from reports.figures import differences as figure_module
from reports.inputs.case_files import CaseFiles
from reports.measuring.metrics import case_metrics
from reports.study.differences import COHORT_ROW_NAME, difference_table, station_table

STATES = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
PAIRS = (("vci", "reference"), ("rc", "reference"), ("ct_vci", "ct"), ("ct_rc", "ct"))


@pytest.fixture
def documents(make_case):
    """Two patients with reference and CT, and one without a lumen after PCI."""
    changes = {"one": 0.0, "two": 0.04}
    found = [
        case_metrics(CaseFiles(name, make_case(name, states=STATES, change=change))) for name, change in changes.items()
    ]
    return [*found, case_metrics(CaseFiles("own", make_case("own", states=("pre", "vci", "rc"))))]


def test_stations_hold_the_tubes_areas(documents, tube):
    table = station_table(documents)
    assert set(table["comparison"]) == {f"{a}_minus_{b}" for a, b in PAIRS}
    assert set(table["case"]) == {"one", "two"}
    rows = table[(table["case"] == "one") & (table["comparison"] == "vci_minus_reference")]
    areas = [np.pi * tube(state).radii(rows["s_mm"]) ** 2 for state in ("vci", "reference")]
    assert rows["diff_area_mm2"].to_numpy() == pytest.approx(areas[0] - areas[1], abs=2e-3)
    assert rows["diff_area_mm2"].max() > 0.5, "the lesion is opened further, by the tubes' definition"
    assert rows["diff_curvature_per_mm"].abs().max() < 1e-6, "both lie on the same arc"


def test_patients_and_cohort_follow_from_the_stations(documents):
    stations = station_table(documents).groupby(["comparison", "case"])["diff_area_mm2"]
    table = difference_table(documents).set_index(["comparison", "case"])
    for comparison in ("vci_minus_reference", "ct_rc_minus_ct"):
        means = [stations.mean()[comparison, case] for case in ("one", "two")]
        one, cohort = table.loc[(comparison, "one")], table.loc[(comparison, COHORT_ROW_NAME)]
        assert one["diff_area_mean_mm2"] == pytest.approx(means[0])
        assert one["diff_area_sd_mm2"] == pytest.approx(stations.std(ddof=0)[comparison, "one"])
        assert one["diff_area_mean_size_mm2"] == pytest.approx(
            stations.apply(lambda d: d.abs().mean())[comparison, "one"]
        )
        after = station_table(documents).groupby(["comparison", "case"])["area_b_mm2"].mean()[comparison, "one"]
        assert one["diff_area_mean_percent"] == pytest.approx(100 * means[0] / after)
        assert cohort["n"] == 2 and cohort["diff_area_mean_mm2"] == pytest.approx(np.mean(means))
        assert cohort["diff_area_sd_mm2"] == pytest.approx(np.std(means, ddof=1))
        assert cohort["diff_area_largest_size_mm2"] == max(
            table.loc[(comparison, case), "diff_area_largest_size_mm2"] for case in ("one", "two")
        )


def test_without_a_lumen_after_pci_the_tables_are_empty(make_case, tmp_path):
    folder = make_case("own", states=("pre", "vci"))
    out = [str(tmp_path / name) for name in ("metrics.json", "stations.csv", "differences.csv")]
    main(["metrics", "--case", "own", "--case-dir", str(folder), "--out", out[0]])
    main(["differences", "--metrics", out[0], "--stations", out[1], "--out", out[2]])
    assert all(pd.read_csv(path).empty for path in out[1:])


def test_the_figure_averages_over_the_patients(documents, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(figure_module, "save_figure", lambda figure, *_: drawn.append(figure))
    figure_module.differences_figure(documents, tmp_path)
    areas = drawn[0].axes[0]
    thick = [line for line in areas.lines if line.get_linewidth() == 2.2]
    assert [line.get_label() for line in thick] == [
        "Virtual PCI (VCI): mean of 2 patients",
        "Radius correction: mean of 2 patients",
    ]
    table = station_table(documents)
    rows = table[(table["comparison"] == "vci_minus_reference")].groupby("relative_position")["diff_area_mm2"].mean()
    assert np.interp(0.5, *thick[0].get_data()) == pytest.approx(np.interp(0.5, rows.index, rows.to_numpy()), abs=1e-9)
    plt.close(drawn[0])

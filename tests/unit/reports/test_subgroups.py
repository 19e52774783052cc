"""A drawn cohort's tables: agreement by subgroup, failures by step and reason."""

import json

import pytest
import yaml

from common.errors import InputError
from data_synthetic import draw
from reports.study.subgroups import patient_files, subgroup_tables


@pytest.fixture
def cohort(tmp_path):
    """add(number, artery, difference, error) writes a patient: one with this difference of FFR, or one that failed."""

    def add(number, artery, difference=None, error=None):
        file = tmp_path / "cohort" / "shards" / "0001" / "cases" / f"p{number}.yaml"
        case = draw.draw_patient(1, 1)
        case["vessel"]["artery"] = artery
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(yaml.safe_dump(case))
        folder = tmp_path / "cases" / f"p{number}"
        (folder / "logs" / "vci").mkdir(parents=True)
        if error:
            (folder / "logs" / "generate.log").write_text("$ generate\n")
            (folder / "logs" / "vci" / "deploy.log").write_text(f"$ vci\nsteps\nerror: {error}\n  where: here\n")
        if difference is not None:
            states = {name: state(0.9 + change) for name, change in (("vci", difference), ("reference", 0.0))}
            document = {"schema": "vci-metrics-1", "case": f"p{number}", "states": states, "measured": None}
            (folder / "metrics.json").write_text(json.dumps(document))

    add.tables = lambda: subgroup_tables(patient_files(tmp_path / "cohort", tmp_path / "cases"))
    return add


def state(ffr):
    """A state of metrics.json."""
    area = {"mean_mm2": 5.0, "minimum_mm2": 4.0}
    return {"ffr": {"distal": ffr}, "area": area, "curvature": {"mean_per_mm": 0.1}}


def test_bias_by_artery(cohort):
    for number, (artery, difference) in enumerate([("lad", 0.02), ("lad", 0.04), ("rca", -0.01), ("rca", -0.03)]):
        cohort(number, artery, difference)
    agreement, failures = cohort.tables()
    ffr = agreement[(agreement["quantity"] == "ffr") & (agreement["comparison"] == "vci_minus_reference")]
    found = {(row.subgroup, row.value): (row.n, row.bias) for row in ffr.itertuples()}
    assert found["all", "all"] == (4, pytest.approx(0.005))
    assert found["artery", "lad"] == (2, pytest.approx(0.03))
    assert found["artery", "rca"] == (2, pytest.approx(-0.02))
    assert failures.empty


def test_failures_are_counted_by_step_and_reason(cohort):
    cohort(1, "lad", error="the stent does not fit")
    cohort(2, "lad", error="the stent does not fit")
    cohort(3, "lad", error="another")
    cohort(4, "rca")
    agreement, failures = cohort.tables()
    assert agreement.empty
    assert failures.iloc[0].tolist() == ["vci/deploy", "the stent does not fit", 2, "p1"]
    assert set(failures["reason"]) == {"the stent does not fit", "another", "not run"}


def test_a_folder_without_shards_is_refused(tmp_path):
    with pytest.raises(InputError, match="no patients"):
        patient_files(tmp_path, tmp_path)

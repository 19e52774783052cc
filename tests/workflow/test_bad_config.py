"""A bad value in the configuration is refused before any work. The message names the file, key, value and limits."""

import pytest

STUDY, DEVICE, CASE = "config/study.yaml", "config/devices/semi_compliant.yaml", "config/cases/quick_focal.yaml"


def refusal(workspace, **options):
    """Messages of a run that must be refused. The run must leave no results."""
    run = workspace.snakemake(**options)
    assert run.returncode != 0
    assert not (workspace.folder / "results").exists()
    text = run.stdout + run.stderr
    assert "Traceback" not in text and text.count("\n") < 20, text
    return text


@pytest.mark.parametrize(
    "file, old, new, expected",
    [
        (CASE, "lvm_g: 130", "lvm_g: -130", ["patient.lvm_g", "-130", "at least 30"]),
        (DEVICE, "nominal_pressure_bar: 8", "nominal_pressure_bar: 7", ["chart", "100 at 7 bar"]),
        (STUDY, "quick_focal", "quick_fokal", ["cohorts.quick[1]", "quick_fokal", "quick_focal"]),
    ],
)
def test_refused_before_work(fresh, file, old, new, expected):
    fresh.edit(file, old, new)
    text = refusal(fresh)
    for words in [file, *expected]:
        assert words in text, text


def test_a_bad_case_stops_no_other(fresh):
    fresh.edit(CASE, "lvm_g: 130", "lvm_g: -130")
    run = fresh.snakemake("--dry-run", cases="quick_branch")
    text = run.stdout + run.stderr
    assert run.returncode == 0 and "quick_branch: virtual deployment" in text, text
    assert text.count("the case quick_focal cannot run: error: ") == 1 and "patient.lvm_g" in text


def test_unknown_cohort(fresh):
    assert "one of nine, three, quick" in refusal(fresh, cohort="small")


def test_missing_surface_says_where_to_put_it(fresh, tmp_path):
    text = refusal(fresh, cases="real_artery", environment={"VCI_DATA_DIR": str(tmp_path)}.items())
    assert f"{tmp_path}/dfemtoolz_case4_artery.stl" in text
    assert "VCI_DATA_DIR" in text and "config/cases/real_artery.yaml" in text


def test_validate_command(run_module, fresh):
    good = run_module("workflow", "validate")
    assert good.returncode == 0 and "valid" in good.stdout
    fresh.edit(CASE, "lvm_g: 130", "lvm_g: 1300")
    bad = run_module("workflow", "validate", "--folder", fresh.folder / "config")
    assert bad.returncode == 2 and "1300" in bad.stderr and "Traceback" not in bad.stderr

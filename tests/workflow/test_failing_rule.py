"""A failing rule shows the end of its log and leaves no product."""

import subprocess

import pytest

TARGET = "results/cases/quick_focal/source/lumen.vtp"


@pytest.mark.slow
def test_failing_rule_shows_its_log_and_leaves_nothing(fresh):
    fresh.append("data_synthetic/generate.py", "\nraise SystemExit('the seed fell on stony ground')\n")
    run = fresh.snakemake(TARGET)
    text = run.stdout + run.stderr
    assert run.returncode != 0
    assert "the seed fell on stony ground" in text
    assert "results/cases/quick_focal/logs/generate.log failed (exit code 1)" in text
    assert not (fresh.folder / TARGET).exists()


def test_run_keeps_exit_code_and_shows_only_the_end_of_a_long_log(repo_root, tmp_path):
    log = tmp_path / "log"
    command = [repo_root / "workflow" / "run.sh", log, "bash", "-c", "seq 1000; echo last words >&2; exit 3"]
    run = subprocess.run(command, text=True, capture_output=True)
    assert run.returncode == 3
    assert "last words" in run.stderr and "1000" in run.stderr and "| 900\n" not in run.stderr
    assert log.read_text().count("\n") == 1002


def test_run_is_silent_when_all_is_well(repo_root, tmp_path):
    command = [repo_root / "workflow" / "run.sh", tmp_path / "log", "echo", "fine"]
    run = subprocess.run(command, text=True, capture_output=True)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert (tmp_path / "log").read_text() == "$ echo fine\nfine\n"

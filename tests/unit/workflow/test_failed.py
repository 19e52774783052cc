"""Which cases of a run failed, and that the study is made of the others."""

import json
import os
import subprocess

import pytest

from common.errors import InputError
from workflow.__main__ import main
from workflow.failed import cases_of_failed_arms, failed_steps, without_failed

ERROR = "error: too narrow\n  where:  main\n  value:  0.2 mm\n  remedy: another plan"


@pytest.fixture
def step(repo_root, tmp_path):
    """A function that runs a shell command as a rule does, with its log in results/cases/<case>/logs."""

    def run(name, command):
        log = tmp_path / "results" / "cases" / name
        log.parent.mkdir(parents=True, exist_ok=True)
        return subprocess.run([repo_root / "workflow" / "run.sh", log, "bash", "-c", command], capture_output=True)

    return run


def test_a_failed_step_is_told_by_its_log(step, tmp_path):
    step("a/logs/vci/deploy.log", f"echo progress; echo '{ERROR}' >&2; exit 3")
    step("b/logs/plan.log", "seq 100; exit 1")
    step("c/logs/plan.log", "echo fine")
    deploy, plan = failed_steps(tmp_path / "results")
    assert deploy == {
        "case": "a",
        "step": "vci/deploy",
        "exit_code": 3,
        "message": ERROR,
        "log": str(tmp_path / "results/cases/a/logs/vci/deploy.log"),
    }
    assert (plan["case"], plan["step"], plan["exit_code"]) == ("b", "plan", 1)
    assert plan["message"].splitlines() == ["95", "96", "97", "98", "99", "100"]


def test_a_step_that_passes_later_or_was_stopped_is_none(step, tmp_path):
    step("a/logs/plan.log", "exit 2")
    step("b/logs/plan.log", "exit 143")
    assert [one["case"] for one in failed_steps(tmp_path / "results")] == ["a"]
    step("a/logs/plan.log", "true")
    assert failed_steps(tmp_path / "results") == []


def test_failures_of_earlier_runs_do_not_count(step, tmp_path):
    step("a/logs/plan.log", "exit 2")
    mark = tmp_path / "results/cases/a/logs/plan.log.failed"
    os.utime(mark, (1000, 1000))
    assert failed_steps(tmp_path / "results", since=1001) == []
    assert len(failed_steps(tmp_path / "results", since=1000)) == 1


def test_the_study_is_made_of_the_other_cases(step, tmp_path, capsys):
    out = tmp_path / "failed.json"
    command = ["failed", "--results", str(tmp_path / "results"), "--out", str(out)]
    with pytest.raises(SystemExit) as stop:
        main(command)
    assert stop.value.code == 1 and not out.exists()
    step("a/logs/plan.log", f"echo '{ERROR}'; exit 2")
    main(command)
    assert "a failed at plan: error: too narrow" in capsys.readouterr().err
    assert without_failed(["a", "b"], out) == ["b"] and without_failed(["a", "b"], None) == ["a", "b"]
    with pytest.raises(InputError, match="every case failed"):
        without_failed(["a"], out)
    out.write_text(json.dumps({"other": 1}))
    with pytest.raises(InputError, match="workflow failed"):
        without_failed(["a", "b"], out)


def test_a_failed_step_at_half_maximum_takes_down_that_arm_alone(step, tmp_path):
    out = tmp_path / "failed.json"
    step("a/logs/half_maximum/deploy.log", "exit 3")
    step("b/logs/half_maximum/deploy.log", "exit 3")
    step("b/logs/half_maximum_no_arm.log", "exit 3")
    main(["failed", "--results", str(tmp_path / "results"), "--out", str(out)])
    assert without_failed(["a", "b", "c"], out) == ["a", "c"]
    assert cases_of_failed_arms(out) == {"a", "b"} and cases_of_failed_arms(None) == set()

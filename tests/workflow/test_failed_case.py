"""If a case fails, `make study` still makes the page of the other cases. The page says which case failed."""

import os
import stat
import subprocess

import pytest

SNAKEMAKE = """#!/bin/bash
# A stand-in: the first run fails at a case's step, the second makes the page.
echo "$@" >> runs.txt
case "$*" in *failed=*) mkdir -p results/report; echo page > results/report/index.html; exit 0;; esac
mkdir -p results/cases/quick_focal/logs
workflow/run.sh results/cases/quick_focal/logs/plan.log bash -c "%s"
exit 1
"""


def make_study(study, command):
    """Runs `make study` with a stand-in for Snakemake that has one step, `command`.

    Returns (the finished run, [arguments of each run of Snakemake]).
    """
    program = study.folder / "snakemake.sh"
    program.write_text(SNAKEMAKE % command)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    words = ["make", "--old-file=build", "study", "COHORT=quick", "CORES=1", f"SNAKEMAKE={program}"]
    run = subprocess.run(words, cwd=study.folder, text=True, capture_output=True, env=dict(os.environ))
    return run, (study.folder / "runs.txt").read_text().splitlines()


def test_the_page_is_made_of_the_other_cases(fresh):
    run, runs = make_study(fresh, "echo error: no stent fits; exit 3")
    assert run.returncode != 0, "a study of which a case failed is not all well"
    assert "quick_focal failed at plan: error: no stent fits" in run.stderr
    assert "results/report/index.html is the page of the other cases" in run.stderr
    assert len(runs) == 2 and "failed=results/study/failed.json" in runs[1]


def test_a_step_that_was_stopped_makes_no_page(fresh):
    run, runs = make_study(fresh, "exit 143")
    assert run.returncode != 0 and len(runs) == 1


@pytest.mark.slow
def test_only_the_other_cases_are_asked_for(fresh):
    log = fresh.folder / "results/cases/quick_focal/logs/plan.log"
    log.parent.mkdir(parents=True)
    log.write_text("error: no stent fits\n")
    log.with_suffix(".log.failed").write_text("3\n")
    command = ["/usr/bin/python3", "-m", "workflow", "failed", "--out", "failed.json"]
    subprocess.run(command, cwd=fresh.folder, check=True)
    report = "results/report/index.html"
    command = ["/usr/bin/snakemake", "--cores", "1", "--dry-run", "--printshellcmds", "--nocolor", report]
    command += ["--config", "cohort=quick", "failed=failed.json"]
    run = subprocess.run(command, cwd=fresh.folder, text=True, capture_output=True)
    assert run.returncode == 0, run.stderr
    made = next(line for line in (run.stdout + run.stderr).splitlines() if "reports report" in line)
    assert "--failed failed.json" in made and "quick_branch" in made and "quick_focal" not in made

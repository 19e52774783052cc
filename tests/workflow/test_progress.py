"""Messages of a run about its progress and its cases, and how a user goes on after a kill or a failure."""

import subprocess

import pytest

TARGETS = [f"results/cases/quick_focal/settings/{section}.json" for section in ("flow", "metrics")]


def make(study, *arguments):
    """Runs `make` in the study's folder, where the products of `make build` exist already."""
    command = ["make", "--old-file=build", *arguments]
    return subprocess.run(command, cwd=study.folder, text=True, capture_output=True)


def test_the_profile_of_make_study_shows_how_far_it_is(fresh):
    run = fresh.snakemake("--profile", "config/profiles/local", *TARGETS)
    text = run.stdout + run.stderr
    assert run.returncode == 0, text
    assert "quick_focal: settings of flow" in text
    assert "2 of 2 steps (100%) done" in text


@pytest.mark.slow
def test_chosen_cases_are_not_called_by_a_cohorts_name(fresh):
    report = "results/report/index.html"
    commands = {}
    for cases in ("", "quick_focal"):
        run = fresh.snakemake("--dry-run", "--printshellcmds", report, cases=cases)
        assert run.returncode == 0, run.stderr
        commands[cases] = next(line for line in (run.stdout + run.stderr).splitlines() if "reports report" in line)
    assert "--cohort quick " in commands[""] and "--cohort" not in commands["quick_focal"]


@pytest.mark.slow
def test_after_a_kill_make_says_how_to_go_on(fresh):
    """A killed Snakemake leaves its lock behind."""
    lock = fresh.folder / ".snakemake" / "locks" / "0.output.lock"
    lock.parent.mkdir(parents=True)
    lock.write_text("results/report/index.html\n")

    locked = make(fresh, "study", "COHORT=quick", "CORES=1")
    assert locked.returncode != 0 and "make unlock" in locked.stderr
    assert make(fresh, "unlock").returncode == 0 and not lock.exists()
    refused = make(fresh, "study", "COHORT=small", "CORES=1")
    assert refused.returncode != 0 and "make unlock" not in refused.stderr


@pytest.mark.slow
def test_a_failed_run_says_that_the_page_is_of_an_earlier_one(fresh):
    page = fresh.folder / "results" / "report" / "index.html"
    without = make(fresh, "study", "COHORT=small", "CORES=1")
    assert without.returncode != 0 and "earlier run" not in without.stderr
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text("<p>cohort quick</p>")
    failed = make(fresh, "study", "COHORT=small", "CORES=1")
    assert failed.returncode != 0 and "results/report/index.html is the page of an earlier run" in failed.stderr

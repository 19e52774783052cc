"""What a run prints of its progress, and of the cases it was asked for."""

TARGETS = [f"results/cases/quick_focal/settings/{section}.json" for section in ("flow", "metrics")]


def test_the_profile_of_make_study_shows_how_far_it_is(fresh):
    run = fresh.snakemake("--profile", "config/profiles/local", *TARGETS)
    text = run.stdout + run.stderr
    assert run.returncode == 0, text
    assert "quick_focal: settings of flow" in text
    assert "2 of 2 steps (100%) done" in text


def test_chosen_cases_are_not_called_by_a_cohorts_name(fresh):
    report = "results/report/index.html"
    commands = {}
    for cases in ("", "quick_focal"):
        run = fresh.snakemake("--dry-run", "--printshellcmds", report, cases=cases)
        assert run.returncode == 0, run.stderr
        commands[cases] = next(line for line in (run.stdout + run.stderr).splitlines() if "reports report" in line)
    assert "--cohort quick " in commands[""] and "--cohort" not in commands["quick_focal"]

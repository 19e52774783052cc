"""Cohorts in shards: which patients are drawn where, what a run keeps, and what it costs."""

import os

import pytest

from common.errors import InputError
from workflow import cohort
from workflow.__main__ import main
from workflow.configuration import Configuration

# Finishes every patient it is asked for but number 2, whose exit code it takes.
FINISHING_SNAKEMAKE = """#!/bin/sh
code=0
for word; do case "$word" in
  *000002/metrics.json) mkdir -p "${word%/metrics.json}/flow"; code=1;;
  *metrics.json)
    mkdir -p "${word%/metrics.json}/flow"
    echo '{}' > "$word"
    head -c 2000000 /dev/zero > "${word%/metrics.json}/flow/mesh.msh"
    echo '{}' > "${word%/metrics.json}/flow/ffr.json";;
esac; done
exit $code
"""


# Ends at once, as in a locked folder.
LOCKED_SNAKEMAKE = """#!/bin/sh
echo 'LockException: Directory cannot be locked.'
exit 1
"""
# Every patient fails at its first step, as workflow/run.sh marks it.
FAILING_SNAKEMAKE = """#!/bin/sh
for word; do case "$word" in *metrics.json)
  mkdir -p "${word%/metrics.json}/logs"
  echo 'error: too narrow' > "${word%/metrics.json}/logs/generate.log"
  echo 3 > "${word%/metrics.json}/logs/generate.log.failed";;
esac; done
exit 1
"""


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """stand_in(text): makes a script the stand-in for Snakemake, two patients a shard."""

    def use(text):
        program = tmp_path / "snakemake"
        program.write_text(text)
        program.chmod(0o755)
        monkeypatch.setattr(cohort, "SNAKEMAKE", str(program))
        monkeypatch.setattr(cohort, "SHARD_SIZE", 2)

    return use


@pytest.fixture
def fake(stand_in):
    """A stand-in that finishes all patients but one."""
    stand_in(FINISHING_SNAKEMAKE)


@pytest.fixture
def command(tmp_path, monkeypatch, repo_root):
    """command(count): `workflow cohort` in an empty folder, with this repository's configuration."""

    def run(count, *more):
        monkeypatch.chdir(tmp_path)
        places = ["--folder", str(repo_root / "config"), "--out", str(tmp_path / "out")]
        main(["cohort", "--count", str(count), "--seed", "1", *places, *more])

    return run


def cases(out):
    """{file below out: content} of all drawn patients."""
    return {str(file.relative_to(out)): file.read_text() for file in sorted(out.rglob("cases/*.yaml"))}


def test_shards_are_studies_of_their_own_with_cheap_settings(tmp_path, monkeypatch):
    monkeypatch.setattr(cohort, "SHARD_SIZE", 2)
    shards = cohort.draw_shards(3, 1, tmp_path / "out")
    assert [names for _, names in shards] == [["seed1_000001", "seed1_000002"], ["seed1_000003"]]
    for place, names in shards:
        study = Configuration(place)
        assert study.selected_cases("shard") == names
        assert study.settings(names[0])["flow"]["model"] == "axisymmetric"
        assert not study.settings(names[0])["ct"]["enabled"]
    full, names = cohort.draw_shards(1, 1, tmp_path / "full", full=True)[0]
    assert Configuration(full).settings(names[0])["flow"]["model"] == "3d"


def test_patients_stay_when_the_cohort_grows(tmp_path, monkeypatch):
    monkeypatch.setattr(cohort, "SHARD_SIZE", 2)
    out = tmp_path / "out"
    cohort.draw_shards(1, 1, out)
    before = cases(out)
    cohort.draw_shards(3, 1, out)
    assert len(cases(out)) == 3 and before.items() <= cases(out).items()


@pytest.mark.parametrize("count, seed", [(0, 1), (1, -1)])
def test_numbers_out_of_range_are_refused(tmp_path, count, seed):
    with pytest.raises(InputError, match="out of range"):
        cohort.draw_shards(count, seed, tmp_path / "out")


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="folder of something else"):
        cohort.draw_shards(1, 1, tmp_path)


def test_a_patient_that_fails_stops_no_other_and_meshes_are_dropped(tmp_path, fake):
    shards = cohort.draw_shards(3, 1, tmp_path / "out")
    results = tmp_path / "results"
    rows = cohort.run_shards(shards, 1, results=results)
    assert [(row["patients"], row["finished"], row["exit_code"]) for row in rows] == [(2, 1, 1), (1, 1, 0)]
    assert [round(row["made_mb"]) for row in rows] == [2, 2]
    assert sum(row["kept_mb"] for row in rows) < 0.001
    assert (results / "cases" / "seed1_000001" / "flow" / "ffr.json").exists()
    projected = cohort.projected_costs(tmp_path / "out", 2)
    assert [row["patients"] for row in projected] == [2, 1000, 100_000]


def test_a_shard_in_which_nothing_ran_is_an_error(stand_in, command, capsys):
    stand_in(LOCKED_SNAKEMAKE)
    with pytest.raises(SystemExit) as stop:
        command(3)
    said = capsys.readouterr()
    assert stop.value.code == 1 and "finished 0 of 3" in said.out
    assert "stopped before any patient" in said.err and "0001, 0002" in said.err and "snakemake.log" in said.err


def test_a_locked_folder_is_an_error_also_beside_patients_of_an_earlier_run(stand_in, command, tmp_path, capsys):
    stand_in(FINISHING_SNAKEMAKE)
    command(2)
    for metrics in tmp_path.rglob("metrics.json"):
        os.utime(metrics, (1000, 1000))
    stand_in(LOCKED_SNAKEMAKE)
    with pytest.raises(SystemExit):
        command(2)
    assert "finished 1 of 2" in capsys.readouterr().out


def test_patients_that_fail_by_steps_of_their_own_are_no_error(stand_in, command, tmp_path, capsys):
    stand_in(FAILING_SNAKEMAKE)
    command(3)
    assert "finished 0 of 3" in capsys.readouterr().out
    for mark in tmp_path.rglob("*.failed"):  # left by an earlier run
        os.utime(mark, (1000, 1000))
    stand_in(LOCKED_SNAKEMAKE)
    with pytest.raises(SystemExit):
        command(3)


def test_a_plan_that_fails_is_told_as_before(stand_in, command, capsys):
    stand_in(LOCKED_SNAKEMAKE)
    with pytest.raises(SystemExit) as stop:
        command(1, "--dry-run")
    assert stop.value.code == 2 and "cannot be planned" in capsys.readouterr().err


def test_projection_counts_all_runs_of_a_shard(tmp_path):
    place = tmp_path / "shards" / "0001"
    place.mkdir(parents=True)
    head = "shard,patients,finished,wall_s,cpu_s,made_mb,kept_mb\n"
    (place / "cost.csv").write_text(head + "0001,2,1,9,100,5,1\n0001,2,2,9,260,6,4\n")
    assert cohort.projected_costs(tmp_path, 4)[1] == {
        "patients": 1000,
        "core_hours": 50.0,
        "wall_hours": 12.5,
        "peak_gb": 2.1,
        "kept_gb": 2.0,
    }

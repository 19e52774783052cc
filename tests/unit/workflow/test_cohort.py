"""Cohorts in shards: which patients are drawn where, what a run keeps, and what it costs."""

import pytest

from common.errors import InputError
from workflow import cohort
from workflow.configuration import Configuration

# Finishes every patient it is asked for but number 2, whose exit code it takes.
FAKE = """#!/bin/sh
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


@pytest.fixture
def fake(tmp_path, monkeypatch):
    """A stand-in for Snakemake."""
    program = tmp_path / "snakemake"
    program.write_text(FAKE)
    program.chmod(0o755)
    monkeypatch.setattr(cohort, "SNAKEMAKE", str(program))
    monkeypatch.setattr(cohort, "SHARD", 2)


def cases(out):
    """{file below out: content} of all drawn patients."""
    return {str(file.relative_to(out)): file.read_text() for file in sorted(out.rglob("cases/*.yaml"))}


def test_shards_are_studies_of_their_own_with_cheap_settings(tmp_path, monkeypatch):
    monkeypatch.setattr(cohort, "SHARD", 2)
    shards = cohort.prepare(3, 1, tmp_path / "out")
    assert [names for _, names in shards] == [["seed1_000001", "seed1_000002"], ["seed1_000003"]]
    for place, names in shards:
        study = Configuration(place)
        assert study.selected("shard") == names
        assert study.settings(names[0])["flow"]["model"] == "axisymmetric"
        assert not study.settings(names[0])["ct"]["enabled"]
    full, names = cohort.prepare(1, 1, tmp_path / "full", full=True)[0]
    assert Configuration(full).settings(names[0])["flow"]["model"] == "3d"


def test_patients_stay_when_the_cohort_grows(tmp_path, monkeypatch):
    monkeypatch.setattr(cohort, "SHARD", 2)
    out = tmp_path / "out"
    cohort.prepare(1, 1, out)
    before = cases(out)
    cohort.prepare(3, 1, out)
    assert len(cases(out)) == 3 and before.items() <= cases(out).items()


@pytest.mark.parametrize("count, seed", [(0, 1), (1, -1)])
def test_numbers_out_of_range_are_refused(tmp_path, count, seed):
    with pytest.raises(InputError, match="out of range"):
        cohort.prepare(count, seed, tmp_path / "out")


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="folder of something else"):
        cohort.prepare(1, 1, tmp_path)


def test_a_patient_that_fails_stops_no_other_and_meshes_are_dropped(tmp_path, fake):
    shards = cohort.prepare(3, 1, tmp_path / "out")
    results = tmp_path / "results"
    rows = cohort.run(shards, 1, results=results)
    assert [(row["patients"], row["finished"], row["exit_code"]) for row in rows] == [(2, 1, 1), (1, 1, 0)]
    assert [round(row["made_mb"]) for row in rows] == [2, 2]
    assert sum(row["kept_mb"] for row in rows) < 0.001
    assert (results / "cases" / "seed1_000001" / "flow" / "ffr.json").exists()
    projected = cohort.projected(tmp_path / "out", 2)
    assert [row["patients"] for row in projected] == [2, 1000, 100_000]


def test_projection_counts_all_runs_of_a_shard(tmp_path):
    place = tmp_path / "shards" / "0001"
    place.mkdir(parents=True)
    head = "shard,patients,finished,wall_s,cpu_s,made_mb,kept_mb\n"
    (place / "cost.csv").write_text(head + "0001,2,1,9,100,5,1\n0001,2,2,9,260,6,4\n")
    assert cohort.projected(tmp_path, 4)[1] == {
        "patients": 1000,
        "core_hours": 50.0,
        "wall_hours": 12.5,
        "kept_gb": 2.0,
    }

"""The audit in time: start-up, batch means, the document of a series, and a march on a small tube."""

import json

import numpy as np
import pandas as pd
import pytest
import scipy.stats

import solved_tube
from flow import __main__ as command_line
from flow import audit

UNIT = 0.01  # s: time unit D/U, the diameter over the mean speed


def _series(values, units):
    """A table as `audit.march` makes it, with one probe, over `units` time units."""
    table = pd.DataFrame({"time_s": np.linspace(0, units * UNIT, len(values)), "ffr_0": values})
    table.attrs["factorizations"] = 3
    return table


def test_time_unit_is_a_diameter_over_the_mean_speed():
    radius_mm, speed = 1.5, 0.4
    assert audit.time_unit(radius_mm, speed * np.pi * 1.5e-3**2) == pytest.approx(3e-3 / speed)


def test_start_up_is_cut_where_the_decay_has_gone_under_the_noise():
    noise = 1e-3 * np.random.default_rng(1).normal(size=400)
    decay = 0.1 * np.exp(-np.arange(400) / 10)
    assert 30 <= audit.start_up_samples(0.7 + decay + noise) <= 80  # the decay is 1e-3 after 46 samples
    assert audit.start_up_samples(0.7 + noise) <= 40
    assert audit.start_up_samples(np.full(400, 0.7)) == 0


def test_batch_means_cover_the_mean_as_often_as_they_say():
    draws = np.random.default_rng(2).normal(0.7, 0.01, size=(1000, 163))
    found = np.array([audit.batch_means(values) for values in draws])
    covered = np.abs(found[:, 0] - 0.7) <= found[:, 1]
    assert covered.mean() == pytest.approx(0.95, abs=0.02)


def test_batch_means_are_students_interval_of_the_batches():
    values = np.repeat(np.arange(8.0), 5)
    # the first values are left out, since they fill no batch
    mean, half = audit.batch_means(np.append([99.0, -99.0], values))
    low, high = scipy.stats.t.interval(0.95, 7, loc=3.5, scale=np.arange(8.0).std(ddof=1) / np.sqrt(8))
    assert (mean - half, mean + half) == pytest.approx((low, high))


@pytest.mark.parametrize(("steady", "agrees"), [(0.7045, True), (0.7060, False)])
def test_a_steady_flow_is_held_against_the_mean(steady, agrees):
    time = np.linspace(0, 20, 2000)
    values = 0.7 + 0.002 * np.sin(7 * time) + 0.05 * np.exp(-2 * time)
    found = audit.audit_document(_series(values, 20), UNIT, [steady], 0.005)
    assert found["settled"] and found["agrees"] is agrees
    assert found["ffr_mean"] == pytest.approx(0.7, abs=2e-4)
    assert found["ffr_least"] == pytest.approx(0.698, abs=5e-4) and found["time_units"] == pytest.approx(20)
    assert 1 < found["start_up_units"] < 8 and "mean 0.70" in audit.summary_line(found)


def test_a_flow_that_drifts_has_not_settled():
    found = audit.audit_document(_series(np.linspace(0.7, 0.8, 500), 20), UNIT, [0.7], 0.005)
    assert not found["settled"] and found["agrees"] is None and "not settled" in audit.summary_line(found)


@pytest.mark.slow
def test_a_disturbed_flow_in_a_tube_returns_to_the_steady_one(tmp_path):
    case = solved_tube.make(tmp_path)
    line = ["--boundary", str(case / "boundary.json"), "--centreline", str(case / "centreline.vtp")]
    command_line.main(
        ["audit", str(case / "mesh.msh"), *line, "--out", str(tmp_path / "audit.json"), "--audit-units=2"]
    )
    found, series = json.loads((tmp_path / "audit.json").read_text()), pd.read_csv(tmp_path / "audit.csv")
    assert found["settled"] and found["agrees"] and found["time_units"] >= 2
    assert found["meshes"][0]["status"] == "converged"
    change = abs(series["ffr_0"] - found["ffr_steady"])
    assert change[1] > 1e-4, "the march starts from another flow than the steady one"
    assert change.iloc[-1] < 0.1 * change[1] and abs(found["steady_minus_mean"]) < change[1]
    assert series["time_s"].is_monotonic_increasing and len(series) == found["steps"] + 1


def test_a_step_that_fails_is_shortened_and_a_march_that_cannot_go_on_says_so():
    class Stepper:
        steps, time, problem = 0, 0.0, None

        def step(self, dt):
            asked.append(dt)
            raise audit.ComputationError("no step", "march", dt, "none")

    asked = []
    with pytest.raises(audit.ComputationError):
        list(audit._march_adaptively(Stepper(), 1.0, 10))
    assert asked[0] == audit.FIRST_STEP and asked[-1] >= audit.SHORTEST_STEP
    assert np.allclose(np.diff(np.log(asked)), np.log(audit.SMALLEST_CHANGE))

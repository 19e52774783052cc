"""The estimate of the time left, on a clock that the test turns."""

import pytest

from workflow.time_left import TYPICAL_SECONDS, TimeLeft, duration

TABLE = """Job stats:
job           count    min threads    max threads
----------  -------  -------------  -------------
flow_solve        4              1              1
scene            20              1              1
total            24              1              1
"""


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def run():
    clock = Clock()
    found = TimeLeft(clock)
    found.read_plan(TABLE)
    return found, clock


def do(run, clock, rule, seconds, steps, at_once=1):
    """Lets steps of a rule run, so many at a time."""
    for k in range(0, steps, at_once):
        for job in range(at_once):
            run.start_step((rule, k, job), rule)
        clock.now += seconds
        for job in range(at_once):
            run.finish_step((rule, k, job))


def test_nothing_is_said_by_a_few_steps(run):
    run, clock = run
    do(run, clock, "scene", 6.0, 9)
    assert run.remaining_s() is None and run.estimate_message() is None


def test_rules_that_have_run_count_with_their_own_seconds_the_others_with_usual_ones_as_slow_as_this_run(run):
    run, clock = run
    do(run, clock, "scene", 6.0, 10)  # twice the 3 s of any rule
    assert run.remaining_s() == pytest.approx(10 * 6.0 + 4 * 2 * TYPICAL_SECONDS["flow_solve"])
    do(run, clock, "flow_solve", 100.0, 2)
    assert run.remaining_s() == pytest.approx(10 * 6.0 + 2 * 100.0)


def test_steps_side_by_side_halve_it(run):
    run, clock = run
    do(run, clock, "scene", 6.0, 10, at_once=2)
    assert run.remaining_s() == pytest.approx((10 * 6.0 + 4 * 2 * TYPICAL_SECONDS["flow_solve"]) / 2)


def test_it_is_said_once_a_minute(run):
    run, clock = run
    do(run, clock, "scene", 6.1, 10)
    assert run.estimate_message() == "about 9 min left, by the 10 steps done so far"
    do(run, clock, "scene", 6.1, 1)
    assert run.estimate_message() is None


def test_at_the_end_nothing_is_left(run):
    run, clock = run
    do(run, clock, "scene", 6.0, 20)
    do(run, clock, "flow_solve", 6.0, 4)
    assert run.remaining_s() == 0.0


@pytest.mark.parametrize("seconds, words", [(20, "20 s"), (60, "1 min"), (3540, "59 min"), (7500, "2 h 05 min")])
def test_durations_in_words(seconds, words):
    assert duration(seconds) == words

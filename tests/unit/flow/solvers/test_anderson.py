"""Anderson acceleration on linear systems. It is exact once it has as many differences as there are unknowns. With
fewer differences it is better than plain steps with an old tangent."""

import numpy as np
import pytest

from flow.solvers.anderson import MOST_DIFFERENCES, AndersonAcceleration


def _iterate(matrix, old_inverse, right, count, use):
    """Norms of the residual of matrix x = right over `count` steps from x = 0. use: whether steps are accelerated."""
    learnt, x, norms = AndersonAcceleration(np.ones(len(right))), np.zeros(len(right)), []
    for _ in range(count):
        correction = old_inverse @ (right - matrix @ x)
        x = x + (learnt.step(x, correction) if use else correction)
        norms.append(np.linalg.norm(right - matrix @ x))
    return np.array(norms)


@pytest.fixture
def system():
    """(matrix, inverse of the identity, which is 30 % away from the matrix, right side)."""
    rng = np.random.default_rng(0)
    matrix = np.eye(5) + 0.3 * rng.normal(size=(5, 5)) / np.sqrt(5)
    return matrix, np.eye(5), rng.normal(size=5)


def test_a_linear_system_is_solved_in_as_many_steps_as_unknowns_and_one(system):
    assert _iterate(*system, 6, True)[-1] < 1e-9
    assert _iterate(*system, 6, False)[-1] > 1e-4


def test_differences_outlive_a_new_right_side(system):
    matrix, old_inverse, right = system
    learnt, x = AndersonAcceleration(np.ones(5)), np.zeros(5)
    for _ in range(6):
        correction = old_inverse @ (right - matrix @ x)
        x = x + learnt.step(x, correction)
    learnt.skip_difference()
    correction = old_inverse @ (2 * right - matrix @ x)
    x = x + learnt.step(x, correction)
    assert np.linalg.norm(2 * right - matrix @ x) < 1e-8


def test_weights_say_what_is_small():
    """With a single difference, a component of weight 0 is not minimised."""
    learnt = AndersonAcceleration(np.array([1.0, 0.0]))
    learnt.step(np.zeros(2), np.array([1.0, 1.0]))
    step = learnt.step(np.array([1.0, 1.0]), np.array([0.5, 5.0]))
    assert step[0] == pytest.approx(1.0) and step[1] == pytest.approx(5.0 + 5.0)


def test_old_differences_are_dropped():
    rng, learnt = np.random.default_rng(1), AndersonAcceleration(np.ones(40))
    for _ in range(MOST_DIFFERENCES + 5):
        learnt.step(rng.normal(size=40), rng.normal(size=40))
    assert len(learnt.state_differences) == len(learnt.correction_differences) == MOST_DIFFERENCES

"""Places of one lumen are mapped to another state of the lumen by the centrelines."""

import numpy as np
import pytest

from flow.geometry.centreline import Branch, Tree
from flow.geometry.correspondence import Correspondence

MAIN = slice(10, 61)  # of the points `around`: those beyond the ostium of the side branch
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a quarter about z


def tree(stretch=1.0, radius=1.5, turn=np.eye(3), shift=0.0):
    """A straight main branch of 20 mm with a side branch, stretched, widened, turned and moved."""
    branches = []
    sides = (("main", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 20.0), ("side1", (8.0, 0.0, 0.0), (0.0, 0.6, 0.8), 9.0))
    for k, (name, start, way, length) in enumerate(sides):
        s_mm = stretch * np.linspace(0, length, 101)
        points = stretch * np.array(start) + s_mm[:, None] * way
        branches.append(Branch(name, k, points @ turn.T + shift, s_mm, np.full(101, radius)))
    return Tree(branches)


def around(one, far=0.9):
    """Points (n, 3) beside the samples of a tree's axes, at the share `far` of the radius."""
    random = np.random.default_rng(5)
    points = np.concatenate([branch.points[40:] for branch in one])
    tangents = np.concatenate([np.gradient(branch.points[40:], axis=0) for branch in one])
    across = np.cross(tangents, random.normal(size=points.shape))
    return points + far * 1.5 * across / np.linalg.norm(across, axis=1, keepdims=True)


def test_the_same_lumen_gives_the_same_places():
    points = around(tree(), 0.4)
    where, turns, ratio = Correspondence(tree(), tree())(points)
    assert where == pytest.approx(points, abs=1e-12) and ratio == pytest.approx(1.0)
    assert turns == pytest.approx(np.broadcast_to(np.eye(3), turns.shape))


def test_a_turned_and_moved_lumen_is_followed():
    points = around(tree(), 0.4)
    where, turns, _ = Correspondence(tree(), tree(turn=TURN, shift=3.0))(points)
    along = np.array([1.0, 0.0, 0.0])
    main = np.abs(where - (points @ TURN.T + 3.0)).max(axis=1) < 1e-9
    assert main[MAIN].all(), "along the main branch the turn is the shortest one: it leaves z as it is"
    assert (turns @ along)[MAIN] == pytest.approx(np.broadcast_to(TURN @ along, (51, 3)))


def test_a_wider_and_longer_lumen_keeps_relative_places():
    points = around(tree(), 0.4)
    where, _, ratio = Correspondence(tree(), tree(stretch=1.1, radius=3.0))(points)
    assert ratio == pytest.approx(2.0)
    main, other = points[MAIN], where[MAIN]
    assert other[:, 0] == pytest.approx(1.1 * main[:, 0]) and other[:, 1:] == pytest.approx(2.0 * main[:, 1:])

"""Projection on a line, and lines that are refused."""

import numpy as np
import pytest

from common.errors import InputError
from reports.inputs.polyline import Polyline, read_centreline


def corner():
    return Polyline(np.array([[0.0, 0, 0], [10, 0, 0], [10, 5, 0]]), np.array([0.0, 10.0, 15.0]), "corner")


@pytest.mark.parametrize(
    "point, s, distance",
    [
        ((4.0, 3.0, 0.0), 4.0, 3.0),
        ((12.0, 4.0, 0.0), 14.0, 2.0),
        ((-3.0, 0.0, 4.0), 0.0, 5.0),
        ((10.0, 9.0, 0.0), 15.0, 4.0),
    ],
)
def test_projects_on_the_nearest_point(point, s, distance):
    assert corner().project(np.array(point)) == pytest.approx((s, distance))


def test_at_and_project_are_inverse():
    line = corner()
    for s in (0.0, 3.3, 10.0, 12.7, 15.0):
        assert line.project(line.point_at(s)) == pytest.approx((s, 0.0), abs=1e-12)


@pytest.mark.parametrize(
    "s, word", [([0.0, 1.0, 1.0], "does not increase"), ([0.0, float("nan"), 1.0], "not a number")]
)
def test_refuses_bad_arc_length(s, word):
    with pytest.raises(InputError, match=word):
        Polyline(np.zeros((3, 3)), np.array(s), "file.vtp")


def test_reads_a_named_branch(make_case):
    path = make_case() / "anatomy" / "centreline.vtp"
    assert read_centreline(path, "main").s_mm[-1] == pytest.approx(40.0)
    with pytest.raises(InputError, match="no such branch") as refusal:
        read_centreline(path, "side1")
    assert "main" in str(refusal.value)

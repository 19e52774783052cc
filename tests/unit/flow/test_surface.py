"""The tagged lumen surface: what is read, and what is refused."""

import dataclasses

import numpy as np
import pytest

import tubes
from common.errors import InputError
from flow import surface


@pytest.fixture
def tube():
    return tubes.tube(10, lambda s: 1.5)


def test_tube_round_trip(tube, tmp_path):
    tubes.write_lumen(tmp_path / "lumen.vtp", tube)
    read = surface.read(tmp_path / "lumen.vtp")
    assert read.caps == [1, 2]
    assert np.array_equal(read.points, tube.points)
    assert read.volume_mm3() == pytest.approx(np.pi * 1.5**2 * 10, rel=0.02)


def test_missing_file():
    with pytest.raises(InputError, match="anatomy step"):
        surface.read("absent.vtp")


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda tube: {"points": tube.points * 1e-3}, "mm"),
        (lambda tube: {"region": np.where(tube.region == 1, 0, tube.region)}, "tags missing"),
        (lambda tube: {"region": np.where(tube.region == 2, 0, tube.region)}, "tags missing"),
        (lambda tube: {"triangles": tube.triangles[:, ::-1]}, "inside out"),
        (lambda tube: {"triangles": tube.triangles[1:], "region": tube.region[1:]}, "not closed"),
    ],
)
def test_bad_surfaces_are_refused(tube, change, message):
    with pytest.raises(InputError, match=message):
        surface.check(dataclasses.replace(tube, **change(tube)), "lumen.vtp")

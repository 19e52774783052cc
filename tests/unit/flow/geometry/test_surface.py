"""The tagged lumen surface: a file is read as it was written, and bad surfaces are refused."""

import dataclasses

import numpy as np
import pytest

import tubes
from common.errors import InputError
from flow.geometry import centreline, surface


@pytest.fixture
def tube():
    return tubes.tube(10, lambda s: 1.5)


def test_tube_round_trip(tube, tmp_path):
    tubes.write_lumen(tmp_path / "lumen.vtp", tube)
    read = surface.read(tmp_path / "lumen.vtp")
    assert read.caps == [1, 2]
    assert np.array_equal(read.points, tube.points)
    assert read.volume_mm3() == pytest.approx(np.pi * 1.5**2 * 10, rel=0.02)


def _wall(tube):
    """Nodes (n, 3) of a Surface's wall."""
    return tube.points[np.unique(tube.triangles[tube.region == surface.WALL])]


def test_a_centreline_of_another_state_is_refused():
    """Refused are the line of a lesion for the opened lumen, and that of a tube moved aside. A side branch's line may
    start inside its parent."""
    closed, opened = tubes.lesion(1.5, 0.5, 8, 6), tubes.lesion(1.5, 0.1, 8, 6)
    wall = {radius: _wall(tubes.tube(16, radius, 0.4)) for radius in (closed, opened)}
    tree = {radius: centreline.Tree([tubes.centre_branch(16, radius)]) for radius in (closed, opened)}
    for radius in (closed, opened):
        centreline.check_wall(tree[radius], wall[radius], "lumen.vtp")
    aside = [0, 0.6, 0]
    for line, nodes in ((closed, wall[opened]), (opened, wall[closed]), (opened, wall[opened] + aside)):
        with pytest.raises(InputError, match="centreline of another lumen(.|\n)*lumen.vtp: wall's distance from main"):
            centreline.check_wall(tree[line], nodes, "lumen.vtp")
    forked, branches = tubes.fork(length=12.0, at=6.0, side_radius=0.5, side_length=6.0, edge_mm=0.6)
    centreline.check_wall(centreline.Tree(branches), _wall(forked), "lumen.vtp")
    severe = tubes.lesion(1.5, 0.95, 8, 6)  # a throat of .08 mm between nodes .8 mm apart
    centreline.check_wall(
        centreline.Tree([tubes.centre_branch(16, severe)]), _wall(tubes.tube(16, severe, 0.8)), "lumen.vtp"
    )


def test_missing_file():
    with pytest.raises(InputError, match="anatomy step"):
        surface.read("absent.vtp")


def _moved(array, at, value):
    changed = array.copy()
    changed[at] = value
    return changed


def _half_tagged(tube):
    """Tags the half of the outlet on one side as another outlet."""
    side = tube.points[tube.triangles].mean(axis=1)[:, 1] > 0
    return {"region": np.where((tube.region == 2) & side, 3, tube.region)}


def _twice(tube):
    """The tube with a smaller tube inside it, both with the same tags."""
    smaller = 0.2 * (tube.points - [5, 0, 0]) + [5, 0, 0]
    return {
        "points": np.concatenate([tube.points, smaller]),
        "triangles": np.concatenate([tube.triangles, tube.triangles + len(tube.points)]),
        "region": np.concatenate([tube.region, 0 * tube.region]),
    }


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda tube: {"points": _moved(tube.points, (40, 1), np.nan)}, "not finite(.|\n)*point 40"),
        (lambda tube: {"region": np.where(tube.region == 2, -4, tube.region)}, "tags missing or unknown(.|\n)*-4"),
        (lambda tube: {"region": _moved(tube.region, 100, 2)}, "not on one patch(.|\n)*region_id 2: 2 patches"),
        (_half_tagged, "two lumen ends touch(.|\n)*2 and 3"),
        (_twice, "not of one piece(.|\n)*2 pieces"),
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

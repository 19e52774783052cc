"""Ends were opened by deleting triangles. Number, place and radius of the ends are right, or the end is refused."""

import json

import numpy as np
import pytest
import surfaces

X = np.array([1.0, 0, 0])
ASIDE = np.array([np.cos(0.9), np.sin(0.9), 0])
# the vessels run on past where their ends are opened
TREE = [((-1, 0, 0), (31, 0, 0), 1.7, 1.4), ((12, 0, 0), 12 * X + 9.8 * ASIDE, 1.0, 0.9)]
TREE_ENDS = [(0 * X, -X, 1.7), (30 * X, X, 1.4), (12 * X + 9 * ASIDE, ASIDE, 0.9)]
TUBE_ENDS = [(1 * X, -X, 1.5), (19 * X, X, 1.5)]


@pytest.fixture(scope="module")
def tree():
    return surfaces.tree(TREE)


def check_ends(done, out, ends, depth, farther=1.0):
    """Checks that the ends of anatomy.json are right, except that up to `depth` + `farther` mm may be cut off. Each cut
    gives a warning."""
    assert done.returncode == 0, done.stderr
    found = json.loads((out / "anatomy.json").read_text())
    assert len(found["ends"]) == len(ends)
    for centre, normal, radius in ends:
        end = min(found["ends"], key=lambda e: np.linalg.norm(np.subtract(e["centre_mm"], centre)))
        off = np.subtract(end["centre_mm"], centre)
        assert -(depth + farther) < off @ normal < 0.1
        assert np.linalg.norm(off - (off @ normal) * normal) < 0.05 * radius
        assert end["diameter_mm"] == pytest.approx(2 * radius, rel=0.03)
    cut = [repair["detail"] for repair in found["repairs"] if repair["what"] == "ragged end cut flat"]
    assert done.stderr.count("warning: ragged end cut flat") == len(cut)
    return cut


@pytest.mark.parametrize("edge, depth", [(0.4, 0), (0.4, 0.4), (0.2, 0.4), (0.2, 0.8)])
@pytest.mark.parametrize("noise", [0, 0.03])
def test_tube_with_sawtooth_ends(lumen, tmp_path, edge, depth, noise):
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20, edge, capped=False)
    points = points + noise * np.random.default_rng(2).standard_normal(points.shape)
    for seed in (1, 2):
        surface = surfaces.write(tmp_path / "t.stl", *surfaces.sawtooth(points, triangles, TUBE_ENDS, depth, seed))
        done = lumen(surface, tmp_path / "out")
        cut = check_ends(done, tmp_path / "out", TUBE_ENDS, depth)
        assert len(cut) == 2
        lost = [float(detail.split("mm: ")[1].split(" mm of")[0]) for detail in cut]
        assert all(0.2 * edge < mm < depth + 2 * edge + 0.1 for mm in lost)


@pytest.mark.slow
@pytest.mark.parametrize("depth, seed", [(0.2, 1), (0.2, 3), (0.4, 2), (0.8, 1)])
def test_tree_with_sawtooth_ends(lumen, tree, tmp_path, depth, seed):
    for noise in (0, 0.02):
        points = tree[0] + noise * np.random.default_rng(seed).standard_normal(tree[0].shape)
        surface = surfaces.write(tmp_path / "t.stl", *surfaces.sawtooth(points, tree[1], TREE_ENDS, depth, seed))
        done = lumen(surface, tmp_path / "out")
        assert len(check_ends(done, tmp_path / "out", TREE_ENDS, depth)) == 3


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_rough_tree_with_sawtooth_ends(lumen, tree, tmp_path, seed):
    """Slivers whose points are scattered by 0.05 mm cross each other in some 2500 places. The result is right, or is
    refused with the place."""
    points = tree[0] + 0.05 * np.random.default_rng(seed).standard_normal(tree[0].shape)
    for depth in (0, 0.2, 0.4):
        surface = surfaces.write(tmp_path / "t.stl", *surfaces.sawtooth(points, tree[1], TREE_ENDS, depth, seed))
        done = lumen(surface, tmp_path / "out")
        if done.returncode == 0:
            # six planes, an edge of 0.2 to 0.25 mm apart, are tried behind the rim
            check_ends(done, tmp_path / "out", TREE_ENDS, depth, farther=1.75)
        else:
            assert done.returncode == 2 and "where:" in done.stderr and "mm" in done.stderr


def test_teeth_longer_than_the_radius_are_refused_with_their_place(lumen, tmp_path):
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20, 0.4, capped=False)
    surface = surfaces.write(tmp_path / "t.stl", *surfaces.sawtooth(points, triangles, TUBE_ENDS, 2.4))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 2 and "not cut flat" in done.stderr
    where = float(done.stderr.split("where:  (")[1].split(",")[0])
    assert min(abs(where - 1), abs(where - 19)) < 2


@pytest.mark.parametrize("degrees", [20, 35, 50])
@pytest.mark.parametrize("edge, depth", [(0.4, 0.3), (0.2, 0)])
def test_oblique_trims(lumen, tmp_path, degrees, edge, depth):
    """The vessel does not run along the normal of such a rim. It is cut obliquely, so the cap is an ellipse round the
    axis."""
    tilt = np.radians(degrees)
    normal = np.array([np.cos(tilt), np.sin(tilt), 0])
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 24, edge, capped=False)
    ends = [(3 * X, -normal, 1.5), (20 * X, normal, 1.5)]
    surface = surfaces.write(tmp_path / "t.stl", *surfaces.sawtooth(points, triangles, ends, depth, reach=4))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "out" / "anatomy.json").read_text())["ends"]
    assert len(found) == 2
    for end in found:
        at = np.array(end["centre_mm"])
        assert min(abs(at[0] - 3), abs(at[0] - 20)) < depth + 3 * edge and np.linalg.norm(at[1:]) < 0.08
        assert end["diameter_mm"] == pytest.approx(3, rel=0.03)  # across the axis
        assert end["area_mm2"] == pytest.approx(np.pi * 1.5**2 / np.cos(tilt), rel=0.08)

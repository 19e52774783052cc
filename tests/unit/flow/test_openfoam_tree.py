"""The comparison with OpenFOAM on a tree: those parts that need no OpenFOAM."""

import pathlib
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "verification" / "flow"))

import openfoam_run  # noqa: E402
import openfoam_tree  # noqa: E402
import tubes  # noqa: E402

from common.errors import ComputationError  # noqa: E402
from flow import settings  # noqa: E402
from flow.geometry import centreline, tet10  # noqa: E402
from flow.meshing import mesh  # noqa: E402


def _volumes(points, cells):
    return tet10.six_volumes(points, cells) / 6


def _straight(corners):
    """A quadratic tetrahedron of straight edges."""
    corners = np.array(corners, float)
    return np.concatenate([corners, corners[tet10.EDGES].mean(axis=1)])


def test_eight_parts_fill_the_tetrahedron_whichever_diagonal_is_shortest():
    shortest = set()
    for corners in (
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, 0], [3, 0, 0], [0, 1, 0], [0, 0.2, 1]],
        [[0, 0, 0], [1, 0, 0], [3, 1, 0], [0, 0.5, 1]],
        [[0, 0, 0], [1, 0, 0], [0.9, 1, 0], [2, 0.5, 1]],
    ):
        points = _straight(corners)
        lengths = [np.linalg.norm(points[a] - points[b]) for a, b, _ in openfoam_tree.DIAGONALS]
        shortest.add(int(np.argmin(lengths)))
        parts = openfoam_tree.eighths(points, np.arange(10)[None])
        whole = abs(_volumes(points, np.arange(4)[None])[0])
        assert np.allclose(_volumes(points, parts), whole / 8), "equal, and none inverted"
    assert shortest == {0, 1, 2}


def test_the_file_has_the_meshs_nodes_and_its_whole_wall(tmp_path):
    surface = tubes.tube(8.0, lambda s: 1.5, 0.6)
    tree = centreline.Tree([tubes.centre_branch(8.0, lambda s: 1.5)])
    built, _ = mesh.build(surface, tree, 2.0, settings.make(rings=2, coarse_rings=[2]))
    mesh.write(built, tmp_path / "mesh.msh")
    openfoam_tree.tetrahedra(tmp_path / "mesh.msh", tmp_path / "cut.msh")
    text = (tmp_path / "cut.msh").read_text()
    for name in ("wall", "inlet", "outlet1", "fluid"):
        assert f'"{name}"' in text
    lines = text.split("$Nodes\n")[1].splitlines()
    count = int(lines[0])
    points = np.array([line.split()[1:] for line in lines[1 : count + 1]], float)
    assert count == len(built.points)
    rows = [line.split() for line in text.split("$Elements\n")[1].splitlines()[1:-1]]
    cells = np.array([row[5:] for row in rows if row[1] == "4"], int) - 1
    faces = [row for row in rows if row[1] == "2"]
    assert len(cells) == 8 * len(built.tetrahedra) and len(faces) == 4 * len(built.triangles)
    volumes = _volumes(points, cells)
    assert volumes.min() > 0
    assert abs(volumes.sum() / (np.pi * 1.5**2 * 8.0) - 1) < 0.03, "planes between points of the round wall"


def test_inverted_polyhedra_are_refused(tmp_path):
    good = "    cells:            327\n    Min volume = 1e-12. Max volume = 2e-10. Total volume = 9.01e-07.  OK.\n"
    assert openfoam_run.figures_of_output(good, tmp_path) == {"cells": 327, "volume_mm3": pytest.approx(901)}
    bad = "    cells:            327\n ***Zero or negative cell volume detected. Number of negative volume cells: 1\n"
    with pytest.raises(ComputationError, match="no positive volume"):
        openfoam_run.figures_of_output(bad, tmp_path)

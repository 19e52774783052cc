"""The search for the cells that contain points. It tries a few near cells first, and many for the remaining points."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from flow.geometry import locate, tet10


@pytest.fixture
def locator():
    """Long, thin tetrahedra in a box of 30 x 1 x 1."""
    corners = np.random.default_rng(3).random((400, 3)) * [30.0, 1.0, 1.0]
    straight = tet10.orient_positive(corners, Delaunay(corners).simplices)
    cells = corners[straight]
    nodes = np.concatenate([cells, cells[:, tet10.EDGES].mean(axis=2)], axis=1).reshape(-1, 3)
    return locate.Locator(nodes, np.arange(len(nodes)).reshape(-1, 10))


def test_cells_are_those_of_a_search_among_many(locator, monkeypatch):
    points = np.random.default_rng(4).random((500, 3)) * [32.0, 1.2, 1.2] - [1.0, 0.1, 0.1]  # some lie outside
    cell, lam, inside = locator.find(points)
    monkeypatch.setattr(locate, "FEW_CELLS", locate.MANY_CELLS)
    many = locator.find(points)
    monkeypatch.setattr(locate, "POINTS_AT_ONCE", 7)
    parts = locator.find(points)
    assert 50 < inside.sum() < 500
    for found in (many, parts):
        assert (found[0] == cell).all() and (found[2] == inside).all()
        assert found[1] == pytest.approx(lam, abs=1e-9)
    nodes = locator.nodes[locator.cells[cell]]
    at = np.einsum("mn,mnd->md", tet10.basis(lam), nodes)
    own = np.linalg.norm(at - points, axis=1) < 1e-9  # found inside their cells
    assert own.sum() > 200 and inside[own].all()
    few = locator._best_cells(points[own], 8)[1].min(axis=1) >= 0
    assert 0 < few.sum() < own.sum()  # both searches are needed


def test_no_points_are_found_nowhere(locator):
    cell, lam, inside = locator.find(np.zeros((0, 3)))
    assert len(cell) == len(lam) == len(inside) == 0

import numpy as np
import pytest

from common.errors import ComputationError
from common.implicit import field, surface


@pytest.fixture(scope="module")
def built(branches):
    lumen = field.LumenField(branches)
    return lumen, *surface.build(lumen, 0.25)


def test_closed_manifold_sphere_like_and_outward(built):
    _, points, triangles, _ = built
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert set(map(tuple, directed)) == set(map(tuple, directed[:, ::-1]))
    assert len(points) - len(directed) // 2 + len(triangles) == 2
    a, b, c = (points[triangles[:, k]] for k in range(3))
    assert np.sum(np.cross(a, b) * c) > 0


def test_wall_vertices_lie_on_the_field(built):
    lumen, points, _, on_cap = built
    assert np.sqrt(np.mean(lumen.value(points[~on_cap]) ** 2)) < 0.001
    assert np.abs(lumen.value(points[~on_cap])).max() < 0.01


def test_caps_are_flat_discs_of_the_true_area(built, branches):
    _, points, triangles, on_cap = built
    for _, centre, normal, radius in field.open_ends(branches):
        near = np.linalg.norm(points - centre, axis=1) < 1.05 * radius
        cap = on_cap & near
        assert np.abs((points[cap] - centre) @ normal).max() < 1e-9
        inside = cap[triangles].all(axis=1)
        a, b, c = (points[triangles[inside, k]] for k in range(3))
        cross = np.cross(b - a, c - a)
        assert 0.5 * np.linalg.norm(cross, axis=1).sum() == pytest.approx(np.pi * radius**2, rel=0.02)
        assert np.all(cross @ normal > 0)


def test_few_slivers(built):
    _, points, triangles, _ = built
    a, b, c = (points[triangles[:, k]] for k in range(3))
    edges = np.stack([np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)])
    height = np.linalg.norm(np.cross(b - a, c - a), axis=1) / edges.max(axis=0)
    assert np.percentile(height / edges.max(axis=0), 1) > 0.25  # 0.87 for equilateral, 0 for a sliver
    assert edges.min() > 0.01


def test_a_surface_cut_wrongly_is_an_error(branches, monkeypatch):
    lumen = field.LumenField(branches)
    closed = field.open_ends(branches)[1:]  # the inlet stays shut
    monkeypatch.setattr(field, "open_ends", lambda _: closed + closed[:1])
    with pytest.raises(ComputationError, match="openings"):
        surface.build(lumen, 0.4)

"""Lumens of many seeds: closed, sphere-like, true to their field."""

import numpy as np
import pytest

from common import schema
from data_synthetic import field, surface, tree


@pytest.mark.parametrize("seed", range(12))
def test_lumen_is_closed_and_true(seed):
    vessel = {
        "seed": seed,
        "artery": ["lad", "lcx", "rca"][seed % 3],
        "main": {"length_mm": 32, "ostial_diameter_mm": 3.0 + 0.15 * seed, "mean_curvature_per_mm": 0.1},
        "side_branches": [{"s_mm": 18, "diameter_mm": 1.5 + 0.08 * seed, "length_mm": 10, "azimuth_deg": 30 * seed}],
        "lesions": [{"centre_s_mm": 10, "length_mm": 7, "diameter_stenosis_percent": 40 + 4 * seed}],
    }
    branches = tree.grow(schema.with_defaults(vessel, schema.read("vessel")))
    lumen = field.LumenField(branches)
    points, triangles, on_cap = surface.build(lumen, 0.25)
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert set(map(tuple, directed)) == set(map(tuple, directed[:, ::-1]))
    assert len(points) - len(directed) // 2 + len(triangles) == 2
    assert np.sqrt(np.mean(lumen.value(points[~on_cap]) ** 2)) < 0.001

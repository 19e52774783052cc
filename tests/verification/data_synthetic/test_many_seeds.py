"""Lumens of 50 seeds are closed, of genus 0 and free of self-intersections. They lie on the zero level of their field,
and their radii keep the power law.

The trees are small and the grid is coarse. A lumen takes about 1.2 seconds of processor time.
"""

import numpy as np
import pytest

from common.documents import schema
from common.implicit import field, surface
from data_synthetic import healthy_radius, crossings, tree

SEEDS = 50
SPACING_MM = 0.3
EXPONENT = 2.55


def random_vessel(seed):
    """A short vessel with one side branch and a narrowing of 40 to 84 %. Type, sizes and angles vary with the seed."""
    vessel = {
        "seed": seed,
        "artery": ["lad", "lcx", "rca"][seed % 3],
        "murray_exponent": EXPONENT,
        "main": {"length_mm": 24, "ostial_diameter_mm": 3.0 + 0.15 * (seed % 12), "mean_curvature_per_mm": 0.1},
        "side_branches": [
            {"s_mm": 13, "diameter_mm": 1.5 + 0.08 * (seed % 12), "length_mm": 9, "azimuth_deg": 30 * seed}
        ],
        "lesions": [{"centre_s_mm": 8, "length_mm": 6, "diameter_stenosis_percent": 40 + 4 * (seed % 12)}],
    }
    return schema.with_defaults(vessel, schema.read("vessel"))


@pytest.mark.parametrize("seed", range(SEEDS))
def test_lumen_is_closed_and_true(seed):
    vessel = random_vessel(seed)
    branches = tree.grow(vessel)
    lumen = field.LumenField(branches)
    points, triangles, on_cap = surface.build(lumen, SPACING_MM)
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert set(map(tuple, directed)) == set(map(tuple, directed[:, ::-1]))
    assert len(points) - len(directed) // 2 + len(triangles) == 2
    assert np.sqrt(np.mean(lumen.value(points[~on_cap]) ** 2)) < 0.001
    assert len(crossings.crossing_pairs(points, triangles)) == 0
    (fork,) = healthy_radius.bifurcations(vessel)
    before, after = (branches[0].healthy_radius(s) for s in (fork.start_mm, fork.end_mm))
    side = branches[1].healthy_radius(fork.side_level_mm)
    assert before**EXPONENT == pytest.approx(after**EXPONENT + side**EXPONENT, rel=1e-3)

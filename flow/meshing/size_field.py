"""Cell size along the tree: a fraction of the local radius, and of the jet's radius downstream of a throat."""

import numpy as np

from flow.geometry.jet import jet_radius

TALLEST = 4.0  # mm around the centreline that the background grid covers


class SizeField:
    """h(x) = R_eff(s) / cells_per_radius at the nearest centreline point s.

    R_eff is the least of R(s) and, over all upstream throats s_t, of R(s_t) + spread (s - s_t). Behind a narrowing the
    jet's shear layer keeps the throat's scale and widens slowly.
    """

    def __init__(self, tree, cells_per_radius, jet_spread):
        self.tree = tree
        self.size = np.concatenate([sizing_radius(branch, jet_spread) for branch in tree]) / cells_per_radius

    def __call__(self, points):
        """Target size in mm at points (m, 3)."""
        index, _ = self.tree.nearest(points)
        return self.size[index]

    def grid(self, points, spacing):
        """(origin (3,), spacing, shape (3,), values) over the box of `points`; far from the tree the largest size."""
        low, high = points.min(axis=0) - 2 * spacing, points.max(axis=0) + 2 * spacing
        shape = np.ceil((high - low) / spacing).astype(int) + 1
        axes = [low[k] + spacing * np.arange(shape[k]) for k in range(3)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        index, distance = self.tree.nearest(nodes, TALLEST)
        values = np.full(len(nodes), self.size.max())
        near = np.isfinite(distance)
        values[near] = self.size[index[near]]
        return low, spacing, shape, values


def sizing_radius(branch, jet_spread):
    """R_eff in mm at the branch's centreline points (n,)."""
    radius, s = branch.radius_mm, branch.s_mm
    # upstream of a throat the size follows within one radius, so that the contraction is resolved before it starts
    ahead = np.minimum.accumulate((radius + s)[::-1])[::-1] - s
    return np.minimum(jet_radius(branch, jet_spread), ahead)

"""Cell size of isotropic tetrahedra: a fraction of the local radius, or of the jet's radius behind a throat."""

import numpy as np

from flow.geometry.jet import jet_radius

GRID_REACH_MM = 4.0  # mm: nodes of the background grid further than this from all centrelines get the largest cell size


class SizeField:
    """h(x) = R_eff(s) / cells_per_radius at the nearest centreline point s.

    R_eff is the least of three radii: the vessel's, the jet's (geometry.jet), and a limit before a throat
    (`sizing_radius`). The jet's radius counts, since the shear layer round a jet is thin and widens only slowly.
    jet_spread: mm by which the jet's radius grows per mm along the branch.
    """

    def __init__(self, tree, cells_per_radius, jet_spread):
        self.tree = tree
        self.size = np.concatenate([sizing_radius(branch, jet_spread) for branch in tree]) / cells_per_radius

    def __call__(self, points):
        """Target size in mm at points (m, 3)."""
        index, _ = self.tree.nearest(points)
        return self.size[index]

    def grid(self, points, spacing):
        """Cell sizes on a regular grid for gmsh, over the bounding box of points (n, 3) widened by two spacings.

        Returns (origin (3,), spacing, shape (3,), values): shape are the numbers of nodes, values (nodes,) has z
        running fastest.
        """
        low, high = points.min(axis=0) - 2 * spacing, points.max(axis=0) + 2 * spacing
        shape = np.ceil((high - low) / spacing).astype(int) + 1
        axes = [low[k] + spacing * np.arange(shape[k]) for k in range(3)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        index, distance = self.tree.nearest(nodes, GRID_REACH_MM)
        values = np.full(len(nodes), self.size.max())
        near = np.isfinite(distance)
        values[near] = self.size[index[near]]
        return low, spacing, shape, values


def sizing_radius(branch, jet_spread):
    """R_eff in mm at the branch's centreline points (n,)."""
    radius, s = branch.radius_mm, branch.s_mm
    # before a throat R_eff falls by at most 1 mm per mm, so that the contraction is resolved before it starts
    ahead = np.minimum.accumulate((radius + s)[::-1])[::-1] - s
    return np.minimum(jet_radius(branch, jet_spread), ahead)

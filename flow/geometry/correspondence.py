"""Maps places of one lumen to another state of the same vessel, by the two centrelines.

A point keeps its branch, and its position along it as a share of the branch's length. It also keeps its direction from
the axis, and its distance from the axis in vessel radii. So a lumen that a stent has straightened or widened is mapped
to the lumen before stenting.
"""

import numpy as np


class Correspondence:
    """The map from the lumen of `tree` to that of `other`, both geometry.centreline.Tree with the same branches."""

    def __init__(self, tree, other):
        self.tree = tree
        here, matching = [], []
        for branch in tree:
            match = other[branch.name]
            s_mm = branch.s_mm * match.length_mm / branch.length_mm
            here.append((branch.points, _tangents(branch.points), branch.radius_mm))
            matching.append((match.point(s_mm), _tangents(match.point(s_mm)), match.radius(s_mm)))
        self.points, tangents, radii = (np.concatenate(part) for part in zip(*here))
        self.other_points, other_tangents, other_radii = (np.concatenate(part) for part in zip(*matching))
        self.tangents, self.radius_ratio = tangents, other_radii / radii
        self.rotations = _least_rotations(tangents, other_tangents)

    def __call__(self, points_mm):
        """(places (n, 3) in mm in the other lumen, rotations (n, 3, 3), radius ratios (n,)) for points (n, 3) in mm.

        A rotation turns directions in this lumen into directions in the other. A ratio is the other lumen's radius over
        this one's.
        """
        nearest, _ = self.tree.nearest(points_mm)
        offset = points_mm - self.points[nearest]
        axial = np.einsum("ij,ij->i", offset, self.tangents[nearest])[:, None] * self.tangents[nearest]
        radius_ratio, rotations = self.radius_ratio[nearest], self.rotations[nearest]
        moved = axial + radius_ratio[:, None] * (offset - axial)
        return self.other_points[nearest] + np.einsum("nij,nj->ni", rotations, moved), rotations, radius_ratio


def _tangents(points):
    """Unit tangents (n, 3) of a polyline."""
    change = np.gradient(points, axis=0)
    return change / np.linalg.norm(change, axis=1, keepdims=True)


def _least_rotations(before, after):
    """Rotations (n, 3, 3) by the least angle from unit vectors `before` (n, 3) to `after` (Rodrigues' formula).

    For vectors more than 172 degrees apart the matrix is no exact rotation.
    """
    cross, cosine = np.cross(before, after), np.einsum("ij,ij->i", before, after)
    skew = np.zeros((len(before), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        skew[:, i, j], skew[:, j, i] = -cross[:, k], cross[:, k]
    return np.eye(3) + skew + skew @ skew / (1.0 + np.maximum(cosine, -0.99))[:, None, None]

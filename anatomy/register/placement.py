"""Rigid placements of one lumen's axes on another's, and how well the axes fit."""

import dataclasses
import warnings

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from .tree import STEP_MM

ROBUST_SCALE = 0.25  # usual radii; larger residuals hardly count, as where a stent has straightened the vessel
# Weight of all landmarks together, where all axes together have the weight 1. It is enough to decide what the axes do
# not fix, such as a turn about a straight vessel. It is too little to spoil a good fit of the axes.
LANDMARK_WEIGHT = 0.1
RADIUS_WEIGHT = 0.5  # weight of radii against positions: radii fix the place along a straight vessel


@dataclasses.dataclass(frozen=True)
class Placement:
    """A rigid motion: it moves points x, in mm, to rotation x + translation."""

    rotation: Rotation
    translation: np.ndarray

    def apply(self, points):
        """Points (n, 3) after the motion."""
        return self.rotation.apply(points) + self.translation

    def mean_distance_mm(self, other, points):
        """Mean distance between points (n, 3) moved by this placement and by the other one."""
        return float(np.linalg.norm(self.apply(points) - other.apply(points), axis=1).mean())


class Target:
    """The axes of a Tree, prepared for finding the samples nearest to given points.

    points, tangents (n, 3): places in mm and directions of all samples. radius, names (n,): their radii in mm, and the
    names of their branches.
    """

    def __init__(self, tree):
        self.tree, self.usual_radius_mm = tree, tree.usual_radius_mm
        self.points, self.radius, self.names = tree.points, tree.radius, tree.names
        tangents = [np.gradient(line.points, axis=0) for line in tree.branches.values()]
        self.tangents = np.concatenate([t / np.linalg.norm(t, axis=1, keepdims=True) for t in tangents])
        self.search_tree = cKDTree(self.points)

    def offsets(self, points):
        """For points (k, 3): offsets (k, 3) across the nearest axis, distances (k,) from it, nearest samples (k,).

        Lengths are in mm. Beyond the end of an axis the distance includes the length beyond it.
        """
        _, nearest = self.search_tree.query(points)
        offset, tangent = points - self.points[nearest], self.tangents[nearest]
        along = np.einsum("ij,ij->i", offset, tangent)
        across = offset - along[:, None] * tangent
        past_the_end = np.maximum(np.abs(along) - STEP_MM / 2, 0.0)  # a sample covers half a step on both sides
        return across, np.hypot(np.linalg.norm(across, axis=1), past_the_end), nearest


def fit_rigid(post, pre, weights=None):
    """The Placement that moves points post (n, 3) to pre (n, 3) by (weighted) least squares."""
    middle_post, middle_pre = (np.average(points, axis=0, weights=weights) for points in (post, pre))
    with warnings.catch_warnings():  # scipy warns if points lie in one line, which leaves the turn about it open
        warnings.simplefilter("ignore", UserWarning)
        rotation, _ = Rotation.align_vectors(pre - middle_pre, post - middle_post, weights)
    return Placement(rotation, middle_pre - rotation.apply(middle_post))


def cost(target, tree, placement):
    """Misfit: mean over the samples of both axes of min((distance / usual radius)^2, 1).

    It is 0 if the axes coincide and 1 if they are far apart. tree: the Tree that the placement moves.
    """
    moved = placement.apply(tree.points)
    _, to_pre, _ = target.offsets(moved)
    to_post, _ = cKDTree(moved).query(target.points)
    return float(np.mean(np.minimum(np.concatenate([to_pre, to_post]) / target.usual_radius_mm, 1.0) ** 2))


def refine_placement(target, tree, start, landmarks):
    """The Placement near `start` that fits the axes by a robust loss and the landmarks by least squares.

    By the robust loss, parts of the axes that have moved, changed their radius or are missing hardly count. landmarks:
    (pre (m, 3), post (m, 3)) in mm. The user gives them, so none is treated as an outlier.
    """
    points, radius = tree.points, tree.radius
    middle = points.mean(axis=0)
    weight = np.sqrt(LANDMARK_WEIGHT * len(points) / max(len(landmarks[0]), 1))

    def placed(move):
        rotation = Rotation.from_rotvec(move[:3] / target.usual_radius_mm) * start.rotation
        return Placement(rotation, start.apply(middle[None])[0] + move[3:] - rotation.apply(middle))

    def residuals(move):
        placement = placed(move)
        across, distance, nearest = target.offsets(placement.apply(points))
        radii = RADIUS_WEIGHT * (radius - target.radius[nearest])
        near = distance < 2 * target.usual_radius_mm
        axes = np.concatenate([(across * near[:, None]).ravel(), radii * near]) / target.usual_radius_mm
        marks = (placement.apply(landmarks[1]) - landmarks[0]).ravel() if len(landmarks[0]) else np.zeros(0)
        return np.concatenate([robust_residuals(axes), weight * marks / target.usual_radius_mm])

    return placed(least_squares(residuals, np.zeros(6), diff_step=1e-4, max_nfev=60).x)


def robust_residuals(residuals):
    """Residuals (n,) whose squares are Cauchy's loss of the given residuals r (n,).

    The loss is S^2 ln(1 + (r / S)^2), where S is ROBUST_SCALE.
    """
    return ROBUST_SCALE * np.sign(residuals) * np.sqrt(np.log1p((residuals / ROBUST_SCALE) ** 2))

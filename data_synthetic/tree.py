"""Grows the coronary tree of a virtual patient: axes, healthy radii, lumen radii."""

import collections
from dataclasses import dataclass, field

import numpy as np

from common.errors import InputError
from common.implicit.cut import reach_of_cut
from common.implicit.curves import SAMPLE_MM, Curve, curve_from_curvatures
from common.implicit.field import open_ends
from common.implicit.roots import smooth_step
from common.patient.plaque_types import FIBROUS

from . import healthy_radius, disease

HEART_CURVATURE = {"lad": 1 / 45, "lcx": 1 / 32, "rca": 1 / 26}  # 1/mm: curvature of an artery's bend over the heart
# Widths of two Gaussian kernels that turn noise into random curvature, so that bends alternate over about 15 mm. The
# wide kernel is subtracted from the narrow one. Both have the same integral, so the random curvature averages to about
# 0 and bends do not become loops.
NARROW_KERNEL_MM, WIDE_KERNEL_MM = 3.0, 8.0
MOST_DRAWS = 60  # a tree is drawn at most this many times for one seed


@dataclass
class Branch:
    """One branch of a tree. All arrays (n,) or (n, 3) are samples along `axis`, which is the lumen's axis.

    radius_mm: radius of the lumen. healthy_radius_mm: radius of the healthy lumen. shift_mm: vector from the healthy
    vessel's axis to the lumen's. parent: name of the branch from which it leaves, "" for the main vessel.
    """

    name: str
    parent: str
    s_on_parent_mm: float
    axis: Curve
    radius_mm: np.ndarray
    healthy_radius_mm: np.ndarray
    shift_mm: np.ndarray
    lesions: list = field(default_factory=list)

    def radius(self, s_mm):
        """Lumen radius (mm) at arc lengths s_mm, constant beyond the ends."""
        return _interpolate(s_mm, self.axis.s_mm, self.radius_mm)

    def radius_slope(self, s_mm):
        """Derivative of `radius` with respect to arc length."""
        return _interpolate(s_mm, self.axis.s_mm, self.radius_mm, derivative=True)

    def least_radius(self, s_mm):
        """Distance (mm) from the axis to the nearest wall in the sections at s_mm: a section is a circle."""
        return self.radius(s_mm)

    def healthy_radius(self, s_mm):
        """Healthy radius (mm) at arc lengths s_mm."""
        return _interpolate(s_mm, self.axis.s_mm, self.healthy_radius_mm)

    def shift(self, s_mm):
        """Vectors (..., 3) from the healthy vessel's axis to the lumen's, mm."""
        return np.stack([_interpolate(s_mm, self.axis.s_mm, self.shift_mm[:, k]) for k in range(3)], axis=-1)

    def plaque_thickness(self, s_mm, theta_rad):
        """Distance (mm) from the lumen wall to the healthy wall along the ray at theta in the section at s."""
        s_mm, theta_rad = np.broadcast_arrays(np.asarray(s_mm, float), theta_rad)
        _, normal, binormal = self.axis.frame(s_mm)
        ray = np.cos(theta_rad)[..., None] * normal + np.sin(theta_rad)[..., None] * binormal
        shift = self.shift(s_mm)
        across = np.sum(shift * ray, axis=-1)
        healthy = self.healthy_radius(s_mm)
        reach = -across + np.sqrt(np.maximum(healthy**2 - np.sum(shift**2, axis=-1) + across**2, 0))
        return np.maximum(reach - self.radius(s_mm), 0)

    def calcium_share(self, s_mm, theta_rad):
        """Largest share of calcium (0 ... 1) of the branch's lesions at (s, theta)."""
        shares = [disease.calcium_share(lesion, s_mm, theta_rad) for lesion in self.lesions]
        return np.max(shares, axis=0) if shares else np.zeros(np.broadcast(s_mm, theta_rad).shape)

    def uncalcified_type(self, s_mm):
        """Plaque type (int) outside calcium: type of the nearest lesion, or fibrous in a branch without a lesion."""
        if not self.lesions:
            return np.full(np.shape(s_mm), FIBROUS)
        distance = [np.abs(s_mm - le["centre_s_mm"]) / le["length_mm"] for le in self.lesions]
        types = np.array([disease.PLAQUE_TYPES[le["plaque"]] for le in self.lesions])
        return types[np.argmin(distance, axis=0)]


def _interpolate(s_mm, samples, values, derivative=False):
    """Cubic Hermite interpolation of evenly spaced samples, or its derivative. It is constant beyond the ends.

    The field's gradient needs the continuous derivative. The slopes are central differences. So a value between two
    samples may lie slightly outside their range.
    """
    spacing = samples[1] - samples[0]
    wanted = (np.asarray(s_mm, float) - samples[0]) / spacing
    x = np.clip(wanted, 0, len(samples) - 1)
    i = np.minimum(x.astype(int), len(samples) - 2)
    t = x - i
    slope = np.gradient(values)
    v0, v1, m0, m1 = values[i], values[i + 1], slope[i], slope[i + 1]
    if derivative:
        inner = m0 + t * (6 * (v1 - v0) - 4 * m0 - 2 * m1) + 3 * t * t * (2 * (v0 - v1) + m0 + m1)
        return np.where(x == wanted, inner, 0.0) / spacing
    return v0 + t * m0 + t * t * (3 * (v1 - v0) - 2 * m0 - m1) + t**3 * (2 * (v0 - v1) + m0 + m1)


def _gaussian(x, width):
    return np.exp(-0.5 * (x / width) ** 2) / width


def _random_axis(vessel, rng):
    """The main vessel's axis (Curve): the bend over the heart plus smooth random curvature.

    vessel (dict) gives the mean curvature and its upper bound.
    """
    main = vessel["main"]
    count = int(round(main["length_mm"] / SAMPLE_MM)) + 1
    s = np.linspace(0, main["length_mm"], count)
    offset = np.subtract.outer(s, np.arange(-3 * WIDE_KERNEL_MM, main["length_mm"] + 3 * WIDE_KERNEL_MM, 2.0))
    kernel = _gaussian(offset, NARROW_KERNEL_MM) - _gaussian(offset, WIDE_KERNEL_MM)
    noise = kernel @ rng.standard_normal((offset.shape[1], 2))
    noise /= np.sqrt(np.mean(noise**2))
    wanted, bound = main["mean_curvature_per_mm"], main["max_curvature_per_mm"]
    base = np.array([min(HEART_CURVATURE[vessel["artery"]], wanted), 0.0])

    def curvatures(scale):
        k = base + scale * noise
        size = np.linalg.norm(k, axis=1, keepdims=True)
        return k / (1 + (size / bound) ** 4) ** 0.25  # keeps the curvature below `bound`, smoothly

    low, high = 0.0, 20 * bound
    for _ in range(60):
        middle = 0.5 * (low + high)
        if np.mean(np.linalg.norm(curvatures(middle), axis=1)) < wanted:
            low = middle
        else:
            high = middle
    k = curvatures(0.5 * (low + high))
    return Curve(curve_from_curvatures(k[:, 0], k[:, 1], s[1]))


def _side_axis(main, side, main_radius, root):
    """Axis of a side branch: it leaves at its angle, then follows the main vessel's direction at a distance.

    main: Curve of the main vessel before any lesion; main_radius: its healthy radius (mm) there. root: point (3,) in mm
    where the axis starts.
    """
    tangent, normal, binormal = main.frame(side["s_mm"])
    azimuth, angle = np.radians(side["azimuth_deg"]), np.radians(side["angle_deg"])
    outward = np.cos(azimuth) * normal + np.sin(azimuth) * binormal
    s = np.linspace(0, side["length_mm"], int(round(side["length_mm"] / SAMPLE_MM)) + 1)
    # The branch runs straight to 3 mm past the main wall. Then it turns towards the main vessel's direction, by at most
    # 0.04 rad/mm, until the angle is 30 degrees.
    straight = main_radius / np.sin(angle) + 3.0
    turned = np.maximum(angle - 0.04 * np.maximum(s - straight, 0) * smooth_step((s - straight) / 4), np.radians(30))
    turned = np.minimum(turned, angle)
    direction = np.cos(turned)[:, None] * tangent + np.sin(turned)[:, None] * outward
    steps = 0.5 * (direction[1:] + direction[:-1]) * s[1]
    return Curve(root + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]))


def _branch_with_lesions(name, parent, s_parent, axis, healthy, lesions, rng):
    """The Branch with its lesions: they narrow the lumen, and eccentric plaque shifts the lumen's axis.

    axis: Curve of the healthy vessel. healthy: its radii at the samples of the axis.
    """
    s = axis.s_mm
    phases = rng.uniform(0, 2 * np.pi, len(lesions))
    loss, relative_shift = np.zeros_like(s), np.zeros((len(s), 3))
    for lesion, phase in zip(lesions, phases):
        profile = disease.stenosis_profile(lesion, s, phase)
        lesion_loss = 0.01 * lesion["diameter_stenosis_percent"] * profile / max(profile.max(), 1e-12)
        direction = np.radians(lesion["direction_deg"])
        ray = np.cos(direction) * axis.normals + np.sin(direction) * axis.binormals
        # Where lesions overlap, the deeper one counts. The change from one to the other is smooth enough at this
        # sampling.
        deeper = lesion_loss > loss
        loss = np.maximum(loss, lesion_loss)
        relative_shift = np.where(
            deeper[:, None], (lesion["eccentricity"] * lesion_loss)[:, None] * ray, relative_shift
        )
    shift = relative_shift * healthy[:, None]
    shifted = Curve(axis.points_mm + shift) if np.any(shift) else axis
    # The values were sampled along the healthy axis. s_new: arc lengths of the same points along the lumen's axis.
    s_new = shifted.nearest(axis.points_mm + shift)
    moved = [dict(le, centre_s_mm=float(np.interp(le["centre_s_mm"], s, s_new))) for le in lesions]

    def resampled(values):
        return np.interp(shifted.s_mm, s_new, values)

    radius = resampled(healthy * (1 - loss))
    shift_new = np.stack([resampled(shift[:, k]) for k in range(3)], axis=1)
    return Branch(name, parent, s_parent, shifted, radius, resampled(healthy), shift_new, moved)


SHARP_BEND, SELF_CONTACT, BRANCH_CONTACT, END_CONTACT = "sharp", "itself", "others", "end"
REMEDY = {
    SHARP_BEND: "less eccentricity, a longer or milder lesion, or less curvature",
    SELF_CONTACT: "another seed, less curvature, or a shorter vessel",
    BRANCH_CONTACT: "another seed, other azimuths, less curvature, or shorter side branches",
    END_CONTACT: "another seed, other azimuths, less curvature, or longer or shorter side branches",
}


def _first_conflict(branches):
    """(reason, name of the branch) of the first conflict; None if there is none.

    The reason is one of four. SHARP_BEND: a bend whose radius is less than 1.25 lumen radii. SELF_CONTACT,
    BRANCH_CONTACT: a branch comes near itself or, away from the roots, near another branch. END_CONTACT: a branch
    passes close before an open end.
    """
    for branch in branches:
        axis, radius = branch.axis, branch.radius_mm
        if np.any(axis.curvature(axis.s_mm) * radius > 0.8):
            return SHARP_BEND, branch.name
        coarse = slice(None, None, 5)
        p, s, r = axis.points_mm[coarse], axis.s_mm[coarse], branch.healthy_radius_mm[coarse]
        distance = np.linalg.norm(p[:, None] - p[None], axis=2)
        if np.any((np.abs(np.subtract.outer(s, s)) > 8 * r.max()) & (distance < np.add.outer(r, r) + 2.0)):
            return SELF_CONTACT, branch.name
        if any(
            _walls_too_close(branch, other) for other in branches if other is not branch and other.name >= branch.name
        ):
            return BRANCH_CONTACT, branch.name
    for branch in branches:
        if _passes_before_an_end(branch, branches):
            return END_CONTACT, branch.name
    return None


def _passes_before_an_end(branch, branches):
    """Whether the wall of `branch` lies where the surface is cut off at an open end of one of `branches`.

    Beyond an open end the vessel is first meshed straight on, then cut off at the end's plane. A wall in its way would
    merge with it, and would be cut open.
    """
    axis, every = branch.axis, slice(None, None, 3)
    theta = np.linspace(0, 2 * np.pi, 24, endpoint=False)[:, None, None]
    ray = np.cos(theta) * axis.normals[every] + np.sin(theta) * axis.binormals[every]
    wall = (axis.points_mm[every] + branch.radius_mm[every, None] * ray).reshape(-1, 3)
    for _, centre, normal, radius in open_ends(branches):
        height, reached = reach_of_cut(wall, centre, normal, radius)
        # The end's own rim lies in the plane, at height 0. It does not count.
        if np.any(reached & (height > 0.01)):
            return True
    return False


def _walls_too_close(branch, other):
    """Whether the walls of `other` and `branch` come within 1 mm, away from the root of `other` or a common root."""
    coarse = slice(None, None, 5)
    p, r = branch.axis.points_mm[coarse], branch.healthy_radius_mm[coarse]
    q, t, ro = other.axis.points_mm[coarse], other.axis.s_mm[coarse], other.healthy_radius_mm[coarse]
    gap = np.linalg.norm(p[:, None] - q[None], axis=2) - np.add.outer(r, ro)
    root = other.parent == branch.name
    # A side branch may be near its parent only at its root, over this length of its axis.
    free = t > (branch.healthy_radius(other.s_on_parent_mm) / np.sin(np.radians(30)) + 2.5 * ro[0] if root else 0)
    if not root and abs(other.s_on_parent_mm - branch.s_on_parent_mm) < 4 * branch.healthy_radius_mm.max():
        free = t > 6
    return bool(np.any(gap[:, free] < 1.0))


def grow(vessel, where="vessel"):
    """Branches [main, side1, ...] of a checked vessel (dict, defaults filled in).

    The axes are those of the lumen; the inlet is at the origin. Random axes are drawn from the seed until no branches
    conflict. where: the vessel's place in the case, for messages. Raises InputError if all MOST_DRAWS fail.
    """
    rng = np.random.default_rng(vessel["seed"])
    conflicts = collections.Counter()
    for _ in range(MOST_DRAWS):
        axis = _random_axis(vessel, rng)
        healthy = healthy_radius.main_healthy_radius(vessel, axis.s_mm)
        lesions = {"main": []}
        for lesion in vessel["lesions"]:
            lesions.setdefault(lesion["branch"], []).append(lesion)
        main = _branch_with_lesions("main", "", 0.0, axis, healthy, lesions["main"], rng)
        branches = [main]
        sides = zip(healthy_radius.ordered_side_branches(vessel), healthy_radius.bifurcations(vessel))
        for index, (side, fork) in enumerate(sides):
            name = f"side{index + 1}"
            # Eccentric plaque shifts the main lumen. The side branch opens into the lumen where it is.
            s_main = float(main.axis.nearest(axis.point(np.array([side["s_mm"]])))[0])
            main_healthy = float(healthy_radius.main_healthy_radius(vessel, side["s_mm"]))
            side_axis = _side_axis(axis, side, main_healthy, main.axis.point(s_main))
            radius = healthy_radius.side_healthy_radius(side, fork, side_axis.s_mm)
            branches.append(_branch_with_lesions(name, "main", s_main, side_axis, radius, lesions.get(name, []), rng))
        conflict = _first_conflict(branches)
        if conflict is None:
            return branches
        conflicts[conflict] += 1
    (reason, name), count = conflicts.most_common(1)[0]
    descriptions = {
        SHARP_BEND: f"{name} bends more sharply than its lumen is wide",
        SELF_CONTACT: f"{name} meets itself",
        END_CONTACT: f"{name} passes close before an open end",
    }
    raise InputError(
        f"no tree clear of itself in {MOST_DRAWS} draws",
        f"{where}.seed",
        f"{vessel['seed']}: in {count} draws {descriptions.get(reason, f'{name} meets another branch')}",
        REMEDY[reason],
    )

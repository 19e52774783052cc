"""The lumen as an implicit field: about the distance to the wall in mm, negative inside, zero on the wall."""

import numpy as np

from .roots import BLEND_MM, root_of

NARROW_BAND_MM = 0.6  # on a grid the field is computed only this near to the wall


def smooth_minimum(a, b, width=BLEND_MM):
    """Smooth minimum of a and b (mm): below min(a, b) by at most width / 4, equal to it where |a - b| >= width."""
    h = np.maximum(width - np.abs(a - b), 0) / width
    return np.minimum(a, b) - 0.25 * width * h * h


def _smooth_minimum_slope(a, b, width):
    """Derivative of smooth_minimum with respect to a. The derivative with respect to b is 1 minus this."""
    half = 0.5 * np.maximum(width - np.abs(a - b), 0) / width
    return np.where(a < b, 1 - half, half)


class LumenField:
    """Smooth union of the branches. The field of one branch at a point x is |x - c(s)| - r(s).

    c(s) is the point of the branch's axis nearest to x, r(s) the radius there. Only different branches are blended, so
    a single branch has its exact radius. A side branch begins as its Root says. Open ends run straight on beyond the
    caps.
    """

    def __init__(self, branches):
        self.branches = branches
        self._roots = []
        for branch in branches:
            self._roots.append(root_of(branch, list(zip(branches, self._roots))))

    def radius(self, branch, s_mm, offset_mm):
        """Radius (n,) in mm of one branch at arc lengths s_mm (n,), in the directions of offset_mm (n, 3)."""
        return branch.radius(s_mm)

    def radius_gradient(self, branch, s_mm, offset_mm, arc_gradient):
        """Gradient (n, 3) of `radius` at the points that lie offset_mm (n, 3) from the axis at s_mm (n,).

        arc_gradient: gradient (n, 3) of the points' arc length.
        """
        return branch.radius_slope(s_mm)[:, None] * arc_gradient

    def axis_radius(self, number, s_mm):
        """Radius (n,) in mm of a branch, by its number, at arc lengths s_mm (n,), also near its root."""
        return self.branches[number].radius(s_mm) * self._roots[number].share(s_mm)

    def branch_value(self, number, points_mm, iterations=4):
        """Field (n,) in mm of one branch alone, by its number, at points (n, 3). iterations: see Curve.nearest."""
        branch = self.branches[number]
        s, offset = _nearest_on_axis(branch, points_mm, iterations)
        return np.linalg.norm(offset, axis=1) - self._roots[number].share(s) * self.radius(branch, s, offset)

    def value(self, points_mm, iterations=4):
        """Field (n,) in mm of all branches at points (n, 3). iterations: see Curve.nearest."""
        total = self.branch_value(0, points_mm, iterations)
        for number, branch in enumerate(self.branches[1:], start=1):
            # A side branch cannot change the minimum far from itself; skipping it saves most of the work.
            near = _inside_box(branch, points_mm, 3.0)
            if near.any():
                value = self.branch_value(number, points_mm[near], iterations)
                total[near] = smooth_minimum(total[near], value, self._roots[number].blend_mm)
        return total

    def value_and_gradient(self, points_mm):
        """Field (n,) in mm and its gradient (n, 3) at points (n, 3)."""
        total, gradient = self._branch_value_and_gradient(0, points_mm)
        for number, branch in enumerate(self.branches[1:], start=1):
            near = _inside_box(branch, points_mm, 3.0)
            if near.any():
                blend = self._roots[number].blend_mm
                value, slope = self._branch_value_and_gradient(number, points_mm[near])
                share = _smooth_minimum_slope(total[near], value, blend)[:, None]
                gradient[near] = share * gradient[near] + (1 - share) * slope
                total[near] = smooth_minimum(total[near], value, blend)
        return total, gradient

    def _branch_value_and_gradient(self, number, points_mm):
        branch, root = self.branches[number], self._roots[number]
        s, offset = _nearest_on_axis(branch, points_mm, iterations=4)
        distance = np.linalg.norm(offset, axis=1)
        # The distance does not change with s, as its point of the axis is the nearest one. Only the radius does.
        arc_gradient = branch.axis.arc_length_gradient(points_mm, s)
        if branch.parent:
            arc_gradient[s <= 0] = 0.0  # the round end has one centre
        radius, share = self.radius(branch, s, offset), root.share(s)
        slope = share[:, None] * self.radius_gradient(branch, s, offset, arc_gradient)
        slope += (radius * root.share_slope(s))[:, None] * arc_gradient
        outward = offset / np.maximum(distance, 1e-12)[:, None]
        return distance - share * radius, outward - slope

    def project(self, points_mm, iterations=3):
        """Points (n, 3) moved onto the wall (zero level) along the gradient, by Newton steps of bounded length."""
        for _ in range(iterations):
            value, gradient = self.value_and_gradient(points_mm)
            step = value / np.maximum(np.sum(gradient**2, axis=1), 0.1)
            points_mm = points_mm - np.clip(step, -0.3, 0.3)[:, None] * gradient
        return points_mm


def _nearest_on_axis(branch, points_mm, iterations):
    """(arc lengths (n,) of the points of the branch's axis nearest to points (n, 3), offsets (n, 3) from them), mm."""
    s = branch.axis.nearest(points_mm, iterations)
    if branch.parent:
        s = np.maximum(s, 0.0)  # a side branch starts inside its parent, with a round end
    return s, points_mm - branch.axis.point(s)


def _inside_box(branch, points_mm, margin_mm):
    reach = branch.healthy_radius_mm.max() + margin_mm
    low, high = branch.axis.points_mm.min(axis=0) - reach, branch.axis.points_mm.max(axis=0) + reach
    return np.all((points_mm > low) & (points_mm < high), axis=1)


def open_ends(branches):
    """[(name, centre (3,) mm, outward unit normal (3,), radius mm)] of the open ends, the inlet first."""
    main = branches[0]
    first, _, _ = main.axis.frame(0.0)
    found = [("inlet", main.axis.point(0.0), -first, float(main.radius(0.0)))]
    for number, branch in enumerate(branches):
        length = branch.axis.length_mm
        tangent, _, _ = branch.axis.frame(length)
        found.append((f"outlet{number + 1}", branch.axis.point(length), tangent, float(branch.radius(length))))
    return found


def sample_grid(field, spacing_mm):
    """Field on a regular grid, exact near the wall only: (origin (3,) mm, values (nx, ny, nz) mm).

    Grid points farther than NARROW_BAND_MM from the wall hold +-NARROW_BAND_MM, so that no false surface appears. The
    grid also covers the straight extensions of the open ends.
    """
    axis_samples = []
    for number, branch in enumerate(field.branches):
        axis, extension = branch.axis, 2 * branch.healthy_radius_mm.max()
        s = np.arange(-extension if not branch.parent else 0.0, axis.length_mm + extension, spacing_mm)
        axis_samples.append((axis.point(s), field.axis_radius(number, s)))
    margin = max(r.max() for _, r in axis_samples) + NARROW_BAND_MM + 2 * spacing_mm
    low = np.min([p.min(axis=0) for p, _ in axis_samples], axis=0) - margin
    high = np.max([p.max(axis=0) for p, _ in axis_samples], axis=0) + margin
    shape = np.ceil((high - low) / spacing_mm).astype(int) + 1
    # The wall lies between an inner and an outer tube about each axis. Balls along the axis mark both tubes.
    near = np.zeros(shape, bool)
    inside = np.zeros(shape, bool)
    for points, radii in axis_samples:
        for point, radius in zip(points, radii):
            reach = radius + NARROW_BAND_MM
            i0 = np.maximum(np.floor((point - reach - low) / spacing_mm).astype(int), 0)
            i1 = np.minimum(np.ceil((point + reach - low) / spacing_mm).astype(int) + 1, shape)
            x, y, z = (low[k] + spacing_mm * np.arange(i0[k], i1[k]) - point[k] for k in range(3))
            squared = x[:, None, None] ** 2 + y[None, :, None] ** 2 + z[None, None, :] ** 2
            box = np.s_[i0[0] : i1[0], i0[1] : i1[1], i0[2] : i1[2]]
            near[box] |= squared < reach**2
            inside[box] |= squared < max(radius - NARROW_BAND_MM, 0) ** 2
    values = np.where(inside, -NARROW_BAND_MM, NARROW_BAND_MM)
    band = np.argwhere(near & ~inside)
    values[tuple(band.T)] = field.value(low + spacing_mm * band, iterations=1)
    return low, values

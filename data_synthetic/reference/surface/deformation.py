"""Displacement of any point near the branch, interpolated from the displacements of the lumen in the slices."""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, RegularGridInterpolator
from scipy.spatial.distance import cdist

FADE_DISTANCE_MM = 8.0  # distance from the lumen at which the displacement of the surroundings has fallen to 0
CAP_FADE_MM = 2.0  # distance over which the displacement falls to 0 towards a cap of the vessel
# Farther from the lumen than MEAN_FROM_MM a displacement is a weighted mean over several sections. The weights' width
# is MEAN_WIDTH times the distance from the lumen. The sections are MEAN_STEP_MM apart.
MEAN_FROM_MM = 0.3
MEAN_WIDTH, MEAN_STEP_MM = 0.7, 0.2
# Sections with a weight below exp(-LARGEST_EXPONENT) are left out. POINTS_AT_ONCE limits the memory.
LARGEST_EXPONENT, POINTS_AT_ONCE = 8.0, 2000
# Grid on which a span's displacement is stored: its spacing along the axis and number of intervals round it.
GRID_SPACING_MM, GRID_ANGLES = 0.1, 180


class SpanField:
    """Displacement of the lumen over arc length and angle within one span of slices.

    s_mm (n,), theta_rad (m,): places, the angles evenly from 0. displacement (n, m, 2): in mm along the section's
    normal and binormal. It is interpolated by monotone cubics along s and periodic cubics round the axis.

    coupling_mm: a length l, 0 for no coupling. Single slices lack the bending of the wall along the vessel. So the
    field is coupled along the axis as in a cylindrical shell: u solves u + l^4/4 d^4u/ds^4 = u_slice with free ends.
    This smooths jumps and does not change a cubic.
    """

    def __init__(self, s_mm, theta_rad, displacement, coupling_mm=0.0):
        s_mm = np.asarray(s_mm, float)
        fine_s = grid_positions(s_mm)
        along = PchipInterpolator(s_mm, displacement, axis=0)(fine_s)
        if coupling_mm:
            along = couple_along_axis(along, fine_s[1] - fine_s[0], coupling_mm)
        closed = np.concatenate([along, along[:, :1]], axis=1)
        around = CubicSpline(np.append(theta_rad, 2 * np.pi), closed, axis=1, bc_type="periodic")
        fine_theta = np.linspace(0, 2 * np.pi, GRID_ANGLES + 1)
        self.first, self.last = s_mm[0], s_mm[-1]
        self._grid = RegularGridInterpolator((fine_s, fine_theta), around(fine_theta))

    def displacement_at(self, s_mm, theta_rad):
        """Displacement (k, 2) in mm at (s, theta), each (k,); beyond an end of the span, that at the end."""
        s = np.clip(s_mm, self.first, self.last)
        return self._grid(np.stack([s, np.mod(theta_rad, 2 * np.pi)], axis=1))


def grid_positions(s_mm):
    """Even arc lengths (k,), GRID_SPACING_MM apart or little more, from the first to the last of s_mm."""
    return np.linspace(s_mm[0], s_mm[-1], max(int((s_mm[-1] - s_mm[0]) / GRID_SPACING_MM), 1) + 1)


def couple_along_axis(values, step_mm, length_mm):
    """Solution u of u + l^4/4 d^4u/ds^4 = values with free ends, where s runs along the first axis of `values`.

    step_mm: spacing of the values; length_mm: the length l.
    """
    count = len(values)
    second = np.diff(np.eye(count), 2, axis=0) / step_mm**2
    system = np.eye(count) + 0.25 * length_mm**4 * second.T @ second
    return np.linalg.solve(system, values.reshape(count, -1)).reshape(values.shape)


class LumenDeformation:
    """Displacement of the lumen: by slices with the stent inside the stented spans, and without it elsewhere.

    unstented: SpanField of the slices without the stent. stented: list of SpanField, one for each stented span. At the
    end of a span the two fields differ. This jump has two parts:

    - that of the stent's opening. Outside the span it decays with the distance x from the end, like the deflection of a
      clamped cylindrical shell (Timoshenko): exp(-x/l) (cos x/l + sin x/l), where l is edge_decay_mm;
    - that of the stent's offset from the section, which presses the wall aside. It follows offset(s_mm), a function
      that gives the offset (k, 2) in mm at arc lengths (k,), along the section's normal and binormal.

    opened: list of SpanField, one for each stented span, that hold at its ends: the first part alone. None: there is no
    second part.
    """

    def __init__(self, unstented, stented, edge_decay_mm, opened=None, offset=None):
        self._unstented, self._stented, self._decay = unstented, stented, edge_decay_mm
        self._opened, self._offset = opened or stented, offset

    def in_plane(self, s_mm, theta_rad):
        """Displacement (k, 2) in mm of the lumen at (s, theta), each (k,), along the section's normal and binormal."""
        inside_unstented = (s_mm >= self._unstented.first) & (s_mm <= self._unstented.last)
        total = np.where(inside_unstented[:, None], self._unstented.displacement_at(s_mm, theta_rad), 0.0)
        for span in self._stented:
            covered = (s_mm >= span.first) & (s_mm <= span.last)
            total = np.where(covered[:, None], span.displacement_at(s_mm, theta_rad), total)
        for span, opened in zip(self._stented, self._opened):
            for end, outward in ((span.first, -1), (span.last, 1)):
                x = outward * (s_mm - end) / self._decay
                beyond = (x > 0) & ~self._is_stented(s_mm)
                at_end, fade = np.full_like(s_mm, end), np.exp(-np.abs(x)) * (np.cos(x) + np.sin(np.abs(x)))
                here = opened.displacement_at(at_end, theta_rad)
                jump = fade[:, None] * (here - self._unstented.displacement_at(at_end, theta_rad))
                if opened is not span:
                    aside = span.displacement_at(at_end, theta_rad) - here
                    jump += self._offset_share(s_mm, end, outward)[:, None] * aside
                total = total + np.where(beyond[:, None], jump, 0.0)
        return total

    def _offset_share(self, s_mm, end, outward):
        """Offset (k,) beyond a span's end, as a share of that at the end; 0 from where the next span is nearer."""
        at_end = self._offset(np.array([end]))[0]
        share = self._offset(s_mm) @ at_end / max(at_end @ at_end, 1e-12)
        ends = [b for a in self._stented for b in (a.first, a.last) if outward * (b - end) > 0]
        middle = 0.5 * (end + min(ends, key=lambda b: abs(b - end))) if ends else outward * np.inf
        return np.where(outward * (s_mm - middle) < 0, share, 0.0)

    def _is_stented(self, s_mm):
        return np.any([(s_mm >= span.first) & (s_mm <= span.last) for span in self._stented], axis=0)


def smooth_fall(x):
    """1 for x <= 0, 0 for x >= 1, twice continuously differentiable."""
    x = np.clip(x, 0, 1)
    return 1 - x**3 * (10 - 15 * x + 6 * x * x)


class AxisMotion:
    """Motion of a branch's sections by straightening: shift_mm (k, 3), and how they turn, at arc lengths s_mm (k,).

    turn (k, 3): change of the unit vector across the section. None: sections stay perpendicular to the axis.
    """

    def __init__(self, s_mm, shift_mm, turn=None):
        self.shift = CubicSpline(s_mm, shift_mm)
        self.turn = self.shift.derivative() if turn is None else CubicSpline(s_mm, turn)


def move_points(points_mm, branch, lumen, motion, fixed_ends):
    """Points (n, 3) in mm after the procedure.

    Points on the branch's lumen follow its LumenDeformation `lumen`. Points outside it, such as side branches, follow
    as incompressible tissue does: rho' = sqrt(rho^2 + r'^2 - r^2). Here rho is the distance from the axis, r the
    lumen's radius, and a prime means after the procedure. Their displacement falls to 0 over FADE_DISTANCE_MM from the
    lumen. motion: AxisMotion of the sections by straightening, which is added. fixed_ends: (centre (3,), radius mm) of
    the vessel's ends. Their caps stay, and within CAP_FADE_MM of them the displacement falls to 0.
    """
    axis = branch.axis
    s = axis.nearest(points_mm)
    moved_by = _displacement_from(points_mm, np.clip(s, 0, axis.length_mm), branch, lumen, motion)
    far, mean = _mean_displacement(points_mm, branch, lumen, motion)
    moved_by[far] = mean
    kept = ((s > 0) & (s < axis.length_mm)).astype(float)
    for centre, radius in fixed_ends:
        kept = kept * (1 - smooth_fall((np.linalg.norm(points_mm - centre, axis=1) - 1.05 * radius) / CAP_FADE_MM))
    return points_mm + kept[:, None] * moved_by


def _displacement_from(points_mm, s_mm, branch, lumen, motion):
    """Displacement (n, 3) in mm of points (n, 3), as if each moved with the branch's section at its s_mm (n,).

    motion: AxisMotion.
    """
    axis = branch.axis
    offset = points_mm - axis.point(s_mm)
    tangent, normal, binormal = axis.frame(s_mm)
    a, b = np.sum(offset * normal, axis=1), np.sum(offset * binormal, axis=1)
    theta, rho = np.arctan2(b, a), np.linalg.norm(offset, axis=1)
    r = branch.radius(s_mm)
    u = lumen.in_plane(s_mm, theta)
    outwards = np.cos(theta) * u[:, 0] + np.sin(theta) * u[:, 1]
    opened = r + outwards
    gap = np.maximum(rho - r, 0)
    tissue = np.sqrt(np.maximum((r + gap) ** 2 + opened**2 - r**2, 1e-12)) - (r + gap)
    share = np.where(np.abs(outwards) > 1e-9, tissue / np.where(np.abs(outwards) > 1e-9, outwards, 1), 1.0)
    local = (share * u[:, 0])[:, None] * normal + (share * u[:, 1])[:, None] * binormal
    # Inside the lumen lie points of a cap's disc. Their displacement scales with the distance from the axis.
    local *= np.clip(rho / np.maximum(r, 1e-9), 0, 1)[:, None]
    arm = offset + local
    arm *= np.minimum(1, opened / np.maximum(np.linalg.norm(arm, axis=1), 1e-9))[:, None]
    turned = _turned(arm, tangent, motion.turn(s_mm)) - arm
    return smooth_fall(gap / FADE_DISTANCE_MM)[:, None] * (local + motion.shift(s_mm) + turned)


def _turned(vectors, tangent, turn):
    """Vectors (n, 3) fixed to sections whose unit vectors across, the axis's tangents (n, 3), change by turn (n, 3).

    If sections only shifted sideways, a moved axis would cut them obliquely. Their lumen would be too narrow, and would
    fold in a sharp bend.
    """
    new = tangent + turn
    new /= np.linalg.norm(new, axis=1, keepdims=True)
    turn, cosine = np.cross(tangent, new), np.sum(tangent * new, axis=1, keepdims=True)
    across = np.cross(turn, vectors)
    return vectors + across + np.cross(turn, across) / (1 + cosine)


def _mean_displacement(points_mm, branch, lumen, motion):
    """(far (n,) bool, displacement (m, 3) in mm of the far points), means over sections of the branch.

    Far points lie between MEAN_FROM_MM and FADE_DISTANCE_MM from the lumen. Inside a bend the nearest place on the axis
    jumps from one limb to the other, and the displacement jumps with it. A side branch there would be torn or folded. A
    point feels a length of the vessel of about its own distance. So its displacement is a mean over sections with the
    weights exp(-(d^2 - d0^2) / (2 w^2)). d is the distance from the axis at the section, d0 the least d. w is
    MEAN_WIDTH times the distance from the lumen.
    """
    axis = branch.axis
    s = np.linspace(0, axis.length_mm, int(axis.length_mm / MEAN_STEP_MM) + 2)
    place, r = axis.point(s), branch.radius(s)
    far, means = np.zeros(len(points_mm), bool), [np.zeros((0, 3))]
    for start in range(0, len(points_mm), POINTS_AT_ONCE):
        part = points_mm[start : start + POINTS_AT_ONCE]
        distance = cdist(part, place)
        gap = (distance - r).min(axis=1)
        chosen = (gap > MEAN_FROM_MM) & (gap < FADE_DISTANCE_MM)
        far[start : start + POINTS_AT_ONCE] = chosen
        distance = distance[chosen]
        width = MEAN_WIDTH * gap[chosen][:, None]
        exponent = (distance**2 - distance.min(axis=1, keepdims=True) ** 2) / (2 * width**2)
        row, column = np.nonzero(exponent < LARGEST_EXPONENT)
        weight = np.exp(-exponent[row, column])
        single = _displacement_from(part[chosen][row], s[column], branch, lumen, motion)
        total = np.bincount(row, weight)
        means.append(np.stack([np.bincount(row, weight * single[:, k]) / total for k in range(3)], axis=1))
    return far, np.concatenate(means)

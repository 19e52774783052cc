"""The stent and the vessel as two beams that press on each other where the stent lies."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.optimize import brentq
from scipy.sparse import block_diag, diags, kron, vstack
from scipy.sparse import eye as identity
from scipy.sparse.linalg import spsolve

from common.errors import ComputationError

from . import beams

OFFSET_TOLERANCE_MM = 1e-6  # the offsets are found if the next iteration changes none by more
MOST_ITERATIONS = 100


@dataclass(frozen=True)
class SidewaysLaw:
    """How a section that holds a stent yields if the stent presses it sideways.

    Offsets (k,) in mm are distances of the stent from where it presses equally on all sides; the section's outside
    stays. They start at 0. force_n_per_mm (k,): force of the stent on the section, per length. lumen_mm (k,): how far
    the lumen's centre follows the stent. Both are monotone cubics between the offsets, and lines beyond the last.

    If the offset d varies along the vessel, the wall bends along it. This turns the section by following * d', as part
    of the vessel's beam. The rest of the wall's bending has the energy wall_bending_n_mm2 / 2 |d''|^2 per length.
    """

    offset_mm: np.ndarray
    force_n_per_mm: np.ndarray
    lumen_mm: np.ndarray
    following: float
    wall_bending_n_mm2: float

    @cached_property
    def _curves(self):
        """(force and lumen's shift over the offset, their derivatives), as functions."""
        curve = PchipInterpolator(self.offset_mm, np.stack([self.force_n_per_mm, self.lumen_mm], axis=1))
        return curve, curve.derivative()

    def at(self, offset_mm):
        """(force in N/mm, its derivative in N/mm2, lumen's shift in mm) at an offset >= 0."""
        within = min(offset_mm, self.offset_mm[-1])
        (force, lumen), slopes = (curve(within) for curve in self._curves)
        force, lumen = (value + slope * (offset_mm - within) for value, slope in zip((force, lumen), slopes))
        return force, slopes[0], lumen


@dataclass(frozen=True)
class VesselSections:
    """What the slices say of the vessel: bending (N mm2) and shear stiffness (N) at s_mm, each (k,), ascending.

    laws: [(s_mm, SidewaysLaw)], ascending, for the slices that hold a stent. Beyond a stent's end the wall resists as
    at the end.
    """

    s_mm: np.ndarray
    bending_n_mm2: np.ndarray
    shear_n: np.ndarray
    laws: list

    def wall_along(self, s_mm):
        """(following, wall_bending_n_mm2) of the laws, each (n,), at arc lengths (n,)."""
        at = [s for s, _ in self.laws]
        values = [(law.following, law.wall_bending_n_mm2) for _, law in self.laws]
        return (np.interp(s_mm, at, one) for one in zip(*values))

    def law_values(self, s_mm, offset_mm):
        """`SidewaysLaw.at`, each (n,), at arc lengths and offsets (n,). Between the laws it is linear along s."""
        at = np.array([s for s, _ in self.laws])
        k = np.clip(np.searchsorted(at, s_mm), 1, len(at) - 1)
        share = np.clip((s_mm - at[k - 1]) / (at[k] - at[k - 1]), 0, 1)
        before, after = (
            np.array([self.laws[j][1].at(offset) for j, offset in zip(index, offset_mm)]) for index in (k - 1, k)
        )
        return ((1 - share)[:, None] * before + share[:, None] * after).T


@dataclass(frozen=True)
class Straightening:
    """Displacements in mm: vessel_mm (n, 3) of the vessel at s_mm (n,), stent_mm (m, 3) at the nodes `stented` (m,).

    turn (n, 3): change of the unit vector across the vessel's section. As the vessel shears, it is not the slope of
    vessel_mm.
    offset_mm, force_n_per_mm, lumen_mm (n, 3): offset of the stent from the vessel's section, its force on the section,
    and the shift of the lumen's centre from the section, each across the axis. Beyond a stent the offset is that of the
    wall, which bends with its neighbour.
    """

    s_mm: np.ndarray
    vessel_mm: np.ndarray
    turn: np.ndarray
    stented: np.ndarray
    stent_mm: np.ndarray
    offset_mm: np.ndarray
    force_n_per_mm: np.ndarray
    lumen_mm: np.ndarray

    def lumen_shift(self):
        """Displacement (n, 3) in mm of the lumen's centre at s_mm."""
        return self.vessel_mm + self.lumen_mm

    def in_section(self, axis, s_mm):
        """(offset (k, 2) mm, force (k, 2) N/mm) at arc lengths (k,), along normal and binormal of the axis (Curve)."""
        _, *across = axis.frame(s_mm)
        return tuple(
            np.stack([np.sum(CubicSpline(self.s_mm, vectors)(s_mm) * one, axis=1) for one in across], axis=1)
            for vectors in (self.offset_mm, self.force_n_per_mm)
        )

    def pressed_at(self, axis, s_mm):
        """(offset (2,) mm, force (2,) N/mm), as `in_section`, at one arc length."""
        return tuple(values[0] for values in self.in_section(axis, np.array([s_mm])))


def straighten(axis, stents, sections, foundation_n_per_mm2, step_mm=beams.LARGEST_ELEMENT_MM):
    """Straightening of the vessel along `axis` (Curve) by its stents.

    The stents and the vessel are beams with the shifts w and v. The sum of their energies is least:

    - E_s/2 |c'' + w''|^2 of the stents, which are straight if free and lie along the axis c before;
    - the bending and shear energy of the vessel, and k/2 |v|^2 of the tissue around it;
    - the work of the force f(|d|) that the section opposes to the offset d = w - v across the axis;
    - C/2 |d''|^2 of the wall that bends along the vessel. It turns the vessel's sections by a d' besides, so the
      vessel's beam has the shift v + a d. C and a are wall_bending and following of the laws.

    Beyond the stents w is the shift of the lumen's wall, which the same laws hold to the vessel. Along the axis the
    stent slides in the lumen, and only k holds it. The vessel's ends are clamped. Displacements are small. f is taken
    as the same in all directions.

    sections: VesselSections. Returns a Straightening. Raises ComputationError.
    """
    s = beams.nodes(axis.length_mm, stents, step_mm)
    if not stents:
        none = np.zeros((len(s), 3))
        return Straightening(s, none, none, np.zeros(0, int), none[:0], none, none, none)
    beam = _CoupledBeams(axis, stents, s, sections, foundation_n_per_mm2)
    x = np.zeros(beam.size)
    for _ in range(MOST_ITERATIONS):
        change = beam.newton_step(x)
        step = beam.least_energy_step(x, change)
        largest = np.abs(beam.offsets(change)).max()
        x = x + step * change
        if largest < OFFSET_TOLERANCE_MM:
            return beam.straightening(x)
    raise ComputationError(
        "the stent found no place in the vessel",
        "straightening",
        f"{largest:.2e} mm in the last iteration",
        "a softer stent",
    )


class _CoupledBeams:
    """The energy of `straighten` and its derivatives over unknowns x (size,), each of which has three components.

    They are w by nodes and its slope where stents are, v and the rotation of the vessel's beam by nodes, and the slope
    of d by nodes. The vessel's ends are left out.
    """

    def __init__(self, axis, stents, s_mm, sections, foundation):
        self.s, self.sections, n = s_mm, sections, len(s_mm)
        self.stented = np.flatnonzero(np.any([one.covers(s_mm) for one in stents], axis=0))
        self.length = 0.5 * (np.append(np.diff(s_mm), 0) + np.append(0, np.diff(s_mm)))
        # Rows of a unit matrix choose unknowns.
        unit = identity(5 * n, format="csr")
        self.w, self.v, self.rotation = slice(0, 2 * n, 2), slice(2 * n, 4 * n, 2), slice(2 * n + 1, 4 * n, 2)
        slope_of_d = slice(4 * n, 5 * n)
        following, wall_bending = sections.wall_along(s_mm)
        offset, middle = unit[self.w] - unit[self.v], 0.5 * (s_mm[1:] + s_mm[:-1])
        beam = _alternating(unit[self.v] + diags(following) @ offset, unit[self.rotation])
        bending, shear = (np.interp(middle, sections.s_mm, v) for v in (sections.bending_n_mm2, sections.shear_n))
        stent_bending = beams.stent_bending(stents, s_mm)
        wall = _alternating(offset, unit[slope_of_d])
        linear = beam.T @ beams.vessel_matrix(s_mm, bending, shear) @ beam
        linear += wall.T @ beams.stent_matrix(s_mm, 0.5 * (wall_bending[1:] + wall_bending[:-1])) @ wall
        linear += unit[: 2 * n].T @ beams.stent_matrix(s_mm, stent_bending) @ unit[: 2 * n]
        linear += unit[self.v].T @ diags(foundation * self.length) @ unit[self.v]
        clamped = [2 * n, 2 * n + 1, 4 * n - 2, 4 * n - 1]
        no_stent = np.setdiff1d(np.arange(n), self.stented)
        free = np.setdiff1d(np.arange(5 * n), np.append(clamped, 2 * no_stent + 1))
        self._kept = kron(unit[:, free], identity(3), format="csr")
        tangent = axis.frame(s_mm)[0]
        along = np.einsum("si,sj->sij", tangent, tangent)
        # Offsets across the axis from x, and the shifts of w along it.
        self.offset_matrix = _diagonal(np.eye(3) - along) @ kron(offset, identity(3)) @ self._kept
        sliding = _diagonal(along) @ kron(unit[self.w], identity(3)) @ self._kept
        held = np.repeat(self.length * foundation, 3)
        self.linear = self._kept.T @ kron(linear, identity(3)) @ self._kept + sliding.T @ diags(held) @ sliding
        load = unit[: 2 * n].T @ beams.straightening_load(axis, s_mm, stent_bending)
        self.load, self.size = self._kept.T @ load.ravel(), self.linear.shape[0]

    def offsets(self, x):
        """Offsets (n, 3) in mm of the stent from the vessel's sections, across the axis."""
        return (self.offset_matrix @ x).reshape(-1, 3)

    def _laws(self, x):
        """(offsets (n, 3), their size (n,), values of the laws there: 3 of (n,))."""
        vector = self.offsets(x)
        size = np.linalg.norm(vector, axis=1)
        return vector, size, self.sections.law_values(self.s, size)

    def _gradient(self, x):
        """Gradient (size,) of the energy in N, and (unit vectors (n, 3), secants, slopes (n,)) of the laws."""
        vector, size, (force, slope, _) = self._laws(x)
        unit = vector / np.maximum(size, 1e-12)[:, None]
        secant = np.where(size > 1e-9, force / np.maximum(size, 1e-9), slope)
        gradient = self.linear @ x - self.load
        gradient += self.offset_matrix.T @ ((self.length * force)[:, None] * unit).ravel()
        return gradient, (unit, secant, slope)

    def newton_step(self, x):
        """Change of x by which the gradient of the energy vanishes to first order."""
        gradient, (unit, secant, slope) = self._gradient(x)
        along = np.einsum("si,sj->sij", unit, unit)
        tangent = secant[:, None, None] * (np.eye(3) - along) + slope[:, None, None] * along
        contact = _diagonal(self.length[:, None, None] * tangent)
        matrix = self.linear + self.offset_matrix.T @ contact @ self.offset_matrix
        return -spsolve(matrix.tocsc(), gradient)

    def least_energy_step(self, x, change):
        """Share of `change`, at most 1, by which the energy, which is convex, becomes least."""

        def slope(share):
            return change @ self._gradient(x + share * change)[0]

        return 1.0 if slope(1.0) <= 0 else brentq(slope, 0.0, 1.0, xtol=1e-9, rtol=1e-3)

    def straightening(self, x):
        """The Straightening of the unknowns x."""
        offset, size, (force, _, lumen) = self._laws(x)
        unit = offset / np.maximum(size, 1e-12)[:, None]
        solved = (self._kept @ x).reshape(-1, 3)
        stent, force, lumen = solved[self.w][self.stented], force[:, None] * unit, lumen[:, None] * unit
        return Straightening(self.s, solved[self.v], solved[self.rotation], self.stented, stent, offset, force, lumen)


def _alternating(even, odd):
    """Sparse matrix whose rows are those of `even` and `odd` in turn."""
    n = even.shape[0]
    order = np.ravel(np.column_stack([np.arange(n), n + np.arange(n)]))
    return vstack([even, odd], format="csr")[order]


def _diagonal(blocks):
    """Sparse matrix with the blocks (n, 3, 3) along its diagonal."""
    return block_diag(list(blocks), format="csr")

"""The stent and the vessel as two beams that press on each other where the stent lies."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, bmat, coo_matrix, diags, kron
from scipy.sparse import eye as identity
from scipy.sparse.linalg import spsolve

from common.errors import ComputationError

from . import beams

OFFSET_TOLERANCE_MM = 1e-6  # the offsets are found if the next iteration changes none by more
MOST_ITERATIONS, MOST_HALVINGS = 100, 30  # of Newton's method, and of one of its steps


@dataclass(frozen=True)
class SidewaysLaw:
    """How a section that holds a stent yields if the stent presses it sideways.

    Offsets (k,) in mm are distances of the stent from where it presses equally on all sides; the section's outside
    stays. They start at 0. force_n_per_mm (k,): force of the stent on the section, per length. lumen_mm (k,): how far
    the lumen's centre follows the stent. Between the offsets both are linear, and so they are beyond the last.
    """

    offset_mm: np.ndarray
    force_n_per_mm: np.ndarray
    lumen_mm: np.ndarray

    def at(self, offset_mm):
        """(force in N/mm, its derivative in N/mm2, energy in N, lumen's shift in mm) at an offset >= 0."""
        offset, force, lumen = self.offset_mm, self.force_n_per_mm, self.lumen_mm
        k = np.clip(np.searchsorted(offset, offset_mm), 1, len(offset) - 1)
        over, width = offset_mm - offset[k - 1], offset[k] - offset[k - 1]
        slope = (force[k] - force[k - 1]) / width
        stored = np.sum(0.5 * (force[1:k] + force[: k - 1]) * np.diff(offset[:k]))
        return (
            force[k - 1] + slope * over,
            slope,
            stored + force[k - 1] * over + 0.5 * slope * over**2,
            lumen[k - 1] + (lumen[k] - lumen[k - 1]) / width * over,
        )


@dataclass(frozen=True)
class VesselSections:
    """What the slices say of the vessel: bending (N mm2) and shear stiffness (N) at s_mm, each (k,), ascending.

    laws: [(s_mm, SidewaysLaw)], ascending, for the slices that hold a stent.
    """

    s_mm: np.ndarray
    bending_n_mm2: np.ndarray
    shear_n: np.ndarray
    laws: list

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

    offset_mm, force_n_per_mm, lumen_mm (m, 3): offset of the stent from the vessel's section, its force on the section,
    and the shift of the lumen's centre from the section, each across the axis.
    """

    s_mm: np.ndarray
    vessel_mm: np.ndarray
    stented: np.ndarray
    stent_mm: np.ndarray
    offset_mm: np.ndarray
    force_n_per_mm: np.ndarray
    lumen_mm: np.ndarray

    def lumen_shift(self):
        """Displacement (n, 3) in mm of the lumen's centre at s_mm."""
        shift = self.vessel_mm.copy()
        shift[self.stented] += self.lumen_mm
        return shift

    def in_section(self, axis, s_mm):
        """(offset (2,) mm, force (2,) N/mm) at arc length s_mm, along the normal and binormal of the axis (Curve)."""
        at = self.s_mm[self.stented]
        here = [[np.interp(s_mm, at, v[:, k]) for k in range(3)] for v in (self.offset_mm, self.force_n_per_mm)]
        _, normal, binormal = (v[0] for v in axis.frame(np.array([s_mm])))
        return np.array(here) @ np.stack([normal, binormal], axis=1)


def straighten(axis, stents, sections, foundation_n_per_mm2, step_mm=beams.LARGEST_ELEMENT_MM):
    """Straightening of the vessel along `axis` (Curve) by its stents.

    The stents and the vessel are beams with the shifts w_s and w_v. The sum of their energies is least:
    E_s/2 |c'' + w_s''|^2 of the stents, which are straight if free and lie along the axis c before; the vessel's
    bending and shear energy, and k/2 |w_v|^2 of the tissue around it; and the work of the force f(|d|) that the section
    opposes to the offset d = w_s - w_v across the axis. Along the axis the stent slides in the lumen, and only k holds
    it. The vessel's ends are clamped. Displacements are small. f is taken as the same in all directions.

    sections: VesselSections. Returns a Straightening. Raises ComputationError.
    """
    s = beams.nodes(axis.length_mm, stents, step_mm)
    bending, shear = (
        np.interp(0.5 * (s[1:] + s[:-1]), sections.s_mm, values)
        for values in (sections.bending_n_mm2, sections.shear_n)
    )
    if not stents:
        none = np.zeros((0, 3))
        return Straightening(s, np.zeros((len(s), 3)), np.zeros(0, int), none, none, none, none)
    beam = _CoupledBeams(axis, stents, s, vessel=(bending, shear, foundation_n_per_mm2), sections=sections)
    x = np.zeros(beam.size)
    for _ in range(MOST_ITERATIONS):
        change = beam.newton_step(x)
        energy, step = beam.energy(x), 1.0
        while beam.energy(x + step * change) > energy and step > 0.5**MOST_HALVINGS:
            step *= 0.5
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
    """The energy of `straighten` and its derivatives, over the unknowns x (size,) of the vessel, then of the stents.

    Each unknown of `beams.vessel_matrix` and `beams.stent_matrix` has three components. The vessel's ends are left out.
    """

    def __init__(self, axis, stents, s_mm, vessel, sections):
        bending, shear, foundation = vessel
        self.s, self.sections = s_mm, sections
        self.stented = np.flatnonzero(np.any([one.covers(s_mm) for one in stents], axis=0))
        matrix = beams.vessel_matrix(s_mm, bending, shear, foundation)[2:-2, 2:-2]
        stent, load = _stent_beams(axis, stents, s_mm, self.stented)
        self.first_stent, self.size = matrix.shape[0], 3 * (matrix.shape[0] + stent.shape[0])
        tangent = axis.frame(s_mm[self.stented])[0]
        along = np.einsum("si,sj->sij", tangent, tangent)
        self.length = _lumped_lengths(s_mm, stents)[self.stented]
        # Offsets of the stented nodes from x, across the axis; and the stent's shifts along it.
        self.offset_matrix = self._difference(np.eye(3) - along, True)
        sliding = self._difference(along, False)
        held = np.repeat(self.length * foundation, 3)
        self.linear = kron(bmat([[matrix, None], [None, stent]]), identity(3)) + sliding.T @ diags(held) @ sliding
        self.load = np.concatenate([np.zeros(3 * self.first_stent), load.ravel()])

    def _difference(self, part, less_vessel):
        """Sparse matrix (3m, size) that gives `part` (m, 3, 3) of the stent's shifts, less the vessel's if wanted."""
        count = len(self.stented)
        ends = [(self.first_stent + 2 * np.arange(count), part, np.full(count, True))]
        if less_vessel:
            ends.append((2 * (self.stented - 1), -part, (self.stented > 0) & (self.stented < len(self.s) - 1)))
        i, j = np.meshgrid(np.arange(3), np.arange(3), indexing="ij")
        entries = []
        for unknown, block, free in ends:
            rows = 3 * np.arange(count)[:, None, None] + i
            columns = 3 * unknown[:, None, None] + j
            entries.append([v[free].ravel() for v in (block, rows, columns)])
        values, rows, columns = np.concatenate(entries, axis=1)
        return coo_matrix((values, (rows.astype(int), columns.astype(int))), (3 * count, self.size)).tocsr()

    def offsets(self, x):
        """Offsets (m, 3) in mm of the stent from the vessel's sections, across the axis."""
        return (self.offset_matrix @ x).reshape(-1, 3)

    def _laws(self, x):
        """(offsets (m, 3), their size (m,), values of the laws there: 4 of (m,))."""
        vector = self.offsets(x)
        size = np.linalg.norm(vector, axis=1)
        return vector, size, self.sections.law_values(self.s[self.stented], size)

    def energy(self, x):
        """The energy in N mm."""
        stored = self._laws(x)[2][2]
        return 0.5 * x @ (self.linear @ x) - self.load @ x + self.length @ stored

    def newton_step(self, x):
        """Change of x by which the gradient of the energy vanishes to first order."""
        vector, size, (force, slope, _, _) = self._laws(x)
        unit = vector / np.maximum(size, 1e-12)[:, None]
        secant = np.where(size > 1e-9, force / np.maximum(size, 1e-9), slope)
        along = np.einsum("si,sj->sij", unit, unit)
        tangent = secant[:, None, None] * (np.eye(3) - along) + slope[:, None, None] * along
        blocks = block_diag(list(self.length[:, None, None] * tangent), format="csr")
        matrix = self.linear + self.offset_matrix.T @ blocks @ self.offset_matrix
        gradient = self.linear @ x - self.load
        gradient += self.offset_matrix.T @ ((self.length * force)[:, None] * unit).ravel()
        return -spsolve(matrix.tocsc(), gradient)

    def straightening(self, x):
        """The Straightening of the unknowns x."""
        offset, size, (force, _, _, lumen) = self._laws(x)
        unit = offset / np.maximum(size, 1e-12)[:, None]
        solved, shift = x.reshape(-1, 3), np.zeros((len(self.s), 3))
        shift[1:-1] = solved[: self.first_stent : 2]
        stent = solved[self.first_stent :: 2]
        return Straightening(self.s, shift, self.stented, stent, offset, force[:, None] * unit, lumen[:, None] * unit)


def _stent_beams(axis, stents, s_mm, stented):
    """(stiffness, load) of the stents over the nodes `stented`, each stretch of them a beam with free ends."""
    size = 2 * len(stented)
    bending = np.append(beams.stent_bending(stents, s_mm), 0.0)
    rows, load = np.zeros((size, size)), np.zeros((size, 3))
    first = 0
    for part in np.split(np.arange(len(stented)), np.flatnonzero(np.diff(stented) > 1) + 1):
        at, own = s_mm[stented[part]], bending[stented[part][:-1]]
        unknowns = slice(first, first + 2 * len(part))
        rows[unknowns, unknowns] = beams.stent_matrix(at, own).toarray()
        load[unknowns] = beams.straightening_load(axis, at, own)
        first += 2 * len(part)
    return coo_matrix(rows), load


def _lumped_lengths(s_mm, stents):
    """Length (n,) in mm of stented vessel that belongs to each node: half of each stented element beside it."""
    middle = 0.5 * (s_mm[1:] + s_mm[:-1])
    stented = np.diff(s_mm) * np.any([one.covers(middle) for one in stents], axis=0)
    return 0.5 * (np.append(stented, 0) + np.append(0, stented))

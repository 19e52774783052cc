"""The stent and the vessel as two beams that press on each other where the stent lies."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bmat, coo_matrix, kron
from scipy.sparse import eye as identity
from scipy.sparse.linalg import spsolve

from common.errors import ComputationError

from . import beams

OFFSET_TOLERANCE_MM = 1e-6  # the offsets are found if the next iteration changes none by more
LEAST_OFFSET_MM = 1e-4  # below this a section's resistance is taken as linear
MOST_ITERATIONS = 300


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

    def __call__(self, offset_mm):
        """(force in N/mm, lumen's shift in mm) at an offset >= 0."""
        k = np.clip(np.searchsorted(self.offset_mm, offset_mm), 1, len(self.offset_mm) - 1)
        share = (offset_mm - self.offset_mm[k - 1]) / (self.offset_mm[k] - self.offset_mm[k - 1])
        return [v[k - 1] + share * (v[k] - v[k - 1]) for v in (self.force_n_per_mm, self.lumen_mm)]


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
        """(forces in N/mm, lumen's shifts in mm), each (n,), at arc lengths and offsets (n,); linear along s."""
        at = np.array([s for s, _ in self.laws])
        k = np.clip(np.searchsorted(at, s_mm), 1, len(at) - 1)
        share = np.clip((s_mm - at[k - 1]) / (at[k] - at[k - 1]), 0, 1)
        before, after = (
            np.array([self.laws[j][1](offset) for j, offset in zip(index, offset_mm)]) for index in (k - 1, k)
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
    stented = np.flatnonzero(np.any([one.covers(s) for one in stents], axis=0))
    vessel = beams.vessel_matrix(s, bending, shear, foundation_n_per_mm2)[2:-2, 2:-2]
    stent, load = _stent_beams(axis, stents, s, stented)
    free = kron(bmat([[vessel, None], [None, stent]]), identity(3)).tocsc()
    first_stent = vessel.shape[0]
    right_side = np.zeros((free.shape[0] // 3, 3))
    right_side[first_stent:] = load
    tangent = axis.frame(s[stented])[0]
    along = np.einsum("si,sj->sij", tangent, tangent)
    across = np.eye(3) - along
    length = _lumped_lengths(s, stents)[stented]
    vessel_unknown = np.where((stented > 0) & (stented < len(s) - 1), 2 * (stented - 1), -1)
    stent_unknown = first_stent + 2 * np.arange(len(stented))
    held = length[:, None, None] * foundation_n_per_mm2 * along
    offset = np.zeros(len(stented))
    for _ in range(MOST_ITERATIONS):
        # The secant f/d of the law is what couples the beams, with d of the iteration before.
        at = np.maximum(offset, LEAST_OFFSET_MM)
        secant = sections.law_values(s[stented], at)[0] / at
        coupling = (length * secant)[:, None, None] * across
        matrix = free + _coupling_matrix(coupling, held, vessel_unknown, stent_unknown, free.shape[0])
        solved = spsolve(matrix, right_side.ravel()).reshape(-1, 3)
        shift, stent_shift = np.zeros((len(s), 3)), solved[stent_unknown]
        shift[1:-1] = solved[:first_stent:2]
        vector = np.einsum("sij,sj->si", across, stent_shift - shift[stented])
        before, offset = offset, np.linalg.norm(vector, axis=1)
        change = np.abs(offset - before).max()
        if change < OFFSET_TOLERANCE_MM:
            force, lumen = sections.law_values(s[stented], offset)
            unit = vector / np.maximum(offset, 1e-12)[:, None]
            return Straightening(s, shift, stented, stent_shift, vector, force[:, None] * unit, lumen[:, None] * unit)
    raise ComputationError(
        "the stent found no place in the vessel",
        "straightening",
        f"{change:.2e} mm in the last iteration",
        "a softer stent",
    )


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


def _coupling_matrix(coupling, held, vessel_unknown, stent_unknown, size):
    """Sparse matrix (size, size): `coupling` (m, 3, 3) between vessel and stent, `held` (m, 3, 3) of the stent alone.

    vessel_unknown, stent_unknown (m,): numbers of the deflections that they couple; -1 for a node that is clamped.
    """
    rows, columns, values = [], [], []
    inner = vessel_unknown >= 0
    blocks = [(stent_unknown, stent_unknown, coupling + held)]
    blocks += [
        (a[inner], b[inner], sign * coupling[inner])
        for a, b, sign in (
            (vessel_unknown, vessel_unknown, 1),
            (vessel_unknown, stent_unknown, -1),
            (stent_unknown, vessel_unknown, -1),
        )
    ]
    for row, column, block in blocks:
        i, j = np.meshgrid(np.arange(3), np.arange(3), indexing="ij")
        rows.append((3 * row[:, None, None] + i).ravel())
        columns.append((3 * column[:, None, None] + j).ravel())
        values.append(block.ravel())
    return coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (size, size)).tocsc()

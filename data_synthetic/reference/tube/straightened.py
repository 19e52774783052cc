"""A treated tube whose stent is a beam that is straight when free: how far does it straighten the vessel?"""

import sys

import numpy as np

from common.errors import ComputationError

from ..surface import straightening
from .procedure import TreatedTube

SHIFT_TOLERANCE_MM = 2e-3  # the stent's axis is found if no station would move farther than this
MOST_SHIFTS = 25
THIN_TUBE_SHEAR = 0.5  # share of a thin tube's section that bears shear (Cowper 1966)


class StraightenedTube(TreatedTube):
    """A TreatedTube whose stent bends like a beam, held by the tube's pressure on it alone.

    The energy of the tube, of its contact with the stent, and of the stent's bending E_s/2 |c'' + w''|^2 is least over
    the tube's displacement and the stent's shift w; c is the axis before the stent. The tube is supported as the beam
    of surface.straightening is: radially, with both ends clamped. The contact has no friction. Along the axis the
    stent is held by that beam's foundation.
    """

    radial_support = True

    def straighten(self):
        """Lets the stent straighten the tube. First call `run`.

        Returns shifts in mm: (of the lumen's centres at the stations (stations, 3), of the stent at the m stations
        along it (m, 3)). They differ where the stent leaves the wall on one side.

        A beam predicts how the tube yields to a shift of the stent. The first shift is that by this beam, and the next
        ones correct it by the forces of the tube. Raises ComputationError.
        """
        s = self.tube.station_s_mm
        before = self.lumen_positions().mean(axis=1)
        inside = np.flatnonzero((s > self.stented_span[0] - 1e-6) & (s < self.stented_span[1] + 1e-6))
        stent, load = self._stent_beam(s[inside])
        vessel, foundation = self._vessel_beam(inside)
        along = np.einsum("si,sj->sij", *2 * [self.branch.axis.frame(s[inside])[0]])  # keeps a vector's axial part
        across = np.eye(3) - along
        stiffness = np.einsum("sik,st,tkj->sitj", across, vessel, across)
        stiffness += np.einsum("st,ij->sitj", stent, np.eye(3))
        held = np.gradient(s[inside])[:, None, None] * foundation * along
        stiffness[np.arange(len(inside)), :, np.arange(len(inside))] += held
        stiffness = stiffness.reshape(load.size, load.size)
        shift = np.zeros((len(inside), 3))
        for _ in range(MOST_SHIFTS):
            resistance = np.einsum("sij,sj->si", across, self.model.device_forces()[inside])
            resistance -= np.einsum("sij,sj->si", held, shift)
            change = np.linalg.solve(stiffness, (load - stent @ shift + resistance).ravel()).reshape(-1, 3)
            largest = np.linalg.norm(change, axis=1).max()
            print(f"stent: shift by {largest:.4f} mm, {self.model.iterations} iterations", file=sys.stderr)
            if largest < SHIFT_TOLERANCE_MM:
                moved = self.lumen_positions().mean(axis=1) - before
                return np.einsum("skj,sk->sj", np.stack(self.branch.axis.frame(s), axis=1), moved), shift
            shift += change
            self.model.shift_devices(shift[np.clip(np.arange(len(s)) - inside[0], 0, len(inside) - 1)], "straightening")
        raise ComputationError(
            "the stent did not come to rest", "straightening", f"{largest:.4f} mm in the last shift", "another mesh"
        )

    def _stent_beam(self, s_mm):
        """(stiffness (n, n) in N/mm, load (n, 3) in N) of the stents over the deflections at stations s_mm (n,)."""
        middle = 0.5 * (s_mm[1:] + s_mm[:-1])
        bending = np.max([one.bending_n_mm2 * one.covers(middle) for one in self._stents()], axis=0)
        matrix = straightening.beam_matrix(s_mm, bending, 0.0).toarray()
        return _condensed(
            matrix, straightening.straightening_load(self.branch.axis, s_mm, bending), 2 * np.arange(len(s_mm))
        )

    def _vessel_beam(self, inside):
        """The vessel as a beam: (stiffness (n, n) in N/mm at the stations numbered `inside`, foundation in N/mm2).

        Unlike the beam of surface.straightening it shears, so that it yields to the ends of a stent as the solid does.
        """
        s, middle = self.tube.station_s_mm, np.mean(self.stented_span)
        bending, foundation = straightening.vessel_beam(self.branch, self.wall_mm, middle, self.settings)
        inner = float(self.branch.healthy_radius(np.array(middle)))
        section = np.pi * ((inner + self.wall_mm) ** 2 - inner**2)
        shear = THIN_TUBE_SHEAR * 2 * self.settings["wall_c10_mpa"] * section
        matrix = _timoshenko_matrix(np.diff(s), bending, shear, foundation)
        clamped = slice(2, -2)
        no_load = np.zeros((2 * len(s) - 4, 3))
        return _condensed(matrix[clamped, clamped], no_load, 2 * (inside - 1))[0], foundation

    def _stents(self):
        return [step.stent for step in self.steps if step.stent]


def _condensed(matrix, load, kept):
    """(matrix, load) over the unknowns `kept`; the others follow them without load of their own."""
    others = np.setdiff1d(np.arange(len(matrix)), kept)
    follow = np.linalg.solve(matrix[np.ix_(others, others)], np.hstack([matrix[np.ix_(others, kept)], load[others]]))
    coupling = matrix[np.ix_(kept, others)]
    return (
        matrix[np.ix_(kept, kept)] - coupling @ follow[:, : len(kept)],
        load[kept] - coupling @ follow[:, len(kept) :],
    )


def _timoshenko_matrix(h, bending, shear, foundation):
    """Stiffness (2n, 2n) of a beam that shears, over deflection (mm) and rotation of each of its n nodes in turn.

    h (n - 1,): lengths of its elements in mm. bending in N mm2, shear in N, foundation in N/mm2. The elements are exact
    under loads at the nodes (Przemieniecki 1968); the foundation is lumped to the nodes.
    """
    matrix = np.zeros((2 * len(h) + 2, 2 * len(h) + 2))
    for k, length in enumerate(h):
        phi = 12 * bending / (shear * length**2)
        half, near, far = 6 * length, (4 + phi) * length**2, (2 - phi) * length**2
        rows = [[12, half, -12, half], [half, near, -half, far], [-12, -half, 12, -half], [half, far, -half, near]]
        at = slice(2 * k, 2 * k + 4)
        matrix[at, at] += bending / (length**3 * (1 + phi)) * np.array(rows)
        matrix[2 * k, 2 * k] += 0.5 * foundation * length
        matrix[2 * k + 2, 2 * k + 2] += 0.5 * foundation * length
    return matrix

"""A treated tube whose stent is a beam that is straight when free: how far does it straighten the vessel?"""

import sys

import numpy as np

from common.errors import ComputationError

from ..straightening import beams
from .procedure import TreatedTube

SHIFT_TOLERANCE_MM = 2e-3  # the stent's axis is found if no station would move farther than this
MOST_SHIFTS = 25


class StraightenedTube(TreatedTube):
    """A TreatedTube whose stent bends like a beam, held by the tube's pressure on it alone.

    The energy of the tube, of its contact with the stent, and of the stent's bending E_s/2 |c'' + w''|^2 is least over
    the tube's displacement and the stent's shift w; c is the axis before the stent. The tube is supported as the beam
    of straightening.beams is: radially, with both ends clamped. The contact has no friction. Along the axis the stent
    is held by that beam's foundation.
    """

    radial_support = True
    least_margin_mm = 12.0  # more than two of the lengths over which a shift decays in the beam of a healthy vessel

    def straighten(self):
        """Lets the stent straighten the tube. First call `run`.

        Returns shifts in mm: (of the lumen's centres at the stations (stations, 3), of the stent at the m stations
        along it (m, 3)). They differ where the stent leaves the wall on one side.

        A beam predicts how the tube yields to a shift of the stent. The first shift is that by this beam, and the next
        ones correct it by the forces of the tube. Raises ComputationError.
        """
        s = self.tube.station_s_mm
        before = self.lumen_centres()
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
                moved = self.lumen_centres() - before
                return np.einsum("skj,sk->sj", np.stack(self.branch.axis.frame(s), axis=1), moved), shift
            shift += change
            self.model.shift_devices(shift[np.clip(np.arange(len(s)) - inside[0], 0, len(inside) - 1)], "straightening")
        raise ComputationError(
            "the stent did not come to rest", "straightening", f"{largest:.4f} mm in the last shift", "another mesh"
        )

    def _stent_beam(self, s_mm):
        """(stiffness (n, n) in N/mm, load (n, 3) in N) of the stents over the deflections at stations s_mm (n,)."""
        bending = beams.stent_bending(self._stents(), s_mm)
        matrix = beams.stent_matrix(s_mm, bending).toarray()
        return _condensed(matrix, beams.straightening_load(self.branch.axis, s_mm, bending), 2 * np.arange(len(s_mm)))

    def _vessel_beam(self, inside):
        """The healthy vessel as a beam: (stiffness (n, n) in N/mm at stations `inside`, foundation in N/mm2)."""
        s, place = self.tube.station_s_mm, (self.branch, self.wall_mm, np.mean(self.stented_span), self.settings)
        foundation = beams.foundation_n_per_mm2(*place)
        clamped = slice(2, -2)
        matrix = beams.vessel_matrix(s, *beams.healthy_stiffness(*place), foundation).toarray()[clamped, clamped]
        return _condensed(matrix, np.zeros((len(matrix), 3)), 2 * (inside - 1))[0], foundation

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

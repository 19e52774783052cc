"""Anderson acceleration of steps with an old factorization: the last steps correct its inverse by secants.

Anderson 1965, J ACM 12:547; as a multi-secant method Fang and Saad 2009, Numer Linear Algebra Appl 16:197. The old
tangent P asks for the correction f(x) = -P^-1 F(x). dX and dF are the differences of the last states and of their
corrections. The step is f - (dX + dF) y, where y minimizes |f - dF y|. In the directions dF it uses secants of the true
inverse, in all others the inverse of P.
"""

import numpy as np

MOST = 12  # differences kept
INDEPENDENT = 1e-6  # smaller singular values of the Gram matrix of dF, over the largest, are dropped as noise


class Acceleration:
    """Keeps the last differences of states and corrections, arrays (n,). weights (n,) define the inner product."""

    def __init__(self, weights):
        self.weights = weights
        self.moves, self.changes = [], []
        self.last = None

    def step(self, state, correction):
        """The step (n,) from `state` (n,), where the old tangent asks for `correction` (n,)."""
        if self.last is not None:
            self.moves.append(state - self.last[0])
            self.changes.append(correction - self.last[1])
            del self.moves[:-MOST], self.changes[:-MOST]
        self.last = state.copy(), correction.copy()
        if not self.moves:
            return correction
        matrix = np.array([self.weights * change for change in self.changes])
        gram = matrix @ matrix.T
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        right = scale * (matrix @ (self.weights * correction))
        share = scale * np.linalg.lstsq(gram * np.outer(scale, scale), right, rcond=INDEPENDENT)[0]
        result = correction.copy()
        for y, move, change in zip(share, self.moves, self.changes):
            result -= y * (move + change)
        return result

    def pause(self):
        """Takes no difference between the last state and the next, which may be far apart. Keeps the others."""
        self.last = None

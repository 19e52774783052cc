"""Anderson acceleration of steps with an old factorization: what the last steps showed of the tangent is learnt.

Anderson 1965, J ACM 12:547; as a multi-secant method Fang and Saad 2009, Numer Linear Algebra Appl 16:197. With the
corrections f(x) = -P^-1 F(x) of the old tangent P, and the differences dX, dF of the last states and of their
corrections, the step is f - (dX + dF) y, y minimizing |f - dF y|: secants of the true inverse where they are known, the
old tangent's elsewhere.
"""

import numpy as np

MOST = 12  # differences kept
INDEPENDENT = 1e-6  # singular values of dF below this share of the largest say nothing


class Acceleration:
    """Differences of states and corrections, arrays (n,); weights (n,): of the inner product."""

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
        """The next state does not follow from the last one; the differences stay."""
        self.last = None

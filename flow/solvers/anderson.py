"""Anderson acceleration of Newton steps that use an old factorization of the tangent.

Anderson 1965, J ACM 12:547; as a multi-secant method Fang and Saad 2009, Numer Linear Algebra Appl 16:197. F(x) is the
residual of state x, P an old tangent. P alone would correct the state by f(x) = -P^-1 F(x). The columns of dX and dF
are the differences of the last states and of their corrections f. The step is f - (dX + dF) y, where y minimizes
|f - dF y|. So the part of f along dF is replaced by what the last states show, and the rest of f stays.
"""

import numpy as np

MOST_DIFFERENCES = 12  # number of differences in dX and dF
SINGULAR_VALUE_CUTOFF = (
    1e-6  # singular values of the Gram matrix of dF below this share of the largest are dropped as noise
)


class AndersonAcceleration:
    """Keeps the last differences of states (n,) and of corrections (n,).

    weights (n,): they define the inner product of a and b, the sum of weights^2 a b.
    """

    def __init__(self, weights):
        self.weights = weights
        self.state_differences, self.correction_differences = [], []
        self.last = None

    def step(self, state, correction):
        """The accelerated step (n,) from `state` (n,). correction (n,): the correction f by the old tangent alone."""
        if self.last is not None:
            self.state_differences.append(state - self.last[0])
            self.correction_differences.append(correction - self.last[1])
            del self.state_differences[:-MOST_DIFFERENCES], self.correction_differences[:-MOST_DIFFERENCES]
        self.last = state.copy(), correction.copy()
        if not self.state_differences:
            return correction
        matrix = np.array([self.weights * change for change in self.correction_differences])
        gram = matrix @ matrix.T
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        right_side = scale * (matrix @ (self.weights * correction))
        coefficients = (
            scale * np.linalg.lstsq(gram * np.outer(scale, scale), right_side, rcond=SINGULAR_VALUE_CUTOFF)[0]
        )
        result = correction.copy()
        for y, move, change in zip(coefficients, self.state_differences, self.correction_differences):
            result -= y * (move + change)
        return result

    def skip_difference(self):
        """Skips the difference between the last state and the next, which may be far apart. Keeps the earlier ones."""
        self.last = None

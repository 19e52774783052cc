"""From rest to the full flow in steps of the flow by Newton's method.

The outlet resistances are those at which the reduced models draw FRACTIONS of their flow. On a mesh that resolves the
jet's shear layer (meshing.sweep) the steady flow in a straight tube is found so in some ten factorizations. At Re 1,500
solvers.continuation does not find it. Where one fraction fails, and in trees, continuation takes fewer factorizations.
"""

import numpy as np

from flow.solvers import newton

FRACTIONS = (0.1, 0.2, 0.35, 0.6, 1.0)
HARD, HARD_AT_LAST = 4, 8  # factorizations at one fraction and at the last, after which the ramp is given up
MOST_PICARD = 1  # steps of Picard's method at one fraction
ON_THE_WAY = 5e-2  # residual of one flow fraction over that at its start


def climb(problem, resistances_at):
    """Outcome at the full flow, or of the fraction that is not reached.

    resistances_at(fraction) -> (n,) outlet resistances.
    """
    settings, before = problem.settings, None
    problem.forms.artificial.value = 0.0
    for fraction in FRACTIONS:
        problem.boundaries.lower(fraction, resistances_at)
        print(f"flow fraction {fraction:.3g}", file=problem.log, flush=True)
        if before and before > FRACTIONS[0]:  # the jet keeps its shape; not from a creeping flow
            problem.scale_to(fraction / before)
        absolute, relative, limit = settings.residual_absolute, settings.residual_relative, HARD_AT_LAST
        if fraction < FRACTIONS[-1]:
            free, _, norm = problem.residual()
            free.destroy()
            absolute, relative, limit = ON_THE_WAY * norm, np.inf, HARD
        found = newton.newton(problem, absolute, relative, limit, MOST_PICARD)
        if not found.converged:
            return found
        before = fraction
    return found

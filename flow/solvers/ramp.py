"""From rest to the full flow in steps of the flow: Newton's method with short steps, Picard's where none helps.

The outlet resistances are those at which the reduced models draw FRACTIONS of their flow. On a mesh
that resolves the jet's shear layer (meshing.sweep) the steady flow is found so without any eddy viscosity.
"""

import numpy as np

from flow.solvers import newton

FRACTIONS = (0.1, 0.2, 0.35, 0.6, 1.0)
SHARE = 0.2  # of the factorizations that are allowed: in curved vessels solvers.fading is the shorter way
SHORTEST_STEP = 0.05  # of the flow fraction: a fraction that is not reached is tried again from halfway
MOST_PICARD = 1  # steps at one flow fraction, after which it counts as not reached
ON_THE_WAY = 5e-2  # residual of one flow fraction over that at its start


def budget(settings):
    """Factorizations after which this path is given up: some are left for solvers.fading."""
    return int(np.ceil(SHARE * settings.max_newton_iterations))


def climb(problem, resistances_at):
    """Outcome at the full flow, or of the fraction that fails however short the step to it.

    resistances_at(fraction) -> (n,) outlet resistances.
    """
    settings, ahead = problem.settings, list(FRACTIONS)
    problem.forms.mixing.value = 0.0
    reached, values, inflow = 0.0, problem.state.x.array.copy(), problem.inflow
    while True:
        problem.boundaries.lower(ahead[0], resistances_at)
        if reached > FRACTIONS[0]:  # the jet keeps its shape; from a creeping flow Newton's own step is better
            problem.scale_to(ahead[0] / reached)
        last = ahead[0] == FRACTIONS[-1]
        absolute, relative = (settings.residual_absolute, settings.residual_relative) if last else (np.inf, None)
        print(f"flow fraction {ahead[0]:.3g}", file=problem.log, flush=True)
        found = descend(problem, absolute, relative)
        if found.converged:
            reached, values, inflow = ahead.pop(0), problem.state.x.array.copy(), problem.inflow
            if not ahead:
                return found
            continue
        between = 0.5 * (reached + ahead[0])
        spent = problem.solver.factorizations >= budget(settings)
        if spent or between - reached < SHORTEST_STEP:
            return found
        problem.state.x.array[:], problem.inflow = values, inflow
        ahead.insert(0, between)


def descend(problem, absolute, relative):
    """Outcome of Newton and Picard steps down to `absolute` (N) and `relative` (to the load; None: ON_THE_WAY of the
    residual at the start)."""
    if relative is None:
        free, _, norm = problem.residual()
        free.destroy()
        absolute, relative = ON_THE_WAY * norm, np.inf
    left = budget(problem.settings) - problem.solver.factorizations
    return newton.newton(problem, absolute, relative, left, MOST_PICARD)

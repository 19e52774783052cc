"""From the reduced models' flow to the steady one, where that flow is near enough.

In a single tube it is the axisymmetric flow and Newton's method starts from it. In a tree it is parabolas, rough at the
branch points; two steps of Picard's method make a flow of it. That is near enough where the vessel loses little
pressure, as after an intervention; elsewhere such tries cost more factorizations than they save.
"""

import numpy as np

from flow.solvers import newton

STEPS = 8  # Newton's, after which the way from rest is taken
PICARD_STEPS = 2  # in a tree
MILD = 0.95  # least FFR by the 1D network


def try_from(problem, predicted):
    """Outcome at full flow, or None where none was tried; predicted: reduced.coupled.Predictor."""
    if not (predicted.whole or predicted.ffr(predicted.alone_pressures) >= MILD):
        return None
    problem.boundaries.full()
    problem.forms.artificial.value = 0.0
    points, _ = problem.space.nodes()
    problem.take(*predicted.fields(points), float(np.sum(predicted.flows)))
    print("from the reduced models' flow", file=problem.log, flush=True)
    if not predicted.whole:
        free, inlet, _ = problem.residual()
        for _ in range(min(PICARD_STEPS, max(problem.left, 0))):
            free, inlet, _ = newton.picard(problem, free, inlet)
        free.destroy()
    settings = problem.settings
    found = newton.newton(problem, settings.residual_absolute, settings.residual_relative, STEPS)
    found.iterations = problem.solver.factorizations
    return found

"""Newton's method from the flow of the reduced models, where that flow is near enough to the steady one.

In a single tube Newton's method starts from the axisymmetric flow. In a tree only the branch of the probe `distal` has
one, the others have parabolas. Both are rough at the branch points, so two steps of Picard's method smooth them first.
That is near enough where the vessel loses little pressure, as after an intervention. Elsewhere the attempt costs more
factorizations than it saves.
"""

import numpy as np

from flow.solvers import newton

STEPS = 8  # of Newton's method; without convergence the flow is sought from rest then
PICARD_STEPS = 2  # in a tree
MILD = 0.95  # least FFR by the 1D network at which a tree is tried


def try_from(problem, predicted):
    """Outcome at full flow, or None where the predicted flow is not tried; predicted: reduced.coupled.Predictor."""
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

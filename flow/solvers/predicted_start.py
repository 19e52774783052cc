"""Newton's method from the flow of the reduced models, where that flow is near enough to the steady one.

In a single tube Newton's method starts from the flow of the axisymmetric model. In a tree only the branch of the probe
`distal` has this model; the other branches get parabolic profiles. These flows are rough at the branch points, so two
steps of Picard's method smooth them first. The result is near enough where the vessel loses little pressure, as after
an intervention. In other trees the attempt costs more factorizations than it saves.
"""

import numpy as np

from flow.solvers import newton

STEPS = 8  # most factorizations of Newton's method, before the flow is sought in another way
PICARD_STEPS = 2  # steps of Picard's method in a tree
MILD = 0.95  # least FFR at `distal` by the 1D network at which the reduced models' flow is tried in a tree


def try_from(problem, predicted):
    """Outcome of Newton's method at full flow, or None where the reduced models' flow is not tried.

    problem: nonlinear.FlowProblem; predicted: reduced.coupled.Predictor.
    """
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

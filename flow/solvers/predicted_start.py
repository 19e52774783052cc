"""Newton's method from the flow of the reduced models, where that flow is near enough to the steady one.

In a single tube Newton's method starts from the flow of the axisymmetric model. In a tree only the branch of the probe
`distal` has this model; the other branches get parabolic profiles. These flows are rough at the branch points, so two
steps of Picard's method smooth them first. The result is near enough where the vessel loses little pressure, as after
an intervention. In other trees the attempt costs more factorizations than it saves.
"""

import numpy as np

from flow.solvers import newton

MOST_FACTORIZATIONS = 8  # most factorizations of Newton's method, before the flow is sought in another way
PICARD_STEPS = 2  # steps of Picard's method in a tree
LEAST_FFR = 0.95  # least FFR at `distal` by the 1D network at which the reduced models' flow is tried in a tree


def try_predicted_flow(problem, predictor):
    """Outcome of Newton's method at full flow, or None where the reduced models' flow is not tried.

    problem: nonlinear.FlowProblem; predictor: reduced.coupled.Predictor.
    """
    if not (predictor.covers_lumen or predictor.ffr(predictor.network_pressures) >= LEAST_FFR):
        return None
    print("from the reduced models' flow", file=problem.log, flush=True)
    fields, inflow = predictor.fields(problem.space.nodes()[0]), float(np.sum(predictor.flows))
    picard_steps = 0 if predictor.covers_lumen else PICARD_STEPS
    return newton.newton_from(problem, fields, inflow, MOST_FACTORIZATIONS, picard_steps)

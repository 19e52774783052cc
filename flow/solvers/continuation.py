"""From a creeping flow to the steady jet: an artificial viscosity eps rho h |u| is taken away step by step.

h is the width of the cells (physics.navier_stokes). On a mesh that does not resolve a jet's shear layer, Newton's
method finds no steady flow from rest. With eps = 1 it does, and the flow changes smoothly as eps falls. This sequence
of flows is followed in ln eps. The secant through the last two flows predicts the next one. Newton's method corrects it
at fixed eps. A step that fails is shortened; an easy step lengthens the next one. This is natural-parameter
continuation (Allgower and Georg, Introduction to Numerical Continuation Methods, 2003, chapter 6). A solve with eps = 0
is tried from the first flow with eps at most SMALL_EPS, and once more from eps = LEAST_EPS.

On the coarsest of three meshes continuation ends at COARSE_MESH_EPS, where eps = 0 is tried once. The next mesh starts
from the last flow with eps > 0. If the mesh before has reached eps = 0, eps = 0 is tried at once from this start. If it
has not, the finest mesh keeps the eps of the mesh before. Both flows then belong to one model, and their difference
shows the error of the mesh.

If no flow without artificial viscosity is found, the flow with the least eps is the answer. The error estimate includes
the effect of this eps on FFR (errors.error_field).
"""

import numpy as np

from flow.solvers import newton

# Residual over the pressure load at which a flow with eps > 0 has converged. At 1e-4 the flow of eps = .002 would pass
# for that of eps = 0.
INTERMEDIATE_RESIDUAL = 2e-5
FINAL_RESIDUAL = 1e-6  # residual over the pressure load at which the flow with eps = 0 has converged
FIRST_EPS = (1.0, 0.4, 0.16)  # eps of the first flows; each starts from the one before, the first from rest
FIRST_PICARD_STEPS = 4  # most steps of Picard's method for the first flow
FIRST_STEP = 0.9  # length of the step (see VELOCITY_WEIGHT) after a single flow, where there is no secant yet
MOST_FACTORIZATIONS = 6  # a step that needs more factorizations at one eps counts as failed
# The square of a step's length is the sum of two squares: that of the change of ln eps, and that of VELOCITY_WEIGHT
# times the relative change of the velocities.
VELOCITY_WEIGHT = 3.0
# The next step is LONGER_FACTOR times as long if this one took at most FEW_FACTORIZATIONS factorizations, equally long
# up to MANY_FACTORIZATIONS, SHORTER_FACTOR times above. A failed step is repeated with FAILED_FACTOR times its length.
FEW_FACTORIZATIONS, MANY_FACTORIZATIONS = 2, 3
LONGER_FACTOR, SHORTER_FACTOR, FAILED_FACTOR = 1.6, 0.7, 0.4
LONGEST_STEP, SHORTEST_STEP = 1.6, 0.1  # limits of a step's length
# eps = 0 is tried at the first eps that is not above SMALL_EPS, and at LEAST_EPS, where continuation ends. Continuation
# also ends if a step from an eps of at most SMALL_EPS fails.
SMALL_EPS, LEAST_EPS = TRIED_EPS = 0.01, 0.003
COARSE_MESH_EPS = 0.02  # eps at which continuation ends on a mesh whose flow is the start on a finer mesh
LARGEST_EPS = 0.05  # a flow with a larger eps is no answer
MOST_STARTS = 3  # number of flows of another mesh that are tried as a start, the one with the least eps first


def from_rest(problem, stop_early=False):
    """Outcome at full flow from rest. Raises ComputationError where no flow with eps <= LARGEST_EPS is found.

    problem: nonlinear.FlowProblem. stop_early: continuation ends at eps = COARSE_MESH_EPS, where eps = 0 is tried once.
    """
    problem.boundaries.set_full_flow()
    for eps in FIRST_EPS:
        is_first = not problem.flows_found
        outcome = _newton_at_eps(
            problem,
            eps,
            INTERMEDIATE_RESIDUAL,
            FIRST_PICARD_STEPS if is_first else 0,
            2 * MOST_FACTORIZATIONS if is_first else MOST_FACTORIZATIONS,
        )
        if not outcome.converged:
            raise problem.stall_error(outcome)
        _record_flow(problem)
    lower_viscosity(problem, [COARSE_MESH_EPS] if stop_early else TRIED_EPS)
    return converge_fully(problem)


def from_guess(problem, coarse, lower_further=True):
    """Outcome at full flow from the flow on another mesh, `coarse` (a solved FlowProblem).

    The start is the last flow with eps > 0 found on that mesh, or an earlier one if this fails. From the flow at
    eps = 0 Newton's method often fails, as the jets of two meshes differ. A mesh that was solved without continuation
    has only a flow with eps = 0. Then Newton's method starts from this flow, at eps = 0 and if that fails at
    COARSE_MESH_EPS. lower_further: eps is lowered further even if that mesh did not reach 0. Raises ComputationError.
    """
    problem.boundaries.set_full_flow()
    starts = coarse.flows_found or [(coarse.artificial_viscosity, coarse.state.x.array, coarse.inflow)]
    starts = [one for one in starts if one[0] > 0] or [(COARSE_MESH_EPS, *starts[-1][1:]), starts[-1]]
    for eps, values, inflow in starts[: -MOST_STARTS - 1 : -1]:
        problem.set_guess(coarse.space, values, inflow)
        outcome = _newton_at_eps(problem, eps, INTERMEDIATE_RESIDUAL if eps > 0 else FINAL_RESIDUAL)
        if outcome.converged:
            break
    else:
        raise problem.stall_error(outcome)
    _record_flow(problem)
    if coarse.artificial_viscosity == 0:
        lower_viscosity(problem, (max(eps, SMALL_EPS), LEAST_EPS))
    elif lower_further:
        lower_viscosity(problem)
    return converge_fully(problem)


def lower_viscosity(problem, tried_eps=TRIED_EPS):
    """Lowers eps step by step from the last flows in `problem.flows_found`, to 0 if possible, and adds the flows found.

    tried_eps: values of eps, falling. eps = 0 is tried from the first flow at or below each of them. eps falls no
    further than the last of them.
    """
    step, least = None, tried_eps[-1]
    while problem.factorizations_left > MOST_FACTORIZATIONS and problem.artificial_viscosity > 0:
        eps, values, last_inflow = problem.flows_found[-1]
        if eps <= tried_eps[0]:
            if _newton_at_eps(problem, 0.0, FINAL_RESIDUAL).converged:
                _record_flow(problem)
                return
            _restore_flow(problem)
            tried_eps = [one for one in tried_eps if one < eps]
            if not tried_eps:
                return
        direction, inflow, change, length = _secant(problem)
        step = min(step or length, LONGEST_STEP)
        problem.state.x.array[:] = values + step * direction
        problem.inflow = last_inflow + step * inflow
        outcome = _newton_at_eps(problem, max(eps * np.exp(step * change), least), INTERMEDIATE_RESIDUAL)
        if outcome.converged:
            _record_flow(problem)
            step *= (
                LONGER_FACTOR
                if outcome.iterations <= FEW_FACTORIZATIONS
                else 1.0
                if outcome.iterations <= MANY_FACTORIZATIONS
                else SHORTER_FACTOR
            )
        else:
            _restore_flow(problem)
            step *= FAILED_FACTOR
            if eps <= SMALL_EPS or step < SHORTEST_STEP:
                return


def converge_fully(problem):
    """Outcome of Newton's method to the setting residual_absolute, from the last flow in `problem.flows_found`.

    Where this fails, the flow before is tried, and so on. Raises ComputationError where none converges, or eps is above
    LARGEST_EPS.
    """
    outcome = None
    while problem.flows_found:
        _restore_flow(problem)
        if problem.artificial_viscosity > LARGEST_EPS:
            break
        print(f"artificial viscosity {problem.artificial_viscosity:.3g}, to the end", file=problem.log, flush=True)
        outcome = newton.newton(problem, problem.settings.residual_absolute, 2 * MOST_FACTORIZATIONS)
        problem.flows_found.pop()
        if outcome.converged:
            _record_flow(problem)
            return outcome
    raise problem.stall_error(outcome)


def _newton_at_eps(problem, eps, relative, most_picard=0, limit=MOST_FACTORIZATIONS):
    """Outcome of Newton's method from the present state with artificial viscosity eps.

    relative: tolerance of the residual over the pressure load; most_picard: most steps of Picard's method; limit: most
    factorizations, as in newton.newton.
    """
    problem.forms.artificial_viscosity.value = eps
    print(f"artificial viscosity {eps:.3g}", file=problem.log, flush=True)
    return newton.newton(problem, relative * problem.pressure_load, limit, most_picard)


def _secant(problem):
    """The secant through the last two flows found, by which the next flow is predicted.

    Returns (change of the dofs, of the inflow in m3/s, of ln eps, each for a step of length 1; length between the two
    flows). VELOCITY_WEIGHT tells how lengths are measured. After a single flow there is no secant: only ln eps falls,
    and the length is FIRST_STEP.
    """
    if len(problem.flows_found) < 2:
        return 0.0, 0.0, -1.0, FIRST_STEP
    (eps, values, inflow), (last, last_values, last_inflow) = problem.flows_found[-2:]
    change, change_of_log = last_values - values, np.log(last / eps)
    free = problem.space.free_dofs
    length = VELOCITY_WEIGHT * problem.velocity_norm(change[free]) / problem.velocity_norm(last_values[free])
    length = float(np.hypot(length, change_of_log))
    return change / length, (last_inflow - inflow) / length, change_of_log / length, length


def _record_flow(problem):
    """Adds eps and the present flow to `problem.flows_found`."""
    problem.flows_found.append((problem.artificial_viscosity, problem.state.x.array.copy(), problem.inflow))


def _restore_flow(problem):
    """Sets eps and the flow to the last ones in `problem.flows_found`."""
    problem.forms.artificial_viscosity.value, problem.state.x.array[:], problem.inflow = problem.flows_found[-1]

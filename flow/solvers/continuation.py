"""From a creeping flow to the steady jet: an artificial viscosity eps h |u| is taken away step by step.

h is the width of the cells (physics.navier_stokes). On a mesh that does not resolve a jet's shear layer, Newton's
method finds no steady flow from rest. With eps = 1 it does, and the flow changes smoothly as eps falls. This sequence
of flows is followed in ln eps. The secant through the last two flows predicts the next one. Newton's method corrects it
at fixed eps. A step that fails is shortened; an easy step lengthens the next one. This is natural-parameter
continuation (Allgower and Georg, Introduction to Numerical Continuation Methods, 2003, chapter 6). A solve with eps = 0
is tried from the first flow with eps at most SMALL, and once more from eps = LEAST.

On the coarsest of three meshes continuation ends at BEGUN, where eps = 0 is tried once. The next mesh starts there. If
the mesh before has reached eps = 0, a finer mesh starts from that mesh's last flow with eps > 0 and tries eps = 0 from
there. If it has not, the finest mesh keeps the eps of the mesh before. Both flows then belong to one model, and their
difference shows the error of the mesh.

If no flow without artificial viscosity is found, the flow of the least eps answers. The error estimate includes the
effect of this eps on FFR (errors.error_field).
"""

import numpy as np

from flow.solvers import newton

# Residual over the pressure load at which a flow with eps > 0 has converged. At 1e-4 the flow of eps = .002 would pass
# for that of eps = 0.
ON_THE_WAY = 2e-5
TO_THE_END = 1e-6  # residual over the pressure load at which the flow with eps = 0 has converged
FIRST = (1.0, 0.4, 0.16)  # eps of the first flows; each starts from the one before, the first from rest
FIRST_PICARD = 4  # most steps of Picard's method for the first flow
FIRST_STEP = 0.9  # length of the step (see WEIGHT) after a single flow, where there is no secant yet
HARD = 6  # a step that needs more factorizations at one eps counts as failed
# The length of a step is the root of the sum of two squares: of the change of ln eps, and of WEIGHT times the relative
# change of the velocities.
WEIGHT = 3.0
# The next step is LONGER times as long if this one took at most FEW factorizations, equally long up to MANY, SHORTER
# times above. A failed step is repeated with FAILED times its length.
FEW, MANY = 2, 3
LONGER, SHORTER, FAILED = 1.6, 0.7, 0.4
LONGEST_STEP, SHORTEST_STEP = 1.6, 0.1  # limits of a step's length
# eps = 0 is tried at the first eps that is not above SMALL, and at LEAST, where continuation ends. It also ends at a
# failed step from an eps of at most SMALL.
SMALL, LEAST = TRIES = 0.01, 0.003
BEGUN = 0.02  # eps at which continuation ends on a mesh whose flow is the start on a finer mesh
LARGEST = 0.05  # a flow with a larger eps is no answer
STARTS = 3  # number of flows of another mesh that are tried as a start, the one with the least eps first


def from_rest(problem, begin_only=False):
    """Outcome at full flow from rest. Raises ComputationError where no flow with eps <= LARGEST is found.

    problem: nonlinear.FlowProblem. begin_only: continuation ends at eps = BEGUN, or at 0 if the one attempt from there
    succeeds.
    """
    problem.boundaries.full()
    for eps in FIRST:
        first = not problem.passed
        found = _reached(problem, eps, ON_THE_WAY, FIRST_PICARD if first else 0, 2 * HARD if first else HARD)
        if not found.converged:
            raise problem.stalled(found)
        _pass(problem)
    follow(problem, [BEGUN] if begin_only else TRIES)
    return polish(problem)


def from_guess(problem, coarse, onward=True):
    """Outcome at full flow from the flow on another mesh, `coarse` (a solved FlowProblem).

    The start is the last flow with eps > 0 found on that mesh, or an earlier one if this fails. From the flow at
    eps = 0 Newton's method often fails, as the jets of two meshes differ. A mesh that was solved without continuation
    has only a flow with eps = 0. This flow is tried at eps = 0, and if that fails as the guess at eps = BEGUN. onward:
    eps is lowered further even if that mesh did not reach 0. Raises ComputationError.
    """
    problem.boundaries.full()
    starts = coarse.passed or [(coarse.artificial, coarse.state.x.array, coarse.inflow)]
    starts = [one for one in starts if one[0] > 0] or [(BEGUN, *starts[-1][1:]), starts[-1]]
    for eps, values, inflow in starts[: -STARTS - 1 : -1]:
        problem.set_guess(coarse.space, values, inflow)
        found = _reached(problem, eps, ON_THE_WAY if eps > 0 else TO_THE_END)
        if found.converged:
            break
    else:
        raise problem.stalled(found)
    _pass(problem)
    if coarse.artificial == 0:
        follow(problem, (max(eps, SMALL), LEAST))
    elif onward:
        follow(problem)
    return polish(problem)


def follow(problem, tries=TRIES):
    """Lowers eps step by step from the last flows in `problem.passed`, to 0 if possible, and adds the flows found.

    tries: eps = 0 is tried at the first eps below each of these. eps falls no further than the last of them.
    """
    step, least = None, tries[-1]
    while problem.left > HARD and problem.artificial > 0:
        eps, values, last_inflow = problem.passed[-1]
        if eps <= tries[0]:
            if _reached(problem, 0.0, TO_THE_END).converged:
                _pass(problem)
                return
            _back(problem)
            tries = [one for one in tries if one < eps]
            if not tries:
                return
        direction, inflow, change, length = _secant(problem)
        step = min(step or length, LONGEST_STEP)
        problem.state.x.array[:] = values + step * direction
        problem.inflow = last_inflow + step * inflow
        found = _reached(problem, max(eps * np.exp(step * change), least), ON_THE_WAY)
        if found.converged:
            _pass(problem)
            step *= LONGER if found.iterations <= FEW else 1.0 if found.iterations <= MANY else SHORTER
        else:
            _back(problem)
            step *= FAILED
            if eps <= SMALL or step < SHORTEST_STEP:
                return


def polish(problem):
    """Outcome of Newton's method to the residuals that the settings ask for, from the last flow in `problem.passed`.

    Where this fails, the flow before is tried, and so on. Raises ComputationError where none converges, or eps is above
    LARGEST.
    """
    settings, found = problem.settings, None
    while problem.passed:
        _back(problem)
        if problem.artificial > LARGEST:
            break
        print(f"artificial viscosity {problem.artificial:.3g}, to the end", file=problem.log, flush=True)
        found = newton.newton(problem, settings.residual_absolute, settings.residual_relative, 2 * HARD)
        problem.passed.pop()
        if found.converged:
            _pass(problem)
            found.iterations = problem.solver.factorizations
            return found
    raise problem.stalled(found)


def _reached(problem, eps, relative, most_picard=0, limit=HARD):
    """Outcome of Newton's method at eps from the present state, to a residual of `relative` times the pressure load.

    most_picard: most steps of Picard's method; limit: factorizations, as newton.newton has it.
    """
    problem.forms.artificial.value = eps
    print(f"artificial viscosity {eps:.3g}", file=problem.log, flush=True)
    return newton.newton(problem, np.inf, relative, limit, most_picard)


def _secant(problem):
    """(change of the values, of the inflow, of ln eps) for a step of length 1 along the last two flows, and the length
    between them. After a single flow, values and inflow stay as they are and only ln eps falls."""
    if len(problem.passed) < 2:
        return 0.0, 0.0, -1.0, FIRST_STEP
    (eps, values, inflow), (last, last_values, last_inflow) = problem.passed[-2:]
    change, change_of_log = last_values - values, np.log(last / eps)
    free = problem.space.free
    length = WEIGHT * problem.speed(change[free]) / problem.speed(last_values[free])
    length = float(np.hypot(length, change_of_log))
    return change / length, (last_inflow - inflow) / length, change_of_log / length, length


def _pass(problem):
    """Adds eps and the present flow to `problem.passed`."""
    problem.passed.append((problem.artificial, problem.state.x.array.copy(), problem.inflow))


def _back(problem):
    """Takes eps and the flow from the end of `problem.passed`."""
    problem.forms.artificial.value, problem.state.x.array[:], problem.inflow = problem.passed[-1]

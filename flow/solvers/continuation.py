"""From a creeping flow to the steady jet: an artificial viscosity eps h |u| is taken away step by step.

On a mesh that does not resolve a jet's shear layer Newton's method finds no steady flow from rest. With the artificial
viscosity (physics.navier_stokes) of eps = 1 it does, and the flow changes smoothly as eps falls. So the branch of flows
is followed in ln eps: the secant through the last two flows predicts the next, Newton's method corrects it with eps
held. A step that fails is shortened, one that was easy lengthens the next (natural-parameter continuation; Allgower and
Georg, Introduction to Numerical Continuation Methods, 2003, chapter 6). From SMALL and from LEAST eps = 0 is tried.
On the coarsest of three meshes continuation ends at BEGUN, where eps = 0 is tried once. The next mesh goes on from
there. If the mesh before has reached eps = 0, a finer mesh repeats the last step of that path, from the last flow with
eps > 0. If it has not, the finest mesh keeps its eps, so that both together show the mesh's error.
If no flow without artificial viscosity is found, the flow of the least eps answers. The effect of the rest of eps on
FFR is a part of the error estimate (errors.error_field).
"""

import numpy as np

from flow.solvers import newton

ON_THE_WAY = 2e-5  # residual over the load; at 1e-4 the flow of eps = .002 passes for that of 0
TO_THE_END = 1e-6  # the same at eps = 0
FIRST = (1.0, 0.4, 0.16)  # eps of the first flows, each from the one before
FIRST_PICARD = 4  # steps of Picard's method that the flow of FIRST[0] may take from rest
FIRST_STEP = 0.9  # length of the step after a single flow, where there is no secant yet
HARD = 6  # factorizations at one eps, after which the step counts as failed
WEIGHT = 3.0  # of the relative change of the velocities beside that of ln eps, in the length of a step
FEW, MANY = 2, 3  # factorizations of an easy step and of one that is long enough
LONGER, SHORTER, FAILED = 1.6, 0.7, 0.4  # change of the step's length then, above MANY, and where it fails
LONGEST_STEP, SHORTEST_STEP = 1.6, 0.1
# eps at which 0 is tried; between them a step that fails ends the way, and LEAST does
SMALL, LEAST = TRIES = 0.01, 0.003
BEGUN = 0.02  # where continuation ends on a mesh that a finer one goes on from
LARGEST = 0.05  # a flow of larger eps is no answer
STARTS = 3  # of the other mesh's flows, the least eps first, from which a flow is tried


def from_rest(problem, begin_only=False):
    """Outcome at full flow from rest. Raises ComputationError where no flow with eps <= LARGEST is found.

    begin_only: ends at eps = BEGUN, or at 0 where that follows from there at once.
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
    """Outcome at full flow from the flow on another mesh (a solved FlowProblem).

    The start is the last flow with eps > 0 on that mesh's path, or one before it if this fails. From the flow at
    eps = 0 Newton's method often fails, as the jets of two meshes differ. onward: eps is followed towards 0 even if
    that mesh did not reach 0. A mesh that was solved from another state has a flow with eps = 0 alone: where this fails
    it is the guess at eps = BEGUN. Raises ComputationError.
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
    """Goes on along the branch from the last flows passed, as far as eps = 0 where it leads there; tries: the eps at
    which 0 is tried; eps falls no further than the last of them.

    The state is the last flow passed.
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
    """Outcome of Newton's method from the last flow passed, or from the one before, to the residuals asked for.

    Raises ComputationError where neither leads to a flow, or eps is above LARGEST.
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
    """Outcome of Newton's method at eps from the present state, down to `relative` of the load."""
    problem.forms.artificial.value = eps
    print(f"artificial viscosity {eps:.3g}", file=problem.log, flush=True)
    return newton.newton(problem, np.inf, relative, limit, most_picard)


def _secant(problem):
    """Change of values, inflow and ln eps over a unit of length along the last two flows, and their distance; after a
    single flow that flow is the guess."""
    if len(problem.passed) < 2:
        return 0.0, 0.0, -1.0, FIRST_STEP
    (eps, values, inflow), (last, last_values, last_inflow) = problem.passed[-2:]
    change, change_of_log = last_values - values, np.log(last / eps)
    free = problem.space.free
    length = WEIGHT * problem.speed(change[free]) / problem.speed(last_values[free])
    length = float(np.hypot(length, change_of_log))
    return change / length, (last_inflow - inflow) / length, change_of_log / length, length


def _pass(problem):
    """Notes the present state as a flow on the branch."""
    problem.passed.append((problem.artificial, problem.state.x.array.copy(), problem.inflow))


def _back(problem):
    """Returns to the last flow on the branch."""
    problem.forms.artificial.value, problem.state.x.array[:], problem.inflow = problem.passed[-1]

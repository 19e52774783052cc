"""The way to a steady jet by fading an eddy viscosity, for meshes that do not resolve the jet's shear layer.

At a throat Reynolds number of several hundred the jet behind a lesion flaps on a coarse mesh and, where it meets a
bend, in the vessel too: neither line search nor pseudo-time finds the steady flow from rest. With the eddy viscosity
of a mixing length c l_jet in the jet's shear layer (discretisation.forms, geometry.jet) the flow is steady and
Newton's method converges within a few steps. So: backward-Euler Picard steps with a local time step at full flow and
large c, then Newton's method at c = MIXING[0], MIXING[1], ..., 0, each from the flows before, continued in a straight
line over c^2, with which the viscosity goes. Where the steady flow is lost on the way, the smallest c that has one is
kept and reported. Another mesh of the same lumen starts at the c that was kept on the first.
"""

import numpy as np

from flow.solvers import newton

ON_THE_WAY = 1e-4  # relative residual on the way to the smallest c
MIXING = (0.6, 0.4, 0.27, 0.18, 0.12, 0.06, 0.0)
LARGEST_MIXING = 0.27  # a flow that is not steady at or below it is refused
LOW_FLOW = 0.1  # of the flow: Newton's method reaches it from rest
PICARD_STEPS, FIRST_CFL, CFL_GROWTH = 5, 20.0, 1.5
SMALLEST_DECREASE = 0.02  # of c
NEIGHBOUR = 1.5  # times the only c with a flow: where a second is sought, for the error estimate
HARD = 6  # Newton steps at one c, after which the try is given up
LOST = 2  # tries given up at or below LARGEST_MIXING, after which the last c is kept


def from_rest(problem, resistances_at):
    """Outcome at full flow from rest. resistances_at(fraction) -> (n,) outlet resistances. Raises ComputationError."""
    problem.boundaries.lower(LOW_FLOW, resistances_at)
    newton.newton(problem, np.inf, ON_THE_WAY, HARD)
    problem.scale_to(1.0 / LOW_FLOW)
    problem.boundaries.full()
    problem.forms.mixing.value = MIXING[0]
    settle(problem)
    fade(problem, MIXING)
    return polish(problem)


def from_guess(problem, known, only_known=False):
    """Outcome at full flow from the present state, a flow at c = `known` on another mesh. Raises ComputationError.

    only_known: no larger c is tried.
    """
    guess = problem.state.x.array.copy(), problem.inflow
    for first in [known] if only_known else sorted({known, *(c for c in MIXING[:-1] if c >= 1.2 * known)}):
        problem.state.x.array[:], problem.inflow = guess
        found = _reach(problem, first)
        if found.converged:
            _pass(problem)
            fade(problem, [c for c in MIXING if c < 0.8 * first])
            return polish(problem)
    if only_known:
        raise problem.stalled(found)
    problem.state.x.array[:], problem.inflow = guess
    problem.forms.mixing.value = MIXING[0]
    settle(problem)
    fade(problem, MIXING)
    return polish(problem)


def settle(problem):
    """Backward-Euler Picard steps with a growing local time step from the present state."""
    cfl = FIRST_CFL
    free, inlet, _ = problem.residual()
    for _ in range(min(PICARD_STEPS, max(problem.left, 0))):
        free, inlet, _ = newton.picard(problem, free, inlet, 1.0 / cfl, f"Picard, CFL {cfl:.0f}")
        cfl *= CFL_GROWTH
    free.destroy()


def fade(problem, path):
    """Lowers c along `path` as far as a steady flow is found within the allowed factorizations; keeps the last.

    Where Newton's method fails it is tried from a c halfway.
    """
    ahead, lost = list(path), 0
    while ahead:
        _predict(problem, ahead[0])
        found = _reach(problem, ahead[0])
        if found.converged:
            ahead.pop(0)
            _pass(problem)
            continue
        if not problem.passed:
            raise problem.stalled(found)
        reached = problem.passed[-1][0]
        between = 0.5 * (reached + ahead[0])
        lost += reached <= LARGEST_MIXING
        if lost == LOST or reached - between < SMALLEST_DECREASE or problem.left <= HARD:
            break
        ahead.insert(0, between)
    _back(problem)
    if problem.mixing > LARGEST_MIXING:
        raise problem.stalled(found)


def _reach(problem, mixing):
    """Outcome of Newton's method at c = mixing from the present state."""
    problem.forms.mixing.value = mixing
    print(f"jet mixing {mixing:.3g}", file=problem.log, flush=True)
    return newton.newton(problem, np.inf, ON_THE_WAY, HARD)


def _pass(problem):
    """Notes the present state as a flow on the path."""
    problem.passed.append((problem.mixing, problem.state.x.array.copy(), problem.inflow))


def _back(problem):
    """Returns to the last flow on the path."""
    problem.forms.mixing.value, problem.state.x.array[:], problem.inflow = problem.passed[-1]


def _predict(problem, mixing):
    """Takes the last flow on the path, or where there are two their straight line over c^2 at c = mixing."""
    if not problem.passed:
        return
    _back(problem)
    if len(problem.passed) > 1:
        (c, values, inflow), (last, last_values, last_inflow) = problem.passed[-2:]
        share = (mixing**2 - last**2) / (last**2 - c**2)
        problem.state.x.array[:] += share * (last_values - values)
        problem.inflow += share * (last_inflow - inflow)


def _neighbour(problem):
    """Puts a flow of a larger c before the path's only one, where one is found."""
    only = problem.passed.pop()
    if _reach(problem, NEIGHBOUR * only[0]).converged:
        _pass(problem)
    problem.passed.append(only)
    _back(problem)


def polish(problem):
    """Outcome of Newton's method from the path's last flow to the residuals asked for.

    A flow that meets the looser residual of the path need not lead there, as where c is just below the least that has a
    steady flow: then the flows of larger c are tried, up to LARGEST_MIXING. Raises ComputationError.
    """
    settings = problem.settings
    while problem.passed and problem.passed[-1][0] <= LARGEST_MIXING:
        _back(problem)
        print(f"jet mixing {problem.mixing:.3g}, to the end", file=problem.log, flush=True)
        found = newton.newton(problem, settings.residual_absolute, settings.residual_relative, 2 * HARD)
        last = problem.passed.pop()
        if found.converged:
            _pass(problem)
            if last[0] > 0 and len(problem.passed) == 1:
                _neighbour(problem)
            found.iterations = problem.solver.factorizations
            return found
    raise problem.stalled(found)

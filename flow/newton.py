"""Newton's method with the error-oriented damping of Deuflhard (Newton Methods for Nonlinear Problems, 2004, NLEQ-ERR).

A step factor is judged by the correction that the same factorized tangent asks for after the step: it must be smaller
than the correction before. The residual, whose largest parts lie in the small cells of a throat, often has to rise on
the way to a jet's steady flow; the corrections, in m/s at the nodes, need not. Where the residual falls to half, as
from a creeping flow whose tangent knows no jet, that is good enough. The factor of the next step is that at which the
two corrections would differ by as much as they did.
"""

import dataclasses

import numpy as np

GOOD_RESIDUAL = 0.5  # of the residual before: a step that reaches it is taken whatever its correction
LEAST_FACTOR = 0.08  # of Newton's update: below it the state is too far from the solution


@dataclasses.dataclass
class Step:
    """A damped step: sizes of the corrections before and after it in m/s, the later correction, its factor."""

    before: float
    after: float
    correction: np.ndarray
    factor: float


def newton(problem, absolute, relative, limit, most_picard=0):
    """Outcome from the present state down to residuals `absolute` (N) and `relative` (to the load).

    Ends after `limit` factorizations or the last one allowed, and where no factor helps: there up to `most_picard`
    steps of Picard's are tried.
    """
    free, inlet, norm = problem.residual()
    start, last = problem.solver.factorizations, None
    while not problem.small(norm, absolute, relative):
        if problem.solver.factorizations - start >= limit or problem.left <= 0:
            break
        base, base_inflow = problem.state.x.array.copy(), problem.inflow
        problem.linearise(problem.forms.tangent)
        update, inflow_update = problem.correction(free, inlet)
        free.destroy()

        def residual_at(factor):
            problem.move(base, base_inflow, update, inflow_update, factor)
            return problem.residual()

        last, reached = _search(problem, residual_at, update, _first_factor(problem, last, update), norm)
        if last is not None:
            free, inlet, norm = reached
            problem.report(norm, f"Newton {last.factor:.2g}")
            continue
        free, inlet, norm = residual_at(0.0)
        if most_picard == 0 or problem.left <= 0:
            break
        most_picard -= 1
        free, inlet, norm = picard(problem, free, inlet, 0.0, "Picard")
    free.destroy()
    return problem.outcome(norm, absolute, relative, problem.solver.factorizations - start)


def picard(problem, free, inlet, rate, name):
    """`problem.residual()` after one step of Picard's method with the inertia of `rate` (flow.forms); frees `free`."""
    problem.forms.rate.value = rate
    base, base_inflow = problem.state.x.array.copy(), problem.inflow
    problem.linearise(problem.forms.picard)
    problem.move(base, base_inflow, *problem.correction(free, inlet), 1.0)
    free.destroy()
    reached = problem.residual()
    problem.report(reached[2], name)
    return reached


def _first_factor(problem, last, update):
    """The factor to try first, from what the step before showed of the tangent's change."""
    if last is None:
        return 1.0
    change = problem.speed(last.correction - update)
    return min(1.0, last.before * last.after / max(change * problem.speed(update), 1e-300) * last.factor)


def _search(problem, residual_at, update, factor, norm_before):
    """(Step, `residual_at` its factor), or (None, None) where none of at least LEAST_FACTOR is good."""
    before = problem.speed(update)
    factor = max(factor, LEAST_FACTOR)
    while factor >= LEAST_FACTOR:
        free, inlet, norm = residual_at(factor)
        if np.isfinite(norm):
            correction, _ = problem.correction(free, inlet)
            after = problem.speed(correction)
            if after < before or norm < GOOD_RESIDUAL * norm_before:
                return Step(before, after, correction, factor), (free, inlet, norm)
            bend = problem.speed(correction - (1 - factor) * update)
            factor = min(0.5 * before * factor**2 / bend, 0.5 * factor)
        else:
            factor *= 0.5
        free.destroy()
    return None, None

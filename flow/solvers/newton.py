"""Newton's method with the error-oriented damping of Deuflhard (Newton Methods for Nonlinear Problems, 2004, NLEQ-ERR).

A step factor is judged by the correction that the same factorized tangent asks for after the step: it must be smaller
than the correction before. The residual, whose largest parts lie in the small cells of a throat, often has to rise on
the way to a jet's steady flow; the corrections, in m/s at the nodes, need not. Where the residual falls to half, as
from a creeping flow whose tangent knows no jet, that is good enough. The factor of the next step is that at which the
two corrections would differ by as much as they did.

Where a whole step leaves a much smaller correction the flow is near, and steps with the same factorization and
Anderson acceleration (solvers.anderson) go on while the corrections shrink: each costs a residual and a solve.
"""

import dataclasses

import numpy as np

GOOD_RESIDUAL = 0.5  # of the residual before: a step that reaches it is taken whatever its correction
LEAST_FACTOR = 0.08  # of Newton's update: below it the state is too far from the solution
FAR = 0.15  # two steps in a row with smaller factors: too far as well
NEAR = 0.3  # the correction after a whole step over that before, below which the factorization is used again
NEARER = 0.1  # the same, below which it serves the error estimate (errors.error_field) too
SHRINKS = 0.5  # a correction above this share of the one before asks for a new factorization
MOST_ACCELERATED = 10  # steps with one factorization
MARGIN = 0.03  # of the limits: down to it accelerated steps go on, as one of Newton's steps would end far below them


@dataclasses.dataclass
class Step:
    """A damped step: sizes of the corrections before and after it in m/s, the later correction, its factor."""

    before: float
    after: float
    correction: np.ndarray
    inflow_correction: float
    factor: float


def newton(problem, absolute, relative, limit, most_picard=0, exact=False):
    """Outcome from the present state down to residuals `absolute` (N) and `relative` (to the load).

    Ends after `limit` factorizations, or after twice as many while whole steps serve, or after the last one allowed. It
    ends where two factors in a row are below FAR, and where no factor helps. There up to `most_picard` steps of
    Picard's are tried. exact: each step by its own tangent, without acceleration.
    """
    free, inlet, norm = problem.residual()
    start, last, factors = problem.solver.factorizations, None, []
    while not problem.small(norm, absolute, relative):
        most = 2 * limit if factors[-1:] == [1.0] else limit
        if problem.solver.factorizations - start >= most or problem.left <= 0:
            break
        if len(factors) > 1 and max(factors[-2:]) < FAR:
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
            factors.append(last.factor)
            free, inlet, norm = reached
            problem.report(norm, f"Newton {last.factor:.2g}")
            near = last.factor == 1 and last.after < NEAR * last.before
            if near and not exact and not problem.small(norm, absolute, relative):
                moved = np.append(base[problem.space.free], base_inflow), np.append(update, inflow_update)
                free, inlet, norm = _go_on(problem, reached, moved, last, (MARGIN * absolute, MARGIN * relative))
                if last.after > NEARER * last.before:
                    problem.outdate()
                last = None
            continue
        free, inlet, norm = residual_at(0.0)
        if most_picard == 0 or problem.left <= 0:
            break
        most_picard, factors = most_picard - 1, []
        free, inlet, norm = picard(problem, free, inlet)
    free.destroy()
    return problem.outcome(norm, absolute, relative, problem.solver.factorizations - start)


def picard(problem, free, inlet):
    """`problem.residual()` after one step of Picard's method; frees `free`."""
    base, base_inflow = problem.state.x.array.copy(), problem.inflow
    problem.linearise(problem.forms.picard)
    problem.move(base, base_inflow, *problem.correction(free, inlet), 1.0)
    free.destroy()
    reached = problem.residual()
    problem.report(reached[2], "Picard")
    return reached


def _go_on(problem, reached, moved, last, limits):
    """`problem.residual()` after accelerated steps with the last factorization; frees that of `reached`.

    reached: `problem.residual()` after the Step `last`; moved: state and update before it; limits: of the residual.
    Where a step does not serve the state is that before it.
    """
    acceleration = problem.acceleration()
    acceleration.step(*moved)
    correction, size = (last.correction, last.inflow_correction), last.after
    for count in range(MOST_ACCELERATED):
        base, base_inflow, before = problem.state.x.array.copy(), problem.inflow, reached[2]
        step = acceleration.step(np.append(base[problem.space.free], base_inflow), np.append(*correction))
        problem.move(base, base_inflow, step[:-1], step[-1], 1.0)
        reached[0].destroy()
        reached = problem.residual()
        if np.isfinite(reached[2]):
            correction = problem.correction(*reached[:2])
            now = problem.speed(correction[0])
        if not np.isfinite(reached[2]) or now > size and reached[2] > before:
            problem.move(base, base_inflow, 0.0, 0.0, 0.0)
            reached[0].destroy()
            return problem.residual()
        problem.report(reached[2], "accelerated")
        if problem.small(reached[2], *limits) or now > SHRINKS * size:
            break
        size = now
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
            correction, inflow_correction = problem.correction(free, inlet)
            after = problem.speed(correction)
            if after < before or norm < GOOD_RESIDUAL * norm_before:
                return Step(before, after, correction, inflow_correction, factor), (free, inlet, norm)
            bend = max(problem.speed(correction - (1 - factor) * update), 1e-300)
            factor = min(0.5 * before * factor**2 / bend, 0.5 * factor)
        else:
            factor *= 0.5
        free.destroy()
    return None, None

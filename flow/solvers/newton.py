"""Newton's method with the error-oriented damping of Deuflhard (Newton Methods for Nonlinear Problems, 2004, NLEQ-ERR).

The tangent K at the state before a step gives the correction -K^-1 F there, F being the residual. A damped step adds
this correction times a factor of at most 1. At the new state the same factorized K gives a further correction. The
factor is good if this second correction is smaller. The residual would mislead: its largest parts lie in the small
cells of a throat, and often have to rise on the way to a jet's steady flow. The corrections, in m/s at the nodes, need
not rise. A step that halves the residual is accepted whatever its correction, as in a step from a creeping flow, whose
tangent contains no jet. The first factor tried in a step follows from how much the tangent changed over the step before
(`_first_factor`).

Where a step with factor 1 leaves a much smaller correction, the solution is near. Then steps with the same
factorization and Anderson acceleration (solvers.anderson) follow while the corrections shrink. Each of them costs a
residual and a solve, but no factorization.
"""

import dataclasses

import numpy as np

GOOD_RESIDUAL = 0.5  # a step that reduces the residual below this share is accepted whatever its correction
LEAST_FACTOR = 0.08  # smaller factors are not tried: the state is then too far from the solution
FAR = 0.15  # Newton's method ends after two steps in a row with smaller factors
# Ratio of the corrections after and before a step with factor 1. Below NEAR the factorization is used again. Below
# NEARER it also serves the error estimate (errors.error_field).
NEAR = 0.3
NEARER = 0.1
SHRINKS = 0.5  # accelerated steps end at a correction larger than this share of the one before
MOST_ACCELERATED = 10  # accelerated steps with one factorization
# Accelerated steps end when the residual is below this share of its limits. A Newton step in their place would end as
# far below the limits.
MARGIN = 0.03


@dataclasses.dataclass
class Step:
    """A damped step: the sizes `before` and `after` in m/s of the corrections before and after it, and its factor.

    correction (n,) over the free dofs and inflow_correction in m3/s are the correction after the step.
    """

    before: float
    after: float
    correction: np.ndarray
    inflow_correction: float
    factor: float


def newton(problem, absolute, relative, limit, most_picard=0):
    """Outcome of Newton's method from the present state of a FlowProblem.

    It has converged when the residual is below `absolute` in N and below `relative` times the pressure load. It ends
    after `limit` factorizations (twice as many if the last factor was 1), or when the settings allow no more. It also
    ends where two factors in a row are below FAR. Where no factor is good, a step of Picard's method is made instead,
    at most `most_picard` times.
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
            if near and not problem.small(norm, absolute, relative):
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
    """Makes one step of Picard's method and returns `problem.residual()` after it.

    free, inlet: residual before, as `problem.residual` returns it; the vector `free` is freed.
    """
    base, base_inflow = problem.state.x.array.copy(), problem.inflow
    problem.linearise(problem.forms.picard)
    problem.move(base, base_inflow, *problem.correction(free, inlet), 1.0)
    free.destroy()
    reached = problem.residual()
    problem.report(reached[2], "Picard")
    return reached


def _go_on(problem, reached, moved, last, limits):
    """Makes accelerated steps with the last factorization and returns `problem.residual()` after them.

    reached: `problem.residual()` after the Step `last`, whose vector is freed; moved: (state, update) before it;
    limits: (absolute in N, over the pressure load) of the residual. A step that raises both residual and correction is
    taken back, and ends the iteration.
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
    """The factor to try first: the smaller, the more the tangent changed over the step before.

    last: that Step; without one (None) the factor is 1. update (n,): the new correction.
    """
    if last is None:
        return 1.0
    change = problem.speed(last.correction - update)
    return min(1.0, last.before * last.after / max(change * problem.speed(update), 1e-300) * last.factor)


def _search(problem, residual_at, update, factor, norm_before):
    """(Step, `residual_at` its factor), or (None, None) where no factor of at least LEAST_FACTOR is good.

    residual_at(factor): moves the state and gives `problem.residual()`; factor: the first one tried; norm_before: norm
    in N of the residual before the step.
    """
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

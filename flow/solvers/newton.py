"""Newton's method with the error-oriented damping of Deuflhard (Newton Methods for Nonlinear Problems, 2004, NLEQ-ERR).

The tangent K at the state before a step gives the correction -K^-1 F there, F being the residual. A damped step adds
this correction times a factor of at most 1. At the new state the same factorized K gives a further correction. The
factor is accepted if this second correction is smaller. The residual would mislead: its largest parts lie in the small
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

ACCEPTED_REDUCTION = 0.5  # a step that reduces the residual below this share is accepted whatever its correction
LEAST_FACTOR = 0.08  # smaller factors are not tried: the state is then too far from the solution
STALLED_FACTOR = 0.15  # Newton's method ends after two steps in a row with smaller factors
# Ratio of the corrections after and before a step with factor 1. Below REUSE_FOR_STEPS the factorization is used again.
# Below REUSE_FOR_ESTIMATE it also serves the error estimate (errors.error_field).
REUSE_FOR_STEPS = 0.3
REUSE_FOR_ESTIMATE = 0.1
LARGEST_SHRINK_RATIO = 0.5  # accelerated steps end at a correction larger than this share of the one before
MOST_ACCELERATED = 10  # most accelerated steps with one factorization
# Accelerated steps end when the residual is below this share of its tolerance. A Newton step in their place would leave
# a residual about as far below the tolerance.
RESIDUAL_MARGIN = 0.03


@dataclasses.dataclass
class DampedStep:
    """A damped step: its factor, and the sizes in m/s of the corrections before and after it.

    correction (n,) over the free dofs and inflow_correction in m3/s are the correction after it.
    """

    size_before: float
    size_after: float
    correction: np.ndarray
    inflow_correction: float
    factor: float


@dataclasses.dataclass
class Outcome:
    """Result of Newton's method: whether it converged, iterations (number of factorizations), and the residual's norm.

    residual_absolute in N; residual_relative: the same over the pressure load (FlowProblem.pressure_load).
    """

    converged: bool
    iterations: int
    residual_absolute: float
    residual_relative: float


def newton_from(problem, fields, inflow, limit, picard_steps=0):
    """Outcome of Newton's method at the full flow, without artificial viscosity, from a flow that was found elsewhere.

    problem: nonlinear.FlowProblem; fields: (velocity (n, 3) in m/s, pressure (n,) in Pa) of that flow at the velocity
    nodes; inflow in m3/s; limit: as in `newton`; picard_steps: steps of Picard's method that come first.
    """
    problem.boundaries.set_full_flow()
    problem.forms.artificial_viscosity.value = 0.0
    problem.set_flow(*fields, inflow)
    for _ in range(min(picard_steps, max(problem.factorizations_left, 0))):
        picard(problem, *problem.residual()[:2])
    return newton(problem, problem.settings.residual_absolute, limit)


def newton(problem, tolerance_n, limit, most_picard=0):
    """Outcome of Newton's method from the present state of a FlowProblem.

    It has converged when the residual is at most `tolerance_n` in N. It gives up after `limit` factorizations, or when
    the settings allow no more. If the last step was undamped (factor 1), it may take twice `limit`. It also gives up
    after two steps in a row with damping factors below STALLED_FACTOR. Where no damping factor is accepted, a step of
    Picard's method is made instead, at most `most_picard` times.
    """
    free, inlet, norm = problem.residual()
    start, last_step, factors = problem.solver.factorizations, None, []
    while not norm <= tolerance_n:
        most_factorizations = 2 * limit if factors[-1:] == [1.0] else limit
        if problem.solver.factorizations - start >= most_factorizations or problem.factorizations_left <= 0:
            break
        if len(factors) > 1 and max(factors[-2:]) < STALLED_FACTOR:
            break
        base, base_inflow = problem.state.x.array.copy(), problem.inflow
        problem.linearise(problem.forms.tangent)
        update, inflow_update = problem.correction(free, inlet)

        def residual_at(factor):
            problem.move(base, base_inflow, update, inflow_update, factor)
            return problem.residual()

        last_step, residual_after = _search_factor(
            problem, residual_at, update, _first_factor(problem, last_step, update), norm
        )
        if last_step is not None:
            factors.append(last_step.factor)
            free, inlet, norm = residual_after
            problem.report(norm, f"Newton {last_step.factor:.2g}")
            is_near = last_step.factor == 1 and last_step.size_after < REUSE_FOR_STEPS * last_step.size_before
            if is_near and norm > tolerance_n:
                last_move = np.append(base[problem.space.free_dofs], base_inflow), np.append(update, inflow_update)
                free, inlet, norm = _accelerate(problem, residual_after, last_move, last_step, tolerance_n)
                if last_step.size_after > REUSE_FOR_ESTIMATE * last_step.size_before:
                    problem.mark_outdated()
                last_step = None
            continue
        free, inlet, norm = residual_at(0.0)
        if most_picard == 0 or problem.factorizations_left <= 0:
            break
        most_picard, factors = most_picard - 1, []
        free, inlet, norm = picard(problem, free, inlet)
    iterations = problem.solver.factorizations - start
    return Outcome(norm <= tolerance_n, iterations, norm, norm / problem.pressure_load)


def picard(problem, free, inlet):
    """Makes one step of Picard's method and returns `problem.residual()` after it.

    free, inlet: the residual before the step, as `problem.residual` returns it.
    """
    base, base_inflow = problem.state.x.array.copy(), problem.inflow
    problem.linearise(problem.forms.picard)
    problem.move(base, base_inflow, *problem.correction(free, inlet), 1.0)
    residual_after = problem.residual()
    problem.report(residual_after[2], "Picard")
    return residual_after


def _accelerate(problem, residual_after, last_move, last_step, tolerance_n):
    """Makes accelerated steps with the last factorization and returns `problem.residual()` after them.

    residual_after: `problem.residual()` after the DampedStep `last_step`; last_move: (state, update) before it;
    tolerance_n: tolerance of the residual, as in `newton`. A step that raises both residual and correction is taken
    back, and ends the iteration.
    """
    acceleration = problem.acceleration()
    acceleration.step(*last_move)
    correction, size = (last_step.correction, last_step.inflow_correction), last_step.size_after
    for count in range(MOST_ACCELERATED):
        base, base_inflow, before = problem.state.x.array.copy(), problem.inflow, residual_after[2]
        step = acceleration.step(np.append(base[problem.space.free_dofs], base_inflow), np.append(*correction))
        problem.move(base, base_inflow, step[:-1], step[-1], 1.0)
        residual_after = problem.residual()
        if np.isfinite(residual_after[2]):
            correction = problem.correction(*residual_after[:2])
            new_size = problem.velocity_norm(correction[0])
        if not np.isfinite(residual_after[2]) or new_size > size and residual_after[2] > before:
            problem.move(base, base_inflow, 0.0, 0.0, 0.0)
            return problem.residual()
        problem.report(residual_after[2], "accelerated")
        if residual_after[2] <= RESIDUAL_MARGIN * tolerance_n or new_size > LARGEST_SHRINK_RATIO * size:
            break
        size = new_size
    return residual_after


def _first_factor(problem, last_step, update):
    """The factor to try first. The more the tangent changed over the last step, the smaller it is.

    last_step: the DampedStep before, or None; then the factor is 1. update (n,): the new correction.
    """
    if last_step is None:
        return 1.0
    change = problem.velocity_norm(last_step.correction - update)
    return min(
        1.0,
        last_step.size_before
        * last_step.size_after
        / max(change * problem.velocity_norm(update), 1e-300)
        * last_step.factor,
    )


def _search_factor(problem, residual_at, update, factor, norm_before):
    """(DampedStep, residual after it), or (None, None) where no factor of at least LEAST_FACTOR is accepted.

    residual_at(factor): moves the state and gives `problem.residual()`; factor: the first one tried; norm_before: norm
    in N of the residual before the step.
    """
    size_before = problem.velocity_norm(update)
    factor = max(factor, LEAST_FACTOR)
    while factor >= LEAST_FACTOR:
        free, inlet, norm = residual_at(factor)
        if np.isfinite(norm):
            correction, inflow_correction = problem.correction(free, inlet)
            size_after = problem.velocity_norm(correction)
            if size_after < size_before or norm < ACCEPTED_REDUCTION * norm_before:
                return DampedStep(size_before, size_after, correction, inflow_correction, factor), (free, inlet, norm)
            change = max(problem.velocity_norm(correction - (1 - factor) * update), 1e-300)
            factor = min(0.5 * size_before * factor**2 / change, 0.5 * factor)
        else:
            factor *= 0.5
    return None, None

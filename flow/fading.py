"""The way to a steady jet by fading an eddy viscosity, for meshes that do not resolve the jet's shear layer.

At a throat Reynolds number of several hundred the jet behind a lesion flaps on a coarse mesh and, where it meets a
bend, in the vessel too: neither line search nor pseudo-time finds the steady flow from rest. With the eddy viscosity
of a mixing length c l_jet in the jet's shear layer (flow.forms, flow.jet) the flow is steady and Newton's method
converges within a few steps. So: backward-Euler Picard steps with a local time step at full flow and large c, then
Newton's method at c = MIXING[0], MIXING[1], ..., 0, each from the last. Where the steady flow is lost on the way, the
smallest c that has one is kept and reported.
"""

import numpy as np

ON_THE_WAY = 1e-4  # relative residual on the way to the smallest c
MIXING = (0.6, 0.4, 0.27, 0.18, 0.12, 0.06, 0.0)
LARGEST_MIXING = 0.27  # a flow that is not steady at or below it is refused
LOW_FLOW = 0.1  # of the flow: Newton's method reaches it from rest
PICARD_STEPS, FIRST_CFL, CFL_GROWTH = 5, 20.0, 1.5
SMALLEST_DECREASE = 0.02  # of c
HARD = 8  # Newton steps at one c, after which the try is given up


def from_rest(problem, resistances_at):
    """Outcome at full flow from rest. resistances_at(fraction) -> (n,) outlet resistances. Raises ComputationError."""
    problem.boundaries.resistance = resistances_at(LOW_FLOW)
    problem.newton(np.inf, ON_THE_WAY, HARD)
    problem.scale_to(1.0 / LOW_FLOW)
    problem.boundaries.resistance = problem.boundaries.full_resistance.copy()
    return from_guess(problem)


def from_guess(problem):
    """Outcome at full flow from the present state. Raises ComputationError."""
    problem.forms.mixing.value = MIXING[0]
    settle(problem)
    fade(problem, MIXING)
    return polish(problem)


def settle(problem):
    """Backward-Euler Picard steps with a growing local time step from the present state."""
    cfl = FIRST_CFL
    for _ in range(PICARD_STEPS):
        problem.forms.rate.value = 1.0 / cfl
        free, inlet, _ = problem.residual()
        base, base_inflow = problem.state.x.array.copy(), problem.inflow
        update, inflow_update = problem.step(problem.forms.picard, free, inlet)
        problem.move(base, base_inflow, update, inflow_update, 1.0)
        free.destroy()
        free, _, norm = problem.residual()
        free.destroy()
        problem.report(norm, f"Picard, CFL {cfl:.0f}")
        cfl *= CFL_GROWTH


def fade(problem, path):
    """Lowers c along `path` as far as a steady flow is found within the allowed factorizations; keeps the last.

    Where Newton's method fails it is tried once more after Picard steps, then from a c halfway.
    """
    ahead, settled, start = list(path), False, (None, problem.state.x.array.copy(), problem.inflow)
    while ahead:
        problem.forms.mixing.value = ahead[0]
        print(f"jet mixing {problem.mixing:.3g}", file=problem.log, flush=True)
        remaining = problem.settings.max_newton_iterations - problem.solver.factorizations
        found = problem.newton(np.inf, ON_THE_WAY, min(HARD, remaining))
        if found.converged:
            settled = False
            problem.passed.append((ahead.pop(0), problem.state.x.array.copy(), problem.inflow))
            continue
        if not settled:
            _, problem.state.x.array[:], problem.inflow = problem.passed[-1] if problem.passed else start
            settle(problem)
            settled = True
            continue
        if not problem.passed:
            raise problem.stalled(found)
        settled = False
        reached, problem.state.x.array[:], problem.inflow = problem.passed[-1]
        between = 0.5 * (reached + problem.mixing)
        if reached - between < SMALLEST_DECREASE or remaining <= HARD:
            break
        ahead.insert(0, between)
    if problem.passed[-1][0] > LARGEST_MIXING:
        raise problem.stalled(found)
    problem.forms.mixing.value, problem.state.x.array[:], problem.inflow = problem.passed[-1]


def polish(problem):
    """Outcome of Newton's method from the path's last flow to the residuals asked for.

    A flow that meets the looser residual of the path need not lead there: then the Picard steps are tried, then the
    flows of larger c, up to LARGEST_MIXING.
    """
    while problem.passed:
        mixing, values, inflow = problem.passed[-1]
        if mixing > LARGEST_MIXING:
            break
        for settled in (False, True):
            problem.forms.mixing.value, problem.state.x.array[:], problem.inflow = mixing, values, inflow
            if settled:
                settle(problem)
            print(f"jet mixing {mixing:.3g}, to the end", file=problem.log, flush=True)
            found = problem.newton(problem.settings.residual_absolute, problem.settings.residual_relative, 2 * HARD)
            if found.converged:
                found.iterations = problem.solver.factorizations
                return found
        problem.passed.pop()
    raise problem.stalled(found)

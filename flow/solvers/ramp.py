"""From rest to the full flow by Newton's method, at a few increasing fractions of the flow.

At each of FRACTIONS the outlet resistances are raised so that the reduced models carry that fraction of their flow. On
a mesh that resolves the jet's shear layer (meshing.sweep), this finds the flow in a straight tube in some ten
factorizations. At Re 1,500 solvers.continuation does not find this flow. In trees, and where a fraction fails,
continuation takes fewer factorizations.
"""

from flow.solvers import newton

FRACTIONS = (0.1, 0.2, 0.35, 0.6, 1.0)
# Most factorizations at a fraction below 1, and at the full flow. If they do not suffice, the ramp is given up.
MOST_FACTORIZATIONS, MOST_AT_FULL_FLOW = 4, 8
MOST_PICARD = 1  # most steps of Picard's method at one fraction
INTERMEDIATE_REDUCTION = 5e-2  # at a fraction below 1, Newton's method ends when the residual has fallen to this share


def raise_flow(problem, resistances_at):
    """Outcome at the full flow, or at the first fraction where Newton's method fails.

    problem: nonlinear.FlowProblem; resistances_at(fraction) -> (n,) outlet resistances in Pa s/m3.
    """
    last_fraction = None
    problem.forms.artificial_viscosity.value = 0.0
    for fraction in FRACTIONS:
        problem.boundaries.set_flow_fraction(fraction, resistances_at)
        print(f"flow fraction {fraction:.3g}", file=problem.log, flush=True)
        # a jet keeps its shape as the flow grows; the first, slow flow has no jet
        if last_fraction and last_fraction > FRACTIONS[0]:
            problem.scale_flow(fraction / last_fraction)
        tolerance_n, limit = problem.settings.residual_absolute, MOST_AT_FULL_FLOW
        if fraction < FRACTIONS[-1]:
            tolerance_n, limit = INTERMEDIATE_REDUCTION * problem.residual()[2], MOST_FACTORIZATIONS
        outcome = newton.newton(problem, tolerance_n, limit, MOST_PICARD)
        if not outcome.converged:
            return outcome
        last_fraction = fraction
    return outcome

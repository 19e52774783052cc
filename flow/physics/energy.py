"""Energy balance of a solved flow: the momentum equation tested with the velocity itself.

    P_in Q + kinetic_in = sum over outlets (P_i Q_i + kinetic_i) + friction + grad-div + artificial + backflow

All terms are powers in W. Friction is the loss by the fluid's viscosity. The grad-div, artificial viscosity (0 for
eps = 0) and backflow terms are losses that the discretisation adds. The two sides differ by the error of quadrature in
curved cells and by the residual.
"""

import ufl

from flow.geometry.tags import PHYSICAL_INLET


def balance(problem):
    """{"inlet_w", "outlets_w", "friction_w", "grad_div_w", "artificial_w", "backflow_w", "imbalance"} of a flow.

    problem: solvers.nonlinear.FlowProblem. imbalance: |difference of the two sides| over the power at the inlet.
    """
    forms, boundaries = problem.forms, problem.boundaries
    power = forms.integral
    lost = {f"{name}_w": power(ufl.action(form, problem.state)) for name, form in forms.losses.items()}
    outflows = boundaries.outflows(problem.state.x.array)
    problem.residual()  # sets mean_inlet_pressure
    pressure_in = problem.mean_inlet_pressure * problem.inflow
    inlet = pressure_in - power(forms.kinetic_energy_flow(PHYSICAL_INLET))
    outlets = float(boundaries.pressures(outflows) @ outflows) + power(
        forms.kinetic_energy_flow(tuple(problem.space.outlet_tags))
    )
    return {
        "inlet_w": inlet,
        "outlets_w": outlets,
        **lost,
        "imbalance": abs(inlet - outlets - sum(lost.values())) / abs(inlet),
    }

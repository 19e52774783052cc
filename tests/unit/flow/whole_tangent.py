"""Newton's tangent over velocity and pressure together. The solver itself never assembles it as a whole."""

import ufl

from flow.discretisation import compat


def compile_tangent(forms):
    """Compiled derivative of the residual of discretisation.forms.NavierStokes over W, at its present eps."""
    return compat.form(ufl.derivative(forms._residuals[int(forms.artificial_viscosity.value > 0)], forms._state))

"""Newton's method on the weak form of discretisation.forms with velocities prescribed wherever a test wants them."""

import ufl
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from common import fenicsx
from flow.discretisation import compat

MOST_STEPS = 20


def solve(forms, state, conditions, load=None, tolerance=1e-11):
    """Solves forms.residual = load for the Function `state` with Dirichlet `conditions`; load: vector or None.

    Newton's method ends when the norm of its update is below `tolerance` times the norm of the state. Returns the
    residual's vector. Its entries at the prescribed dofs are the reaction forces there.
    """
    ksp = PETSc.KSP().create(state.function_space.mesh.comm)
    ksp.setType("preonly")
    ksp.getPC().setType("lu")
    ksp.getPC().setFactorSolverType("mumps")
    x, tangent = fenicsx.petsc_vector(state), compat.form(ufl.derivative(forms._residuals[0], state))
    for _ in range(MOST_STEPS):
        b = residual(forms, load)
        A = fem_petsc.assemble_matrix(tangent, bcs=conditions)
        A.assemble()
        fem_petsc.apply_lifting(b, [tangent], [conditions], [x], -1.0)
        fem_petsc.set_bc(b, conditions, x, -1.0)
        update = b.duplicate()
        ksp.setOperators(A)
        ksp.solve(b, update)
        x.axpy(-1.0, update)
        A.destroy()
        if update.norm() < tolerance * x.norm():
            ksp.destroy()
            return residual(forms, load)
    raise RuntimeError("Newton's method with prescribed velocities did not converge")


def residual(forms, load=None):
    """The assembled residual minus the load."""
    b = fem_petsc.assemble_vector(forms.residual)
    if load is not None:
        b.axpy(-1.0, load)
    return b

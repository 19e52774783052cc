"""How the wall of a section bends along the vessel where the offset of its stent varies."""

import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from common import fenicsx

PIN = 1e-9  # share of a mass matrix that fixes the constant which the equation of the warping leaves open


class WallBending:
    """How fibres along the vessel move where the stent's offset d(s) varies, and how stiff they are.

    The section's points move by d phi in its plane; `shape` is phi. The fibres then move by -d' psi along the vessel.
    psi leaves the least shear: div(G (phi - grad psi)) = 0, with no flux through the boundary. The shear that is left
    is ignored. (This is warping as in generalised beam theory, Schardt 1989.) If the section is also turned by theta,
    the energy of the fibres' stretch is E/2 of the integral of (theta' x + d'' psi)^2, x the distance from the
    centroid. So psi is divided into following * x, by which the section turns, and the rest, whose stiffness is the
    wall's own. E = 3 G as in `SliceModel.beam_stiffness`. All is of the deformed section.
    """

    def __init__(self, mesh, displacement, shear_modulus, inverse_gradient, measure):
        """shear_modulus: per undeformed area, in MPa; inverse_gradient: of the deformation, in the plane."""
        space = fenicsx.function_space(mesh, fenicsx.lagrange("quadrilateral", 2))
        self.shape = fem.Function(displacement.function_space)  # phi
        self._warping, self._direction = fem.Function(space), fem.Constant(mesh, (1.0, 0.0))
        trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)

        def gradient(field):
            return ufl.transpose(inverse_gradient) * ufl.grad(field)

        self._matrix = fenicsx.form(
            (shear_modulus * ufl.inner(gradient(trial), gradient(test)) + PIN * trial * test) * measure
        )
        self._vector = fenicsx.form(shear_modulus * ufl.inner(self.shape, gradient(test)) * measure)
        x, psi = ufl.inner(ufl.SpatialCoordinate(mesh) + displacement, self._direction), self._warping
        products = (1, x, psi, x * x, x * psi, psi * psi)
        self._moments = [fenicsx.form(shear_modulus * product * measure) for product in products]

    def measure(self, direction):
        """(following, stiffness in N mm2) for the `shape` that is set, of a stent that is offset along `direction`."""
        self._direction.value = direction
        matrix, vector = fem_petsc.assemble_matrix(self._matrix), fem_petsc.assemble_vector(self._vector)
        matrix.assemble()
        solver = PETSc.KSP().create(PETSc.COMM_SELF)
        solver.setType("preonly")
        solver.getPC().setType("lu")
        solver.setOperators(matrix)
        solver.solve(vector, fenicsx.petsc_vector(self._warping))
        one, x, psi, xx, xpsi, psipsi = (fem.assemble_scalar(form) for form in self._moments)
        xx, xpsi, psipsi = xx - x * x / one, xpsi - x * psi / one, psipsi - psi * psi / one
        following = xpsi / xx
        return following, 3 * (psipsi - following * xpsi)

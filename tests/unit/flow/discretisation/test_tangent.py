"""The matrix of the free dofs equals the derivative of the residual in each entry, each time the matrix is filled."""

import json

import numpy as np
import pytest
import scipy.sparse
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

import tubes
import whole_tangent
from flow import settings
from flow.discretisation import compat, forms, spaces, tangent
from flow.physics import navier_stokes, outlets, viscosity
from flow.solvers import marching, nonlinear

DENSITY = 1060.0


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A narrowed tube, meshed through the command line, and its boundary values."""
    folder = tmp_path_factory.mktemp("tangent")
    tubes.mesh_narrowed(folder, 0.3, 8.0, 1.2)
    return folder


@pytest.fixture
def problem(case):
    """FlowProblem at a random state: in- and outflow at the outlet, so that the backflow term acts."""
    document = json.loads((case / "boundary.json").read_text())
    space = spaces.read(case / "mesh.msh")
    bounds = outlets.Boundaries(space, document)
    found = nonlinear.FlowProblem(space, bounds, document, settings.make())
    found.state.x.array[:] = np.random.default_rng(0).normal(size=space.dofs)
    yield found
    found.destroy()


def _free(problem, compiled):
    """Entries between the free dofs of a compiled form over W, as PETSc assembles them one by one."""
    matrix = fem_petsc.assemble_matrix(compiled)
    matrix.assemble()
    chosen = PETSc.IS().createGeneral(problem.space.free_dofs, comm=PETSc.COMM_SELF)
    part = matrix.createSubMatrix(chosen, chosen)
    found = _csr(part)
    for petsc_object in (matrix, chosen, part):
        petsc_object.destroy()
    return found


def _csr(matrix):
    starts, columns, values = matrix.getValuesCSR()
    return scipy.sparse.csr_matrix((values, columns, starts), matrix.size)


def _apart(one, other):
    return scipy.sparse.linalg.norm(one - other) / scipy.sparse.linalg.norm(other)


@pytest.mark.parametrize("eps", [0.0, 0.3])
def test_it_is_the_whole_tangent_between_the_free_dofs(problem, eps):
    problem.forms.artificial_viscosity.value = eps
    built, values = tangent.FreeMatrix(problem.space, problem.forms), problem.state.x.array
    for factor in (1.0, -0.5):  # the second time the matrix is filled again, at another state
        values *= factor
        built.assemble(problem.forms.tangent)
        assert _apart(built.matrix, _free(problem, whole_tangent.compile_tangent(problem.forms))) < 1e-14
    built.destroy()


def test_the_artificial_viscosity_changes_it(problem):
    """The tangent depends on eps. Otherwise the test above would not check the artificial viscosity."""
    plain = _free(problem, whole_tangent.compile_tangent(problem.forms))
    problem.forms.artificial_viscosity.value = 0.3
    assert _apart(_free(problem, whole_tangent.compile_tangent(problem.forms)), plain) > 1e-6


@pytest.mark.parametrize("eps", [0.0, 0.3])
def test_picards_matrix_convects_by_the_state_alone(problem, eps):
    """The matrix is compared with a form written out here: rho (w.grad u + div w u / 2, v) with the state w, and the
    other terms."""
    u, _ = ufl.split(problem.state)
    problem.forms.artificial_viscosity.value = eps
    W, mesh = problem.space.W, problem.space.mesh
    (du, dp), (v, q) = ufl.TrialFunctions(W), ufl.TestFunctions(W)
    n, dx = ufl.FacetNormal(mesh), ufl.dx(metadata={"quadrature_degree": 5})
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=problem.space.facet_tags, metadata={"quadrature_degree": 6})
    carried = ufl.dot(ufl.grad(du), u) + 0.5 * ufl.div(u) * du
    inward = 0.5 * (ufl.dot(u, n) - abs(ufl.dot(u, n)))
    width = (6 / 8 * abs(ufl.JacobianDeterminant(mesh)) ** (2 / 3)) ** 0.5  # about half an edge
    given = settings.make()
    wanted = DENSITY * ufl.inner(carried, v) * dx
    wanted += 0.004 * ufl.inner(ufl.grad(du), ufl.grad(v)) * dx + given.grad_div_pa_s * ufl.div(du) * ufl.div(v) * dx
    wanted -= (dp * ufl.div(v) + q * ufl.div(du)) * dx
    speed = ufl.sqrt(ufl.inner(u, u) + navier_stokes.SPEED_FLOOR**2)
    coarser = ufl.dx(metadata={"quadrature_degree": 3})
    factor = fem.Constant(mesh, PETSc.ScalarType(eps))
    wanted += DENSITY * factor * width * speed * ufl.inner(ufl.grad(du), ufl.grad(v)) * coarser
    wanted -= DENSITY * given.backflow_coefficient * inward * ufl.inner(du, v) * ds(tuple(problem.space.outlet_tags))
    built = tangent.FreeMatrix(problem.space, problem.forms)
    built.assemble(problem.forms.picard)
    found = _free(problem, compat.form(wanted))
    assert _apart(built.matrix, found) < 1e-12
    built.assemble(problem.forms.tangent)
    assert _apart(built.matrix, found) > 1e-3
    built.destroy()


def test_inertia_adds_its_mass_to_residual_and_matrix(problem):
    built, inertia = tangent.FreeMatrix(problem.space, problem.forms), marching.Inertia(problem)
    inertia.weight, state = 300.0, problem.state.x.array
    inertia.past_terms = 300.0 * state + 7.0  # a rate of change of -7 m/s2 in every dof
    base = np.random.default_rng(1).normal(size=problem.space.dofs)
    force = base.copy()
    inertia.add_force(force, state)
    v, _ = ufl.TestFunctions(problem.space.W)
    du, _ = ufl.TrialFunctions(problem.space.W)
    steady = fem.Constant(problem.space.mesh, PETSc.ScalarType((-7.0, -7.0, -7.0)))
    dx = ufl.dx(metadata={"quadrature_degree": 5})
    wanted = fem_petsc.assemble_vector(compat.form(DENSITY * ufl.inner(steady, v) * dx)).array
    assert np.linalg.norm(force - base - wanted) < 1e-9 * np.linalg.norm(wanted)
    built.assemble(problem.forms.tangent)
    without = built.matrix.copy()
    built.assemble(problem.forms.tangent, inertia)
    mass = _free(problem, compat.form(DENSITY * ufl.inner(du, v) * dx))
    assert _apart(built.matrix - without, 300.0 * mass) < 1e-9
    inertia.destroy()
    built.destroy()


def test_products_with_a_profile_are_those_of_the_whole_matrix(problem):
    built, profile = tangent.FreeMatrix(problem.space, problem.forms), problem.boundaries.profile
    built.assemble(problem.forms.tangent)
    matrix = fem_petsc.assemble_matrix(whole_tangent.compile_tangent(problem.forms))
    matrix.assemble()
    given, found = matrix.createVecs()
    given.array[:] = profile
    for transposed, product in ((False, matrix.mult), (True, matrix.multTranspose)):
        product(given, found)
        assert np.abs(built.multiply(profile, transposed) - found.array).max() < 1e-13 * np.abs(found.array).max()
    matrix.destroy()
    built.destroy()


def test_without_artificial_viscosity_the_residual_is_that_of_none(problem):
    """With eps = 0 forms without the artificial viscosity are used. They must equal the forms with a vanishing eps."""
    found = []
    for factor in (0.0, 1e-15, 0.3):
        problem.forms.artificial_viscosity.value = factor
        found.append(problem.forms.assemble_residual())
    size = np.linalg.norm(found[0])
    assert np.linalg.norm(found[1] - found[0]) < 1e-13 * size < 1e-6 * np.linalg.norm(found[2] - found[0])


@pytest.mark.slow
def test_the_viscosity_by_shear_rate_is_in_the_matrix(problem):
    thick = viscosity.CarreauYasuda(0.056, 0.0035, 1.902, 1.25, 0.22)
    weak = forms.NavierStokes(problem.space, problem.state, DENSITY, thick, 0.2, 0.5)
    built = tangent.FreeMatrix(problem.space, weak)
    built.assemble(weak.tangent)
    assert _apart(built.matrix, _free(problem, whole_tangent.compile_tangent(weak))) < 1e-14
    assert _apart(built.matrix, _free(problem, whole_tangent.compile_tangent(problem.forms))) > 1e-6
    built.destroy()

"""Manufactured solution on curved tetrahedra, solved with the weak form of discretisation.forms.

In a bent tube of swept cells the orders of convergence are checked. At a branch point, which gmsh meshes, the errors
are compared with those of the exact solution's interpolant.

u = U (sin y + cos z, sin z + cos x, sin x + cos y), p = P (sin x cos y + cos z) with x, y, z in units of 1 / WAVE. This
velocity has div u = 0. The load is the residual of the strong form. In the tube the velocity is prescribed on the whole
boundary and the pressure at one node. At the branch point one outlet is free, and the load contains the traction there.
"""

import pathlib
import sys

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow"), str(pathlib.Path(__file__).parent)]

import prescribed  # noqa: E402
import tubes  # noqa: E402
from flow import settings  # noqa: E402
from flow.discretisation import forms, spaces  # noqa: E402
from flow.geometry import centreline, curving, tet10  # noqa: E402
from flow.meshing import mesh  # noqa: E402
from flow.physics import viscosity  # noqa: E402

pytestmark = pytest.mark.slow

DENSITY, VISCOSITY, GRAD_DIV, BACKFLOW = 1060.0, 0.004, 0.2, 0.5
SPEED, PRESSURE, WAVE = 0.1, 10.0, 1.2e3  # m/s, Pa, 1/m: a Reynolds number of 26 for a length of 1 mm
LENGTH, RADIUS = 2.4, 1.2  # mm
STATIONS = 0.5  # distance of the sections in radii, on a mesh of three rings
RINGS = (3, 6)
FORK = {"radius": 1.2, "side_radius": 0.8, "length": 4.0, "at": 1.5, "side_length": 2.6, "edge_mm": 0.8}  # mm
# The eight tetrahedra that a ten-node tetrahedron is cut into, as node numbers of geometry.tet10. Four lie at its
# corners. The other four lie round a diagonal of the octahedron in the middle.
CHILDREN = np.array([[0, 4, 6, 7], [4, 1, 5, 9], [6, 5, 2, 8], [7, 9, 8, 3]])
CHILDREN = np.concatenate([CHILDREN, [[4, 8, 5, 6], [4, 8, 6, 7], [4, 8, 7, 9], [4, 8, 9, 5]]])
FACE_CHILDREN = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])  # nodes 3, 4, 5: middles of edges 01, 12, 20


def _space(folder, rings):
    """LumenSpace of a swept mesh with `rings` rings; the distance of its sections goes with 1 / rings."""
    axis = tubes.arc(0.05)
    lumen = tubes.tube(LENGTH, lambda s: RADIUS, 0.3, axis)
    tree = centreline.Tree([tubes.centre_branch(LENGTH, lambda s: RADIUS, axis)])
    built, report = mesh.build(
        lumen, tree, 2.5, settings.make(stations_plain=STATIONS, stations_throat=STATIONS), rings, 3.0 / rings
    )
    assert report["swept"]["cells"] == report["cells"]
    return _written(built, folder / f"rings{rings}.msh")


def _written(built, path):
    """LumenSpace of a QuadraticMesh."""
    mesh.write(built, path)
    return spaces.read(path)


def _junction():
    """QuadraticMesh of a branch point. Its branches are too short to be swept, so all cells are gmsh's."""
    surface, branches = tubes.fork(**FORK)
    chosen = settings.make(outlet_clearance_diameters=0, inlet_clearance_diameters=0)
    built, report = mesh.build(surface, centreline.Tree(branches), 1.5, chosen)
    assert report["swept"]["cells"] == 0
    return built


def _cut(whole):
    """QuadraticMesh that has each cell of `whole` cut into eight; the curved shapes stay the same."""
    corners = np.concatenate([np.eye(4), 0.5 * (np.eye(4)[tet10.EDGES[:, 0]] + np.eye(4)[tet10.EDGES[:, 1]])])
    children = CHILDREN.copy()
    turned = np.linalg.det(corners[children]) < 0
    children[turned] = children[turned][:, [0, 2, 1, 3]]
    within = corners[children]  # barycentric coordinates of the children's corners
    between = 0.5 * (within[:, tet10.EDGES[:, 0]] + within[:, tet10.EDGES[:, 1]])
    places = np.einsum("kmn,tnd->tkmd", tet10.basis(between), whole.points[whole.tetrahedra])
    cells = whole.tetrahedra[:, children].reshape(-1, 4)
    faces = whole.triangles[:, FACE_CHILDREN].reshape(-1, 3)
    pairs = np.sort(cells[:, tet10.EDGES], axis=2).reshape(-1, 2)
    edges, first, of_cell = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    number = {tuple(pair): k for k, pair in enumerate(edges.tolist())}
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).tolist()
    of_face = np.array([[number[tuple(pair)] for pair in face] for face in sides])
    count = len(whole.points)
    points = np.concatenate([whole.points, places.reshape(-1, 3)[first]])
    cells = np.concatenate([cells, count + of_cell.reshape(-1, 6)], axis=1)
    triangles = np.concatenate([faces, count + of_face], axis=1)
    return curving.QuadraticMesh(points, cells, triangles, np.repeat(whole.region, 4), 0, 0)


def _exact(x):
    """The exact (u, p) at UFL coordinates, or at the points of an array (3, n)."""
    sin, cos, stack = (np.sin, np.cos, np.stack) if isinstance(x, np.ndarray) else (ufl.sin, ufl.cos, ufl.as_vector)
    a, b, c = WAVE * x[0], WAVE * x[1], WAVE * x[2]
    velocity = stack([SPEED * (sin(b) + cos(c)), SPEED * (sin(c) + cos(a)), SPEED * (sin(a) + cos(b))])
    return velocity, PRESSURE * (sin(a) * cos(b) + cos(c))


def _load(space, free):
    """Load vector: the strong form's residual at the exact solution, and its traction on the outlet `free`, if any."""
    u, p = _exact(ufl.SpatialCoordinate(space.mesh))
    force = DENSITY * ufl.dot(ufl.grad(u), u) - VISCOSITY * ufl.div(ufl.grad(u)) + ufl.grad(p)
    v, _ = ufl.TestFunctions(space.W)
    exactly = {"metadata": {"quadrature_degree": 8}}
    total = ufl.inner(force, v) * ufl.dx(space.mesh, **exactly)
    if free is not None:
        n = ufl.FacetNormal(space.mesh)
        inward = 0.5 * (ufl.dot(u, n) - abs(ufl.dot(u, n)))
        traction = VISCOSITY * ufl.dot(ufl.grad(u), n) - p * n - DENSITY * BACKFLOW * inward * u
        total += ufl.inner(traction, v) * space.ds(free, **exactly)
    return fem_petsc.assemble_vector(fem.form(total))


def _interpolant(space):
    """The exact solution interpolated in space.W."""
    exact = fem.Function(space.W)
    exact.sub(0).interpolate(lambda x: _exact(x)[0])
    exact.sub(1).interpolate(lambda x: _exact(x)[1])
    return exact


def _conditions(space, free):
    """Exact velocity on the boundary except the outlet `free`. Without a free outlet, also exact pressure at one node,
    because the pressure is else known only up to a constant."""
    exact, facets = _interpolant(space), space.facet_tags
    held = facets.indices if free is None else facets.indices[facets.values != free]
    boundary = fem.locate_dofs_topological(space.W.sub(0), 2, held)
    fixed = np.union1d(boundary, space.q_map[:1] if free is None else []).astype(np.int32)
    values = fem.Function(space.W)
    values.x.array[fixed] = exact.x.array[fixed]
    return [fem.dirichletbc(values, fixed)]


def _solved(space, free=None):
    """The discrete solution in space.W."""
    state = fem.Function(space.W)
    weak = forms.NavierStokes(space, state, DENSITY, viscosity.Newtonian(VISCOSITY), GRAD_DIV, BACKFLOW)
    prescribed.solve(weak, state, _conditions(space, free), _load(space, free))
    return state


def _errors(space, state):
    """L2 errors of velocity, of pressure up to a constant, and of the velocity's gradient."""
    (u, p), (u_exact, p_exact) = ufl.split(state), _exact(ufl.SpatialCoordinate(space.mesh))
    dx = ufl.dx(space.mesh, metadata={"quadrature_degree": 8})

    def integral(expression):
        return fem.assemble_scalar(fem.form(expression * dx))

    shift = integral(p - p_exact) / integral(fem.Constant(space.mesh, 1.0))
    bend = ufl.grad(u) - ufl.grad(u_exact)
    squares = ufl.inner(u - u_exact, u - u_exact), (p - p_exact - shift) ** 2, ufl.inner(bend, bend)
    return [float(np.sqrt(integral(square))) for square in squares]


def test_orders_of_velocity_and_pressure(tmp_path):
    coarse, fine = (_space(tmp_path, rings) for rings in RINGS)
    assert len(fine.nodes()[1]) == 8 * len(coarse.nodes()[1])  # rings and sections doubled
    errors = [_errors(space, _solved(space)) for space in (coarse, fine)]
    orders = np.log2(np.divide(*errors))
    print("errors", errors, "orders", orders)
    assert orders[0] > 2.95
    assert orders[1] > 1.95


def test_errors_at_a_branch_point_are_those_of_the_interpolant(tmp_path):
    """Solves on gmsh's cells, then with each cell cut into eight.

    The cut cells have a worse shape. The interpolant's error therefore falls by half an order less at this refinement,
    and catches up at the next. The ratio of the solution's error to the interpolant's must stay bounded.
    """
    whole, shares, gradients = _junction(), [], []
    for built in (whole, _cut(whole)):
        space = _written(built, tmp_path / "junction.msh")
        found = _errors(space, _solved(space, space.outlet_tags[0]))
        shares.append(np.divide(found, _errors(space, _interpolant(space))))
        gradients.append(found[2])
    print("errors over the interpolant's", shares, "gradient", gradients)
    for _, pressure, gradient in shares:
        # With a density that is 2 % wrong the pressure's ratio on the cut cells is .91.
        assert pressure < 0.75 and gradient < 1.8
    assert gradients[1] < 0.45 * gradients[0]

"""Manufactured solution on the curved tetrahedra of a bent tube through the weak form of flow.forms: orders of errors.

u = U (sin y + cos z, sin z + cos x, sin x + cos y), p = P (sin x cos y + cos z) with x, y, z in units of 1 / WAVE, so
that div u = 0; the load is the strong form's residual. The velocity is prescribed on the whole boundary, the pressure
at one corner.
"""

import pathlib
import sys

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow"), str(pathlib.Path(__file__).parent)]

import prescribed  # noqa: E402
import tubes  # noqa: E402
from flow import centreline, forms, mesh, settings, spaces, viscosity  # noqa: E402

DENSITY, VISCOSITY, GRAD_DIV, BACKFLOW = 1060.0, 0.004, 0.2, 0.5
SPEED, PRESSURE, WAVE = 0.1, 10.0, 1.2e3  # m/s, Pa, 1/m: Reynolds number 26 a mm
LENGTH, RADIUS = 2.4, 1.2  # mm
STATIONS = 0.5  # distance of the sections in radii, with three rings
RINGS = (3, 6)


def _space(folder, rings):
    """LumenSpace of a swept mesh with `rings` rings and sections in proportion."""
    axis = tubes.arc(0.05)
    lumen = tubes.tube(LENGTH, lambda s: RADIUS, 0.3, axis)
    tree = centreline.Tree([tubes.line(LENGTH, lambda s: RADIUS, axis)])
    built, report = mesh.build(
        lumen, tree, 2.5, settings.make(stations_plain=STATIONS, stations_throat=STATIONS), rings, 3.0 / rings
    )
    assert report["swept"]["cells"] == report["cells"]
    path = folder / f"rings{rings}.msh"
    mesh.write(built, path)
    return spaces.read(path)


def _exact(x):
    """(u, p) of UFL coordinates or, with numpy's functions, of an array (3, n)."""
    sin, cos, stack = (np.sin, np.cos, np.stack) if isinstance(x, np.ndarray) else (ufl.sin, ufl.cos, ufl.as_vector)
    a, b, c = WAVE * x[0], WAVE * x[1], WAVE * x[2]
    velocity = stack([SPEED * (sin(b) + cos(c)), SPEED * (sin(c) + cos(a)), SPEED * (sin(a) + cos(b))])
    return velocity, PRESSURE * (sin(a) * cos(b) + cos(c))


def _load(space):
    """Vector of the strong form's residual at the exact solution."""
    u, p = _exact(ufl.SpatialCoordinate(space.mesh))
    force = DENSITY * ufl.dot(ufl.grad(u), u) - VISCOSITY * ufl.div(ufl.grad(u)) + ufl.grad(p)
    v, _ = ufl.TestFunctions(space.W)
    return fem_petsc.assemble_vector(
        fem.form(ufl.inner(force, v) * ufl.dx(space.mesh, metadata={"quadrature_degree": 8}))
    )


def _conditions(space, state):
    """Exact velocity on the boundary and exact pressure at one node."""
    exact = fem.Function(space.W)
    exact.sub(0).interpolate(lambda x: _exact(x)[0])
    exact.sub(1).interpolate(lambda x: _exact(x)[1])
    boundary = fem.locate_dofs_topological(space.W.sub(0), 2, space.facets.indices)
    fixed = np.union1d(boundary, space.q_map[:1]).astype(np.int32)
    values = fem.Function(space.W)
    values.x.array[fixed] = exact.x.array[fixed]
    return [fem.dirichletbc(values, fixed)]


def _errors(space):
    """L2 errors of velocity and of pressure up to a constant, cells."""
    state = fem.Function(space.W)
    length = fem.Function(fem.FunctionSpace(space.mesh, ("DG", 0)))
    weak = forms.NavierStokes(space, state, DENSITY, viscosity.Newtonian(VISCOSITY), GRAD_DIV, BACKFLOW, length)
    prescribed.solve(weak, state, _conditions(space, state), _load(space))
    (u, p), (u_exact, p_exact) = ufl.split(state), _exact(ufl.SpatialCoordinate(space.mesh))
    dx = ufl.dx(space.mesh, metadata={"quadrature_degree": 8})

    def integral(expression):
        return fem.assemble_scalar(fem.form(expression * dx))

    volume = integral(fem.Constant(space.mesh, 1.0))
    shift = integral(p - p_exact) / volume
    velocity = np.sqrt(integral(ufl.inner(u - u_exact, u - u_exact)))
    return velocity, np.sqrt(integral((p - p_exact - shift) ** 2)), len(space.nodes()[1])


def test_orders_of_velocity_and_pressure(tmp_path):
    coarse, fine = (_errors(_space(tmp_path, rings)) for rings in RINGS)
    assert fine[2] == 8 * coarse[2]  # rings and sections doubled
    orders = [np.log2(coarse[k] / fine[k]) for k in range(2)]
    print("errors", coarse, fine, "orders", orders)
    assert orders[0] > 2.95
    assert orders[1] > 1.95

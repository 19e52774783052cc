"""Flow past a cylinder: DFG benchmark 2D-1 (Schaefer, Turek 1996), solved with the weak form of discretisation.forms.

The channel is 2.2 x .41, the cylinder has diameter .1 and its centre at (.2, .2). Density is 1, viscosity .001, and the
parabolic inflow has a mean of .2. This gives a Reynolds number of 20. Reference values are from featflow.de, benchmark
DFG 2D-1 (re20).
"""

import pathlib
import sys
import types

import numpy as np
import pytest
from dolfinx import fem

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

import prescribed  # noqa: E402
from flow.discretisation import compat, forms  # noqa: E402
from flow.physics import viscosity  # noqa: E402

pytestmark = pytest.mark.slow

DRAG, LIFT, PRESSURE_DROP = 5.57953523384, 0.010618948146, 0.11752016697
HEIGHT, CENTRE, RADIUS, MEAN = 0.41, 0.2, 0.05, 0.2
WALL, INLET, CYLINDER, OUTLET = 1, 2, 3, 12
DENSITY, VISCOSITY, GRAD_DIV, BACKFLOW = 1.0, 0.001, 0.05, 0.5


def _write_mesh(path, around, far):
    """Writes a mesh of quadratic triangles: `around` edges on the cylinder, edges of length `far` far downstream.

    Two of its nodes lie at the front and the back of the cylinder, where the pressure is read.
    """
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        gmsh.model.add("cylinder")
        geo, near = gmsh.model.geo, 2 * np.pi * RADIUS / around
        corners = [
            geo.addPoint(x, y, 0, size)
            for x, y, size in ((0, 0, 0.008), (2.2, 0, far), (2.2, 0.41, far), (0, 0.41, 0.008))
        ]
        centre = geo.addPoint(CENTRE, CENTRE, 0)
        turns = np.arange(4) * np.pi / 2
        rim = [geo.addPoint(CENTRE + RADIUS * np.cos(t), CENTRE + RADIUS * np.sin(t), 0, near) for t in turns]
        sides = [geo.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
        arcs = [geo.addCircleArc(rim[k], centre, rim[(k + 1) % 4]) for k in range(4)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(sides), geo.addCurveLoop(arcs)])
        geo.synchronize()
        for tag, curves in ((WALL, [sides[0], sides[2]]), (INLET, [sides[3]]), (OUTLET, [sides[1]]), (CYLINDER, arcs)):
            gmsh.model.addPhysicalGroup(1, curves, tag)
        gmsh.model.addPhysicalGroup(2, [surface], 1)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def _space(path):
    """A stand-in for LumenSpace with the attributes that the residual and tangent of discretisation.forms use."""
    mesh, facets = compat.read_gmsh(path, dimension=2)
    W = compat.function_space(
        mesh, compat.mixed_element(compat.vector_element(mesh, 2), compat.scalar_element(mesh, 1))
    )
    return types.SimpleNamespace(mesh=mesh, facet_tags=facets, W=W, outlet_tags=[OUTLET])


def _conditions(space):
    V, _ = space.W.sub(0).collapse()
    profile = fem.Function(V)
    profile.interpolate(lambda x: np.stack([6 * MEAN * x[1] * (HEIGHT - x[1]) / HEIGHT**2, 0 * x[0]]))

    def condition(value, tag):
        dofs = fem.locate_dofs_topological((space.W.sub(0), V), 1, space.facet_tags.find(tag))
        return fem.dirichletbc(value, dofs, space.W.sub(0))

    return [condition(profile, INLET), condition(fem.Function(V), WALL), condition(fem.Function(V), CYLINDER)]


def _force(space, residual, direction):
    """Force of the fluid on the cylinder: minus the sum of the residual's entries at the cylinder's dofs."""
    facets = space.facet_tags.find(CYLINDER)
    dofs = fem.locate_dofs_topological(space.W.sub(0).sub(direction), 1, facets)
    return -residual.array[np.unique(dofs)].sum()


def _pressure(space, state, x):
    Q, dofs = space.W.sub(1).collapse()
    distance = np.linalg.norm(Q.tabulate_dof_coordinates()[:, :2] - [x, CENTRE], axis=1)
    assert distance.min() < 1e-9
    return state.x.array[np.asarray(dofs)[distance.argmin()]]


def test_drag_lift_and_pressure_drop(tmp_path):
    _write_mesh(tmp_path / "cylinder.msh", 192, 0.025)
    space = _space(tmp_path / "cylinder.msh")
    state = fem.Function(space.W)
    weak = forms.NavierStokes(space, state, DENSITY, viscosity.Newtonian(VISCOSITY), GRAD_DIV, BACKFLOW)
    residual = prescribed.solve(weak, state, _conditions(space))
    scale = 2 / (DENSITY * MEAN**2 * 2 * RADIUS)
    drag, lift = (scale * _force(space, residual, k) for k in range(2))
    drop = _pressure(space, state, CENTRE - RADIUS) - _pressure(space, state, CENTRE + RADIUS)
    print("drag", drag, "lift", lift, "pressure drop", drop, "dofs", len(state.x.array))
    assert drag == pytest.approx(DRAG, rel=1e-3)
    assert lift == pytest.approx(LIFT, rel=1e-3)
    assert drop == pytest.approx(PRESSURE_DROP, rel=1e-3)

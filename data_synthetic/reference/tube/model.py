"""A stretch of the vessel as a solid in three dimensions, with the tissues, support and device laws of the slices."""

import basix
import numpy as np
import ufl
from dolfinx import fem

from common import fenicsx

from ..solid import laws
from ..solid.load_stepping import LoadSteppedModel
from .mesh import ENDS, LUMEN, OUTSIDE

DEVICE_POSITIONS = ("balloon_centre", "balloon_half_length", "balloon_shoulder", "stent_start", "stent_end")
SHIFT_SHARE = "shift_share"  # share of the devices' next sideways shift that is done
ROLLER_MPA_PER_MM = 1e5  # stiffness that holds the end faces along the axis, so that they stay in their planes


class TubeModel(LoadSteppedModel):
    """Solid model of hexahedra of degree 2 in displacements. The volumetric part is integrated with 2 x 2 x 2 points.

    tube: Tube. axis: Curve. material(s, theta, radius): function of (n,) arrays that returns (share of plaque, shear,
    yield, hardening in MPa). settings: section `reference`.

    Besides LOAD_NAMES the loads have DEVICE_POSITIONS (mm), the places of balloon and stent. The stent acts on the
    material points of its span. The devices lie on the lumen's axis at rest, unless `shift_devices` moves them. A
    point's distance from them and its arc length are measured in the frame that its section has at rest.
    radial_support: the support outside resists radial motion only, and the end faces are held fast. Without it the
    support resists any motion, and the end faces may slide in their planes.
    """

    plastic_size = 6
    kind = "solid in three dimensions"
    remedy = "more elements, a smaller radius_step_mm, or a softer plan"

    def __init__(self, tube, axis, material, settings, radial_support=False):
        self.tube, mesh = tube, tube.mesh
        self._space = fenicsx.function_space(mesh, fenicsx.lagrange("hexahedron", 2, 3))
        scalar = fenicsx.function_space(mesh, fenicsx.lagrange("hexahedron", 2))
        self._node = tube.find_nodes(self._space.tabulate_dof_coordinates())
        self._scalar_node = tube.find_nodes(scalar.tabulate_dof_coordinates())
        self.u = fem.Function(self._space)
        self._create_loads(mesh, (*DEVICE_POSITIONS, SHIFT_SHARE))
        self.set_loads({"balloon_shoulder": 1.0})
        self._stent_radius = fem.Function(scalar)
        self._plastic, self._strain, self._material = (self._quadrature_function(mesh, n) for n in (6, 1, 4))
        points, _ = basix.make_quadrature(basix.CellType.hexahedron, laws.DEVIATORIC_DEGREE)
        self._cells = np.arange(mesh.topology.index_map(3).size_local, dtype=np.int32)
        chart = self._nodal_function(tube.section_coordinates_mm)
        self._set_rest_state(fem.Expression(chart, points), material)
        self._compile(points, chart, axis, settings, radial_support)

    def _nodal_function(self, values):
        """fem.Function of degree 2 that has `values` (nodes, 3) at the nodes."""
        found = fem.Function(self._space)
        found.x.array[:] = values[self._node].ravel()
        return found

    def _set_rest_state(self, chart, material):
        """Sets the material constants and the unloaded state at the quadrature points."""
        s, a, b = fenicsx.expression_values(chart, self.tube.mesh, self._cells).reshape(-1, 3).T
        self._material.x.array[:] = np.stack(material(s, np.arctan2(b, a), np.hypot(a, b)), axis=1).ravel()
        self._plastic.x.array[:] = np.tile([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], len(s))

    def _compile(self, points, chart, axis, settings, radial_support):
        mesh, u, v = self.tube.mesh, self.u, ufl.TestFunction(self._space)
        f = ufl.Identity(3) + ufl.grad(u)
        share, shear, yields, hardening = (self._material[i] for i in range(4))
        plastic = laws.full_tensor(self._plastic)
        stress, plastic, strain = laws.plaque_return(f, plastic, self._strain, shear, yields, hardening)
        c10, c20 = (fem.Constant(mesh, float(settings[f"wall_{name}_mpa"])) for name in ("c10", "c20"))
        deviatoric = share * stress + (1 - share) * laws.wall_stress(f, c10, c20)
        six = [plastic[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        self._update = fem.Expression(ufl.as_vector([*six, strain]), points)
        bulk = fem.Constant(mesh, float(settings["bulk_modulus_mpa"]))
        support = fem.Constant(mesh, float(settings["support_mpa_per_mm"]))
        virtual = ufl.grad(v) * ufl.inv(f)
        full = ufl.dx(domain=mesh, metadata={"quadrature_degree": laws.DEVIATORIC_DEGREE})
        reduced = ufl.dx(domain=mesh, metadata={"quadrature_degree": laws.VOLUMETRIC_DEGREE})
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=self.tube.facet_tags, metadata={"quadrature_degree": 5})
        c = self._constants
        self._shift, self._next_shift = (self._nodal_function(np.zeros_like(self.tube.points_mm)) for _ in range(2))
        centre = self._nodal_function(axis.point(self.tube.section_coordinates_mm[:, 0]))
        centre = centre + self._shift + c[SHIFT_SHARE] * (self._next_shift - self._shift)
        tangent = self._nodal_function(axis.frame(self.tube.section_coordinates_mm[:, 0])[0])
        at = ufl.SpatialCoordinate(mesh) + u - centre
        along = ufl.inner(at, tangent)
        across = at - along * tangent
        distance = ufl.sqrt(ufl.inner(across, across))
        covered = ufl.And(ufl.gt(chart[0], c["stent_start"]), ufl.lt(chart[0], c["stent_end"]))
        beyond = ufl.max_value(abs(chart[0] + along - c["balloon_centre"]) - c["balloon_half_length"], 0.0)
        tapered = c["balloon_radius"] * ufl.max_value(1 - beyond / c["balloon_shoulder"], 0.0)
        radii = {"balloon": tapered, "stent": self._stent_radius}
        shares = {"balloon": 1.0, "stent": ufl.conditional(covered, 1.0, 0.0)}
        load = c["pressure"]
        for name, radius in radii.items():
            law = laws.device_pressure(distance, radius, c[f"{name}_stiffness"], c[f"{name}_cap"])
            load = load + shares[name] * c[f"{name}_share"] * law
        normal = ufl.FacetNormal(mesh)
        contact = load * ufl.inner(ufl.det(f) * ufl.inv(f).T * normal, v) * ds(LUMEN)
        supported, held = (normal, None) if radial_support else (None, tangent)
        self._contact = fenicsx.form(contact)
        self._set_up_solver(
            ufl.inner(deviatoric, virtual) * full
            + laws.volumetric_stress(f, bulk) * ufl.tr(virtual) * reduced
            + contact
            + support * _along(u, v, supported) * ds(OUTSIDE)
            + ROLLER_MPA_PER_MM * _along(u, v, held) * ds(ENDS)
        )
        self._solver.getPC().setFactorSolverType("mumps")

    def set_stent_radius(self, radius_mm):
        """Sets the radius (stations,) in mm that the stent holds at each station."""
        per_node = np.repeat(radius_mm, len(self.tube.points_mm) // len(radius_mm))
        self._stent_radius.x.array[:] = per_node[self._scalar_node]

    def shift_devices(self, shift_mm, where):
        """Moves the devices sideways to shift_mm (stations, 3) from the axis at rest, and solves. where: for messages.

        Raises ComputationError if that does not converge.
        """
        per_node = np.repeat(shift_mm, len(self.tube.points_mm) // len(shift_mm), axis=0)
        self._next_shift.x.array[:] = per_node[self._node].ravel()
        self.advance({SHIFT_SHARE: 1.0}, where)
        self._shift.x.array[:] = self._next_shift.x.array
        self.set_loads({SHIFT_SHARE: 0.0})

    def device_forces(self):
        """Forces (stations, 3) in N of the wall on the devices, lumped to the stations of nodes."""
        forces = np.empty_like(self.tube.points_mm)
        forces[self._node] = fem.assemble_vector(self._contact).array.reshape(-1, 3)
        return forces.reshape(len(self.tube.station_s_mm), -1, 3).sum(axis=1)

    def displacement(self):
        """Displacement (nodes, 3) in mm."""
        moved = np.empty_like(self.tube.points_mm)
        moved[self._node] = self.u.x.array.reshape(-1, 3)
        return moved

    def degrees_of_freedom(self):
        """Number of unknowns."""
        return len(self.u.x.array)


def _along(u, v, direction):
    """The product of two vectors, or of their parts along a direction if it is given."""
    return ufl.inner(u, v) if direction is None else ufl.inner(u, direction) * ufl.inner(v, direction)

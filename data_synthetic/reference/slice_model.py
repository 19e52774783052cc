"""One cross-section of the vessel in plane strain: solid, outer support, device pressure; loaded step by step."""

import basix
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from common import fenicsx
from common.errors import ComputationError

from . import solid
from .slice_mesh import LUMEN, OUTSIDE, Annulus

LOADS = ("balloon_radius", "balloon_stiffness", "balloon_cap", "balloon_share") + (
    "stent_radius",
    "stent_stiffness",
    "stent_cap",
    "stent_share",
    "pressure",
)
MAX_ITERATIONS = 14
CUTS = 7


class SliceModel:
    """Reusable model: compiled once, then placed on one slice after another.

    Loads (a dict of LOADS): two device laws, each with a share of 0 ... 1, and a plain pressure (MPa), for tests.
    """

    def __init__(self, around, through, wall_c10_mpa, wall_c20_mpa, bulk_modulus_mpa, support_mpa_per_mm):
        self.annulus = Annulus(around, through)
        mesh = self.annulus.mesh
        self._space = fem.FunctionSpace(mesh, ufl.VectorElement("Lagrange", mesh.ufl_cell(), 2))
        self.u = fem.Function(self._space)
        cell = mesh.ufl_cell()

        def at_points(size):
            kind = ufl.VectorElement if size > 1 else ufl.FiniteElement
            extra = {"dim": size} if size > 1 else {}
            element = kind("Quadrature", cell, degree=solid.DEVIATORIC_DEGREE, quad_scheme="default", **extra)
            return fem.Function(fem.FunctionSpace(mesh, element))

        self._plastic, self._strain, self._material = at_points(4), at_points(1), at_points(4)
        self._constants = {name: fem.Constant(mesh, 0.0) for name in LOADS}
        c10, c20 = fem.Constant(mesh, float(wall_c10_mpa)), fem.Constant(mesh, float(wall_c20_mpa))
        bulk, support = fem.Constant(mesh, float(bulk_modulus_mpa)), fem.Constant(mesh, float(support_mpa_per_mm))
        points, _ = basix.make_quadrature(basix.CellType.quadrilateral, solid.DEVIATORIC_DEGREE)
        self._points = points
        self._cells = np.arange(mesh.topology.index_map(2).size_local, dtype=np.int32)
        x = ufl.SpatialCoordinate(mesh)
        self._where = fem.Expression(x, points)

        f = solid.deformation_gradient(self.u)
        share, shear, yields, hardening = (self._material[i] for i in range(4))
        stress, plastic, strain = solid.plaque_return(
            f, solid.plane_tensor(self._plastic), self._strain, shear, yields, hardening
        )
        deviatoric = share * stress + (1 - share) * solid.wall_stress(f, c10, c20)
        self._update = fem.Expression(
            ufl.as_vector([plastic[0, 0], plastic[1, 1], plastic[2, 2], plastic[0, 1], strain]), points
        )
        v = ufl.TestFunction(self._space)
        gv = ufl.grad(v)
        virtual = ufl.as_tensor([[gv[0, 0], gv[0, 1], 0], [gv[1, 0], gv[1, 1], 0], [0, 0, 0]]) * ufl.inv(f)
        full = ufl.dx(domain=mesh, metadata={"quadrature_degree": solid.DEVIATORIC_DEGREE})
        reduced = ufl.dx(domain=mesh, metadata={"quadrature_degree": solid.VOLUMETRIC_DEGREE})
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=self.annulus.facet_tags, metadata={"quadrature_degree": 5})
        g = ufl.grad(self.u)
        cofactor = ufl.as_tensor([[1 + g[1, 1], -g[1, 0]], [-g[0, 1], 1 + g[0, 0]]])
        area_normal = cofactor * ufl.FacetNormal(mesh)
        at = x + self.u
        distance = ufl.sqrt(ufl.inner(at, at))
        load = self._constants["pressure"]
        for device in ("balloon", "stent"):
            c = {name: self._constants[f"{device}_{name}"] for name in ("radius", "stiffness", "cap", "share")}
            load = load + c["share"] * solid.device_pressure(distance, c["radius"], c["stiffness"], c["cap"])
        residual = (
            ufl.inner(deviatoric, virtual) * full
            + solid.volumetric_stress(f, bulk) * ufl.tr(virtual) * reduced
            + load * ufl.inner(area_normal, v) * ds(LUMEN)
            + support * ufl.inner(self.u, v) * ds(OUTSIDE)
        )
        self._residual = fenicsx.form(residual)
        self._tangent = fenicsx.form(ufl.derivative(residual, self.u))
        self._matrix = fem.petsc.create_matrix(self._tangent)
        self._vector = fem.petsc.create_vector(self._residual)
        self._solver = PETSc.KSP().create(PETSc.COMM_SELF)
        self._solver.setType("preonly")
        self._solver.getPC().setType("lu")
        self._solver.setOperators(self._matrix)
        self._area = fenicsx.form(-0.5 * ufl.inner(at, area_normal) * ds(LUMEN))
        self._lumen = self._lumen_dofs()
        self.iterations = 0

    def _lumen_dofs(self):
        """Dofs of the lumen's nodes in the order of annulus.theta_rad."""
        facets = self.annulus.facet_tags.find(LUMEN)
        dofs = fem.locate_dofs_topological(self._space, 1, facets)
        x = self._space.tabulate_dof_coordinates()[dofs]
        return dofs[np.argsort(np.mod(np.arctan2(x[:, 1], x[:, 0]) + 1e-9, 2 * np.pi))]

    def place(self, inner_mm, outer_mm, material):
        """Starts a new slice, at rest.

        inner_mm, outer_mm: radii (2 around,) at annulus.theta_rad. material(theta, radius): from (n,) arrays of rad and
        mm to (share of plaque, shear MPa, yield MPa, hardening MPa), each (n,).
        """
        self.annulus.place(inner_mm, outer_mm)
        x = self._where.eval(self._cells).reshape(-1, 2)
        values = np.stack(material(np.arctan2(x[:, 1], x[:, 0]), np.hypot(x[:, 0], x[:, 1])), axis=1)
        self._material.x.array[:] = values.ravel()
        self._plastic.x.array[:] = np.tile([1.0, 1.0, 1.0, 0.0], len(x))
        self._strain.x.array[:] = 0
        self.u.x.array[:] = 0
        self.iterations = 0

    def set_loads(self, loads):
        """Sets the constants named in `loads` (keys from LOADS)."""
        for name, value in loads.items():
            self._constants[name].value = value

    def loads(self):
        """The present loads."""
        return {name: float(constant.value) for name, constant in self._constants.items()}

    def lumen_displacement(self):
        """Displacements (2 around, 2) in mm of the lumen's nodes at annulus.theta_rad."""
        return self.u.x.array.reshape(-1, 2)[self._lumen].copy()

    def lumen_position(self):
        """Positions (2 around, 2) in mm of the lumen's nodes."""
        return self._space.tabulate_dof_coordinates()[self._lumen, :2] + self.lumen_displacement()

    def lumen_area(self):
        """Area in mm2 that the deformed lumen encloses."""
        return fem.assemble_scalar(self._area)

    def _newton(self):
        """Newton from the present displacement; whether it converged. Leaves the last iterate in u."""
        scale = 1.0
        for iteration in range(MAX_ITERATIONS):
            with self._vector.localForm() as local:
                local.set(0)
            fem.petsc.assemble_vector(self._vector, self._residual)
            norm = self._vector.norm()
            if not np.isfinite(norm) or norm > 1e4:
                return False
            if iteration > 0 and norm < 1e-9 * scale + 1e-10:
                return True
            scale = max(scale, norm)
            self._matrix.zeroEntries()
            fem.petsc.assemble_matrix(self._matrix, self._tangent)
            self._matrix.assemble()
            step = self._vector.duplicate()
            self._solver.solve(self._vector, step)
            change = np.abs(step.array).max()
            self.iterations += 1
            # Far steps overshoot the contact; the direction is kept.
            self.u.x.array[:] -= step.array * min(1.0, 0.25 / max(change, 1e-30))
            step.destroy()
            if change < 1e-8:
                return True
        return False

    def _commit(self):
        """Makes the plastic state at the present displacement the start of the next step."""
        values = self._update.eval(self._cells).reshape(-1, 5)
        self._plastic.x.array[:] = values[:, :4].ravel()
        self._strain.x.array[:] = values[:, 4]

    def advance(self, target, name="load"):
        """Moves the loads to `target` (dict) in one step, halved where Newton fails.

        Raises ComputationError if a step cut CUTS times still fails.
        """
        start = self.loads()
        goal = {**start, **target}
        done, step = 0.0, 1.0
        while done < 1:
            step = min(step, 1 - done)
            before = self.u.x.array.copy()
            share = done + step
            self.set_loads({key: start[key] + share * (goal[key] - start[key]) for key in goal})
            if self._newton():
                self._commit()
                done, step = share, 2 * step
            else:
                self.u.x.array[:] = before
                step *= 0.5
                if step < 0.5**CUTS:
                    raise ComputationError(
                        "the plane-strain slice did not converge",
                        name,
                        f"stopped at {100 * done:.1f} % of the step to {target}",
                        "a finer slice (elements_around, elements_through), or a softer plan",
                    )

"""One cross-section of the vessel in plane strain: solid, outer support, device pressure; loaded step by step."""

import basix
import numpy as np
import ufl
from dolfinx import fem

from common import fenicsx

from ..solid import laws
from ..solid.load_stepping import LoadSteppedModel
from ..straightening import beams
from .mesh import LUMEN, OUTSIDE, Annulus
from .wall_bending import WallBending

SUPPORT_SHIFT = ("support_shift_a", "support_shift_b")  # shift of the tissue around, in mm along x and y


class SliceModel(LoadSteppedModel):
    """Model of a slice that is compiled once, then placed on one slice after another.

    Its loads are a dict of LOAD_NAMES and SUPPORT_SHIFT. They are the parameters of the pressure laws of balloon and
    stent, a uniform pressure (MPa) for tests, and a shift of the tissue around, which presses the section against its
    device. Each law is multiplied by its share, from 0 to 1.
    """

    def __init__(self, around, through, wall_c10_mpa, wall_c20_mpa, bulk_modulus_mpa, support_mpa_per_mm):
        self.annulus = Annulus(around, through)
        mesh = self.annulus.mesh
        self._space = fenicsx.function_space(mesh, fenicsx.lagrange("quadrilateral", 2, 2))
        self.u = fem.Function(self._space)
        self._plastic, self._strain, self._material = (self._quadrature_function(mesh, n) for n in (4, 1, 4))
        self._create_loads(mesh, SUPPORT_SHIFT)
        c10, c20 = fem.Constant(mesh, float(wall_c10_mpa)), fem.Constant(mesh, float(wall_c20_mpa))
        bulk, support = fem.Constant(mesh, float(bulk_modulus_mpa)), fem.Constant(mesh, float(support_mpa_per_mm))
        self.support_mpa_per_mm = float(support_mpa_per_mm)
        points, _ = basix.make_quadrature(basix.CellType.quadrilateral, laws.DEVIATORIC_DEGREE)
        self._points = points
        self._cells = np.arange(mesh.topology.index_map(2).size_local, dtype=np.int32)
        x = ufl.SpatialCoordinate(mesh)
        self._position_expression = fem.Expression(x, points)

        f = laws.deformation_gradient(self.u)
        share, shear, yields, hardening = (self._material[i] for i in range(4))
        stress, plastic, strain = laws.plaque_return(
            f, laws.plane_tensor(self._plastic), self._strain, shear, yields, hardening
        )
        deviatoric = share * stress + (1 - share) * laws.wall_stress(f, c10, c20)
        self._update = fem.Expression(
            ufl.as_vector([plastic[0, 0], plastic[1, 1], plastic[2, 2], plastic[0, 1], strain]), points
        )
        v = ufl.TestFunction(self._space)
        gv = ufl.grad(v)
        virtual = ufl.as_tensor([[gv[0, 0], gv[0, 1], 0], [gv[1, 0], gv[1, 1], 0], [0, 0, 0]]) * ufl.inv(f)
        full = ufl.dx(domain=mesh, metadata={"quadrature_degree": laws.DEVIATORIC_DEGREE})
        reduced = ufl.dx(domain=mesh, metadata={"quadrature_degree": laws.VOLUMETRIC_DEGREE})
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=self.annulus.facet_tags, metadata={"quadrature_degree": 5})
        g = ufl.grad(self.u)
        cofactor = ufl.as_tensor([[1 + g[1, 1], -g[1, 0]], [-g[0, 1], 1 + g[0, 0]]])
        area_normal = cofactor * ufl.FacetNormal(mesh)
        at = x + self.u
        distance = ufl.sqrt(ufl.inner(at, at))
        load = self._constants["pressure"]
        for device in ("balloon", "stent"):
            c = {name: self._constants[f"{device}_{name}"] for name in ("radius", "stiffness", "cap", "share")}
            load = load + c["share"] * laws.device_pressure(distance, c["radius"], c["stiffness"], c["cap"])
        residual = (
            ufl.inner(deviatoric, virtual) * full
            + laws.volumetric_stress(f, bulk) * ufl.tr(virtual) * reduced
            + load * ufl.inner(area_normal, v) * ds(LUMEN)
            + support * ufl.inner(self.u - ufl.as_vector([self._constants[n] for n in SUPPORT_SHIFT]), v) * ds(OUTSIDE)
        )
        self._set_up_solver(residual)
        self._area = fenicsx.form(-0.5 * ufl.inner(at, area_normal) * ds(LUMEN))
        self._wall_area = fenicsx.form(ufl.det(f) * full)
        self._lumen = self._lumen_dofs()
        self._outside = [fenicsx.form(part * ds(OUTSIDE)) for part in (fem.Constant(mesh, 1.0), self.u[0], self.u[1])]
        first = ufl.tr(laws.isochoric_left_cauchy_green(f)) - 3
        modulus = ufl.det(f) * (share * shear + (1 - share) * 2 * (c10 + 2 * c20 * first))
        self._shear_moments = [fenicsx.form(modulus * w * full) for w in (1.0, at[0], at[1], ufl.inner(at, at))]
        self._wall_bending = WallBending(mesh, self.u, modulus, ufl.inv(ufl.Identity(2) + g), full)

    def _lumen_dofs(self):
        """Numbers of the lumen's nodes in the displacement space, in the order of annulus.theta_rad."""
        facets = self.annulus.facet_tags.find(LUMEN)
        dofs = fem.locate_dofs_topological(self._space, 1, facets)
        x = self._space.tabulate_dof_coordinates()[dofs]
        return dofs[np.argsort(np.mod(np.arctan2(x[:, 1], x[:, 0]) + 1e-9, 2 * np.pi))]

    def place(self, inner_mm, outer_mm, material):
        """Starts a new slice, at rest.

        inner_mm, outer_mm (2 around,): radii at annulus.theta_rad. material(theta, radius): function that takes (n,)
        arrays in rad and mm. It returns (share of plaque, shear MPa, yield MPa, hardening MPa), each (n,).
        """
        self.annulus.place(inner_mm, outer_mm)
        x = fenicsx.expression_values(self._position_expression, self.annulus.mesh, self._cells).reshape(-1, 2)
        values = np.stack(material(np.arctan2(x[:, 1], x[:, 0]), np.hypot(x[:, 0], x[:, 1])), axis=1)
        self._material.x.array[:] = values.ravel()
        self._plastic.x.array[:] = np.tile([1.0, 1.0, 1.0, 0.0], len(x))
        self._strain.x.array[:] = 0
        self.u.x.array[:] = 0
        self.set_loads(dict.fromkeys(SUPPORT_SHIFT, 0.0))
        self.restart()

    def state(self):
        """The loads, displacement and plastic state, for `restore`."""
        return self.loads(), [function.x.array.copy() for function in (self.u, self._plastic, self._strain)]

    def restore(self, state):
        """Goes back to a `state` of the section that is placed now."""
        self.set_loads(state[0])
        for function, values in zip((self.u, self._plastic, self._strain), state[1]):
            function.x.array[:] = values
        self.restart()

    def lumen_displacement(self):
        """Displacements (2 around, 2) in mm of the lumen's nodes at annulus.theta_rad."""
        return self.u.x.array.reshape(-1, 2)[self._lumen].copy()

    def lumen_position(self):
        """Positions (2 around, 2) in mm of the lumen's nodes."""
        return self._space.tabulate_dof_coordinates()[self._lumen, :2] + self.lumen_displacement()

    def lumen_area(self):
        """Area in mm2 that the deformed lumen encloses."""
        return fem.assemble_scalar(self._area)

    def lumen_centre(self):
        """Centroid (2,) in mm of the area that the deformed lumen encloses."""
        here = self.lumen_position()
        following = np.roll(here, -1, axis=0)
        twice = here[:, 0] * following[:, 1] - following[:, 0] * here[:, 1]
        return ((here + following) * twice[:, None]).sum(axis=0) / (3 * twice.sum())

    def outside_shift(self):
        """Mean displacement (2,) in mm of the outside."""
        length, *moved = (fem.assemble_scalar(form) for form in self._outside)
        return np.array(moved) / length

    def support_n_per_mm2(self):
        """Force per length of the vessel by which the tissue around resists a shift of the outside by 1 mm."""
        return self.support_mpa_per_mm * fem.assemble_scalar(self._outside[0])

    def beam_stiffness(self):
        """(E I in N mm2, shear stiffness in N) of the deformed section as a part of a beam.

        E = 3 G, with the plaque's elastic G, since a bent vessel strains across the direction in which plaque yields.
        The wall's G is that of its Yeoh law at its present first invariant. E I is the mean over all directions of
        bending. A part of the section bears shear, as in a tube with the same areas inside and of the wall.
        """
        stiffness, a, b, polar = (fem.assemble_scalar(form) for form in self._shear_moments)
        bending = 1.5 * (polar - (a**2 + b**2) / stiffness)
        inside = self.lumen_area()
        return bending, beams.shear_share(inside / (inside + fem.assemble_scalar(self._wall_area))) * stiffness

    def displacement(self):
        """The displacement in mm of the whole section."""
        return self.u.x.array.copy()

    def wall_bending(self, change, outside_shift_mm):
        """(following, stiffness in N mm2) as `WallBending` gives them for the section as it is now.

        change: of `displacement()`, by which the outside moved by outside_shift_mm (2,) on average and the stent not at
        all. This is an offset of the stent by -outside_shift_mm, seen from the outside.
        """
        size = np.linalg.norm(outside_shift_mm)
        shape = (change.reshape(-1, 2) - outside_shift_mm) / size
        self._wall_bending.shape.x.array[:] = shape.ravel()
        return self._wall_bending.measure(-outside_shift_mm / size)

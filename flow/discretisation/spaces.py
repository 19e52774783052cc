"""Taylor-Hood space on a lumen mesh: velocity P2 and pressure P1, the boundaries' dofs, and the inlet's profile.

errors.error_field also uses the pair P3 and P2 on the same mesh.
"""

import functools

import numpy as np
import scipy.sparse.linalg
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from common.errors import InputError
from flow.discretisation import compat
from flow.geometry import locate, tet10
from flow.geometry.tags import PHYSICAL_INLET, PHYSICAL_OUTLET_BASE, PHYSICAL_WALL
from flow.geometry.tet10 import LEAST_JACOBIAN_RATIO, count_overlapping
from flow.physics.units import M_PER_MM

# An edge is straight if its middle node is nearer to the middle of its ends than this share of its length.
STRAIGHT_TOLERANCE = 1e-6


class LumenSpace:
    """A mesh in metres with its facet tags and the function spaces on it.

    W: velocity and pressure; V, Q: its two parts; v_map, q_map: numbers in W of their dofs. outlet_tags: physical tags
    of the outlets, ascending. wall_dofs, inlet_dofs: velocity dofs in W on these boundaries, the inlet's without its
    rim; free_dofs: all other dofs of W. degree: polynomial degree of the velocity elements; `nodes`, `nodal_pressure`
    and `corner_values` need degree 2.
    """

    def __init__(self, mesh, facets, where="mesh", degree=2):
        self.mesh, self.facet_tags, self.degree = mesh, facets, degree
        present = set(np.unique(facets.values).tolist()) if facets is not None else set()
        self.outlet_tags = sorted(tag for tag in present if tag > PHYSICAL_OUTLET_BASE)
        if not {PHYSICAL_WALL, PHYSICAL_INLET} <= present or not self.outlet_tags:
            raise InputError(
                "mesh lacks physical groups", where, sorted(present), "wall 1, inlet 2 and outlets 12.. are needed"
            )
        self.ds = ufl.Measure("ds", domain=mesh, subdomain_data=facets)
        elements = compat.vector_element(mesh, degree), compat.scalar_element(mesh, degree - 1)
        self.W = compat.function_space(mesh, compat.mixed_element(*elements))
        self.V, self.v_map = compat.subspace(self.W, 0, elements[0])
        self.Q, self.q_map = compat.subspace(self.W, 1, elements[1])
        self.wall_dofs = self._velocity_dofs(PHYSICAL_WALL)
        self.inlet_dofs = np.setdiff1d(self._velocity_dofs(PHYSICAL_INLET), self.wall_dofs)
        size = self.W.dofmap.index_map.size_local * self.W.dofmap.index_map_bs
        self.free_dofs = np.setdiff1d(np.arange(size), np.concatenate([self.wall_dofs, self.inlet_dofs])).astype(
            np.int32
        )
        if self.free_dofs.size == 0 or self.inlet_dofs.size == 0:
            raise InputError("inlet has no node inside its rim", where, len(self.inlet_dofs), "use a finer mesh")

    @property
    def dofs(self):
        """Number of dofs of velocity and pressure."""
        return self.W.dofmap.index_map.size_global * self.W.dofmap.index_map_bs

    def _velocity_dofs(self, tag):
        """Velocity dofs (n,) in W on the boundary with a physical tag."""
        facets = self.facet_tags.indices[self.facet_tags.values == tag]
        return np.unique(fem.locate_dofs_topological(self.W.sub(0), 2, facets))

    def area(self, tag):
        """Area in m2 of the boundary with a physical tag."""
        one = fem.Constant(self.mesh, PETSc.ScalarType(1.0))
        return float(np.real(fem.assemble_scalar(compat.form(one * self.ds(tag)))))

    def centre(self, tag):
        """Mean position (3,) in m of the velocity nodes on the boundary with a physical tag."""
        facets = self.facet_tags.indices[self.facet_tags.values == tag]
        return self.V.tabulate_dof_coordinates()[fem.locate_dofs_topological(self.V, 2, facets)].mean(axis=0)

    def flux_vector(self, tag):
        """Values (n,) over W whose scalar product with a state is the outflow in m3/s through the boundary with a tag.

        They are the integrals of v.n over the boundary, v being a basis function.
        """
        v, _ = ufl.TestFunctions(self.W)
        n = ufl.FacetNormal(self.mesh)
        return compat.assemble(compat.form(ufl.inner(n, v) * self.ds(tag)))

    def nodes(self):
        """(points (n, 3) in m, cells (t, 10)): the velocity nodes, and the cells with the node order of tet10."""
        if not hasattr(self, "_nodes"):
            self._nodes = compat.quadratic_cells(self.V)
        return self._nodes

    @functools.cached_property
    def locator(self):
        """The locate.Locator that finds the cells of points in m."""
        return locate.Locator(*self.nodes())

    def sampler(self, state):
        """locate.FieldSampler of the flow with values `state` (n,) over W."""
        return locate.FieldSampler(self.locator, state[self.v_map].reshape(-1, 3), self.nodal_pressure(state))

    def nodal_pressure(self, state):
        """Pressure (n,) in Pa at the velocity nodes; state: values over W.

        Pressure is linear in a cell, so at the middle node of an edge it is the mean of the edge's two corners.
        """
        points, cells = self.nodes()
        pressure = np.empty(len(points))
        corner = state[self.q_map][compat.cell_dofs(self.Q)]
        pressure[cells[:, :4]] = corner
        pressure[cells[:, 4:]] = corner[:, tet10.EDGES].mean(axis=2)
        return pressure

    def corner_values(self, nodal):
        """Values (m,) at the corners in the numbering of Q, from values `nodal` (n,) at the velocity nodes."""
        _, cells = self.nodes()
        values = np.empty(len(self.q_map))
        values[compat.cell_dofs(self.Q)] = nodal[cells[:, :4]]
        return values

    def wall_nodes(self):
        """Numbers of the velocity nodes on the wall."""
        return np.flatnonzero(np.isin(self.v_map.reshape(-1, 3)[:, 0], self.wall_dofs))

    def inlet_profile(self):
        """Velocity (n,) over W at the inlet for an inflow of 1 m3/s, with the fully developed profile of its shape.

        The velocity is -phi n times a factor, where -laplace(phi) = 1 on the cap and phi = 0 on its rim. On a disc this
        profile is parabolic.
        """
        S = compat.function_space(self.mesh, compat.scalar_element(self.mesh, self.degree))
        phi, psi = ufl.TrialFunction(S), ufl.TestFunction(S)
        n, ds = ufl.FacetNormal(self.mesh), self.ds(PHYSICAL_INLET)

        def tangential(f):
            return ufl.grad(f) - ufl.dot(ufl.grad(f), n) * n

        facets = {t: self.facet_tags.indices[self.facet_tags.values == t] for t in (PHYSICAL_INLET, PHYSICAL_WALL)}
        cap, wall = (fem.locate_dofs_topological(S, 2, facets[t]) for t in (PHYSICAL_INLET, PHYSICAL_WALL))
        inner = np.setdiff1d(cap, wall)
        A = compat.to_csr(fem_petsc.assemble_matrix(compat.form(ufl.inner(tangential(phi), tangential(psi)) * ds)))
        load = compat.assemble(compat.form(fem.Constant(self.mesh, PETSc.ScalarType(1.0)) * psi * ds))
        solution = np.zeros(len(load))
        solution[inner] = scipy.sparse.linalg.spsolve(A[inner][:, inner].tocsc(), load[inner])
        normal = [fem.assemble_scalar(compat.form(n[k] * ds)) for k in range(3)]
        # S and V number their nodes differently, but a cell's nodes have the same order in both
        at_nodes = np.empty(len(self.v_map) // 3)
        at_nodes[compat.cell_dofs(self.V)] = solution[compat.cell_dofs(S)]
        profile = np.zeros(self.dofs)
        profile[self.v_map] = -np.outer(at_nodes, normal).ravel()
        # the outflow of this profile through the inlet must be exactly -1 m3/s, whatever the quadrature error
        return profile / -(self.flux_vector(PHYSICAL_INLET) @ profile)


def read(path):
    """LumenSpace on the mesh of a gmsh file in mm. Raises InputError, also if the mesh is not good enough."""
    mesh, facets = compat.read_gmsh(path)
    if mesh.topology.dim != 3 or mesh.geometry.dim != 3:
        raise InputError("mesh is not three-dimensional", path, mesh.topology.dim, "make it with `flow mesh`")
    extent = np.ptp(mesh.geometry.x, axis=0).max()
    if not 1.0 < extent < 500.0:
        raise InputError("implausible mesh size", path, f"{extent:.4g}", "coordinates must be in mm")
    mesh.geometry.x[:] *= M_PER_MM
    space = LumenSpace(mesh, facets, path)
    _check_cells(space, path)
    _check_curved(space, path)
    return space


def check_coarser(paths):
    """Raises InputError unless each mesh file of `paths`, coarse first, has more cells than the one before."""
    cells = [compat.count_cells(path) for path in paths] if len(paths) > 1 else []
    for coarse, few, fine, many in zip(paths, cells, paths[1:], cells[1:]):
        if few >= many:
            remedy = "give the mesh first and the coarser ones with --coarse, the coarsest first"
            raise InputError("the coarse mesh has not fewer cells", coarse, f"{few}, {fine} has {many}", remedy)


def _check_cells(space, path):
    """Raises InputError for cells that are turned inside out, overlap their neighbours, or are too distorted.

    A flow would be found with inverted or overlapping cells too, but mass would not be conserved. Cells are too
    distorted if `flow mesh` would not write them. Their shape measure gamma (3 inradius / circumradius, see
    flow.geometry.curving.gamma) is not checked. `flow mesh` limits gamma only for cells that are not swept, and a mesh
    file does not tell which these are.
    """
    remedy = "make the mesh anew with `flow mesh`, which checks every cell"
    points, cells = space.nodes()
    lower, upper = tet10.jacobian_bounds(points[cells])
    for limit, what in (
        (lower <= 0, "inverted or folded (their Jacobian is not positive throughout)"),
        (lower < LEAST_JACOBIAN_RATIO * upper, f"distorted (least over largest Jacobian below {LEAST_JACOBIAN_RATIO})"),
    ):
        bad = np.flatnonzero(limit)
        if len(bad):
            x, y, z = points[cells[bad[0], :4]].mean(axis=0) / M_PER_MM
            where = f"{path}, the first of them around ({x:.3f}, {y:.3f}, {z:.3f}) mm"
            raise InputError(f"cells of the mesh are {what}", where, f"{len(bad)} of {len(cells)} cells", remedy)
    folded = count_overlapping(cells[:, :4])
    if folded:
        raise InputError("cells of the mesh overlap their neighbours", path, f"across {folded} faces", remedy)


def _check_curved(space, path):
    """Raises InputError for a mesh whose edges are all straight.

    A wall of plane facets encloses less than the lumen. The error estimate does not see this error, since a finer mesh
    of the same facets has it too.
    """
    points, cells = space.nodes()
    start, end = (points[cells[:, tet10.EDGES[:, k]]] for k in (0, 1))
    off = np.linalg.norm(points[cells[:, 4:]] - 0.5 * (start + end), axis=2)
    if not (off > STRAIGHT_TOLERANCE * np.linalg.norm(end - start, axis=2)).any():
        remedy = "make it with `flow mesh`: quadratic tetrahedra, curved along the wall"
        raise InputError("the mesh's wall is made of plane facets", path, "no curved edge", remedy)

"""What differs between FEniCSx versions, beside common.fenicsx; written for dolfinx 0.5.2 (Debian 12)."""

import contextlib
import io
import logging

import numpy as np
import scipy.sparse
import ufl
from dolfinx import fem
from dolfinx.cpp.fem.petsc import create_matrix, interpolation_matrix
from dolfinx.io import gmshio
from dolfinx.plot import create_vtk_mesh
from mpi4py import MPI

from common import fenicsx
from common.errors import InputError

logging.getLogger("FFC").setLevel(logging.WARNING)
logging.getLogger("root").setLevel(logging.WARNING)

FLAGS = ("-O3", "-march=native", "-fno-math-errno")


def read_gmsh(path, comm=MPI.COMM_SELF, dimension=3):
    """(mesh, facet tags) of a gmsh file with `dimension` coordinates, which are as in the file. Raises InputError.

    gmshio.read_from_msh of 0.5.2 raises a NameError, hence the detour over gmsh's model.
    """
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        _open(gmsh, path)
        with contextlib.redirect_stdout(io.StringIO()):
            mesh, _, facets = gmshio.model_to_mesh(gmsh.model, comm, 0, gdim=dimension)
    finally:
        gmsh.finalize()
    return mesh, facets


def count_cells(path):
    """Number of cells of a gmsh file. Raises InputError."""
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        _open(gmsh, path)
        return sum(len(tags) for tags in gmsh.model.mesh.getElements(3)[1])
    finally:
        gmsh.finalize()


def _open(gmsh, path):
    remedy = "make it with `flow mesh`"
    try:
        gmsh.open(str(path))
    except Exception as error:  # gmsh raises nothing more precise
        raise InputError("not a mesh that gmsh reads", path, error, remedy) from error
    if len(gmsh.model.mesh.getNodes()[0]) == 0 or not gmsh.model.getPhysicalGroups():
        raise InputError("a mesh without cells or tags", path, "no nodes or no physical groups", remedy)


def vector_element(mesh, degree):
    """Lagrange element with as many components as the mesh has coordinates."""
    return ufl.VectorElement("Lagrange", mesh.ufl_cell(), degree)


def scalar_element(mesh, degree):
    """Lagrange element."""
    return ufl.FiniteElement("Lagrange", mesh.ufl_cell(), degree)


def mixed_element(*elements):
    """Product of elements."""
    return ufl.MixedElement(*elements)


def degrees(space):
    """Degrees of the parts of a mixed space."""
    return [element.degree() for element in space.ufl_element().sub_elements()]


def function_space(mesh, element):
    """Finite-element space."""
    return fem.FunctionSpace(mesh, element)


def form(expression):
    """Compiled form."""
    return fenicsx.form(expression, FLAGS)


def block_matrix(compiled):
    """Empty PETSc matrix of a form on a vector space, stored by the blocks of its nodes."""
    return create_matrix(compiled, "baij")


def interpolation(coarse, fine):
    """Sparse matrix (nodes of fine, nodes of coarse) from one component of a space's values to that of its interpolant
    in another on the same mesh."""
    scalars = [function_space(space.mesh, scalar_element(space.mesh, degree(space))) for space in (fine, coarse)]
    matrix = interpolation_matrix(*(scalar._cpp_object for scalar in scalars[::-1]))
    matrix.assemble()
    starts, columns, values = matrix.getValuesCSR()
    found = scipy.sparse.csr_matrix((values, columns, starts), matrix.size)
    matrix.destroy()
    number = [np.empty(found.shape[k], int) for k in range(2)]
    for of, space, scalar in zip(number, (fine, coarse), scalars):
        of[cell_dofs(space)] = cell_dofs(scalar)  # each space numbers its nodes in its own way
    return found[number[0]][:, number[1]]


def degree(space):
    """Degree of a space that is not mixed."""
    return space.ufl_element().degree()


def petsc_vector(function):
    """The PETSc vector behind a Function."""
    return function.vector


def cell_dofs(space):
    """(cells, dofs of a cell) node numbers of a space that is not mixed."""
    lists = space.dofmap.list.array
    return lists.reshape(-1, len(space.dofmap.cell_dofs(0)))


def part(mixed, index, element):
    """(space of a mixed space's part, (n,) the mixed space's dofs by those of the part); element: the part's.

    As collapse(), which takes forty times as long on cubic elements in 0.5.2.
    """
    space = fem.FunctionSpace(mixed.mesh, element)
    size, cells = space.dofmap.bs, cell_dofs(space)
    own = (size * cells[:, :, None] + np.arange(size)).reshape(len(cells), -1)
    dofs = np.empty(own.max() + 1, np.int32)
    dofs[own] = mixed.sub(index).dofmap.list.array.reshape(own.shape)
    return space, dofs


def quadratic_cells(space):
    """(points (n, 3), cells (t, 10)) of a quadratic space: its nodes, cells in the node order of geometry.tet10."""
    topology, _, points = create_vtk_mesh(space)
    cells = np.asarray(topology).reshape(-1, 11)[:, 1:]
    # VTK's last two middle nodes are those of the edges 13, 23; gmsh's those of 23, 13
    return points, cells[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]


def quadratic_quadrilaterals():
    """The coordinate element of curved quadrilaterals in the plane."""
    return ufl.Mesh(ufl.VectorElement("Lagrange", ufl.Cell("quadrilateral", geometric_dimension=2), 2))

"""FEniCSx as the flow uses it: meshes, spaces, forms and matrices; common.fenicsx has what differs by its version."""

import contextlib
import io
import logging

import numpy as np
import scipy.sparse
from dolfinx import la
from dolfinx.io import gmshio
from mpi4py import MPI

from common import fenicsx
from common.errors import InputError
from flow.geometry import tet10

logging.getLogger("FFC").setLevel(logging.WARNING)
logging.getLogger("root").setLevel(logging.WARNING)

FLAGS = ("-O3", "-march=native", "-fno-math-errno")

cell_dofs, degree, degrees = fenicsx.cell_dofs, fenicsx.degree_of, fenicsx.degrees
function_space, mixed_element, petsc_vector = fenicsx.function_space, fenicsx.mixed, fenicsx.petsc_vector


def read_gmsh(path, dimension=3):
    """(mesh, facet tags) of a gmsh file with `dimension` coordinates, which are as in the file. Raises InputError.

    gmshio.read_from_msh of 0.5.2 raises a NameError, hence the detour over gmsh's model.
    """
    with _model_of(path) as model, contextlib.redirect_stdout(io.StringIO()):
        mesh, _, facets = gmshio.model_to_mesh(model, MPI.COMM_SELF, 0, gdim=dimension)
    return mesh, facets


def count_cells(path):
    """Number of cells of a gmsh file. Raises InputError."""
    with _model_of(path) as model:
        return sum(len(tags) for tags in model.mesh.getElements(3)[1])


@contextlib.contextmanager
def _model_of(path):
    """Yields gmsh's model of a file. Raises InputError."""
    import gmsh

    remedy = "make it with `flow mesh`"
    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        try:
            gmsh.open(str(path))
        except Exception as error:  # gmsh raises nothing more precise
            raise InputError("not a mesh that gmsh reads", path, error, remedy) from error
        if len(gmsh.model.mesh.getNodes()[0]) == 0 or not gmsh.model.getPhysicalGroups():
            raise InputError("a mesh without cells or tags", path, "no nodes or no physical groups", remedy)
        yield gmsh.model
    finally:
        gmsh.finalize()


def vector_element(mesh, degree):
    """Lagrange element with as many components as the mesh has coordinates."""
    return fenicsx.lagrange(fenicsx.cell_of(mesh), degree, mesh.geometry.dim)


def scalar_element(mesh, degree):
    """Lagrange element."""
    return fenicsx.lagrange(fenicsx.cell_of(mesh), degree)


def form(expression):
    """Compiled form."""
    return fenicsx.form(expression, FLAGS)


def block_matrix(compiled):
    """Empty PETSc matrix of a form on a vector space, stored by the blocks of its nodes."""
    return fenicsx.create_matrix(compiled, "baij")


def csr(matrix):
    """scipy's CSR of a PETSc matrix, which is assembled and destroyed."""
    matrix.assemble()
    starts, columns, values = matrix.getValuesCSR()
    found = scipy.sparse.csr_matrix((values, columns, starts), matrix.size)
    matrix.destroy()
    return found


def interpolation(coarse, fine):
    """Sparse matrix (nodes of fine, nodes of coarse) from one component of a space's values to that of its interpolant
    in another on the same mesh."""
    scalars = [function_space(space.mesh, scalar_element(space.mesh, degree(space))) for space in (fine, coarse)]
    found = csr(fenicsx.interpolation_matrix(*scalars[::-1]))
    number = [np.empty(found.shape[k], int) for k in range(2)]
    for of, space, scalar in zip(number, (fine, coarse), scalars):
        of[cell_dofs(space)] = cell_dofs(scalar)  # each space numbers its nodes in its own way
    return found[number[0]][:, number[1]]


def new_vector(space):
    """A PETSc vector over a space, zero."""
    return la.create_petsc_vector(space.dofmap.index_map, space.dofmap.index_map_bs)


def part(mixed, index, element):
    """(space of a mixed space's part, (n,) the mixed space's dofs by those of the part); element: the part's.

    As collapse(), which takes forty times as long on cubic elements in 0.5.2.
    """
    space = function_space(mixed.mesh, element)
    size, cells = space.dofmap.bs, cell_dofs(space)
    own = (size * cells[:, :, None] + np.arange(size)).reshape(len(cells), -1)
    dofs = np.empty(own.max() + 1, np.int32)
    dofs[own] = cell_dofs(mixed.sub(index)).reshape(own.shape)
    return space, dofs


def quadratic_cells(space):
    """(points (n, 3), cells (t, 10)) of a quadratic space: its nodes, cells in the node order of geometry.tet10."""
    topology, _, points = fenicsx.vtk_cells(space)
    cells = np.asarray(topology).reshape(-1, 11)[:, 1:]
    return points, cells[:, tet10.VTK_ORDER]

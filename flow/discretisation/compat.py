"""FEniCSx as the flow uses it: meshes, spaces, forms and matrices.

common.fenicsx holds what differs between versions of FEniCSx.
"""

import contextlib
import io
import logging

import numpy as np
import scipy.sparse
from dolfinx import fem
from dolfinx.io import gmshio
from mpi4py import MPI

from common import fenicsx, processor
from common.errors import InputError
from flow.geometry import tet10

logging.getLogger("FFC").setLevel(logging.WARNING)
logging.getLogger("root").setLevel(logging.WARNING)

# Flags of the C compiler for forms. As for numpy (common.processor), code for AVX2 is the most that is used. So results
# do not depend on the processor, and a cache of compiled forms serves all machines.
COMPILER_FLAGS = ("-O3", f"-march={processor.architecture(processor.cpu_flags())}", "-fno-math-errno")

cell_dofs, degree, degrees = fenicsx.cell_dofs, fenicsx.degree_of, fenicsx.degrees
function_space, mixed_element = fenicsx.function_space, fenicsx.mixed


def read_gmsh(path, dimension=3):
    """(mesh, facet tags) of a gmsh file. Raises InputError.

    The mesh has `dimension` coordinates, in the unit of the file. The file is read through gmsh's model, since
    gmshio.read_from_msh of dolfinx 0.5.2 raises a NameError.
    """
    with _model_of(path) as model, contextlib.redirect_stdout(io.StringIO()):
        mesh, _, facets = gmshio.model_to_mesh(model, MPI.COMM_SELF, 0, gdim=dimension)
    return mesh, facets


def count_cells(path):
    """Number of three-dimensional cells in a gmsh file. Raises InputError."""
    with _model_of(path) as model:
        return sum(len(tags) for tags in model.mesh.getElements(3)[1])


@contextlib.contextmanager
def _model_of(path):
    """Opens a mesh file in gmsh and yields gmsh.model. Raises InputError."""
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
    """Vector-valued Lagrange element of this degree, with as many components as the mesh has coordinates."""
    return fenicsx.lagrange(fenicsx.cell_name(mesh), degree, mesh.geometry.dim)


def scalar_element(mesh, degree):
    """Scalar Lagrange element of this degree."""
    return fenicsx.lagrange(fenicsx.cell_name(mesh), degree)


def form(expression):
    """Compiled form of a UFL expression."""
    return fenicsx.form(expression, COMPILER_FLAGS)


def block_matrix(compiled):
    """Empty PETSc matrix of a compiled form on a vector-valued space. It has a dense block for each pair of nodes."""
    return fenicsx.create_matrix(compiled, "baij")


def to_csr(matrix):
    """scipy CSR matrix with the values of a PETSc matrix, which is assembled first and destroyed afterwards."""
    matrix.assemble()
    starts, columns, values = matrix.getValuesCSR()
    found = scipy.sparse.csr_matrix((values, columns, starts), matrix.size)
    matrix.destroy()
    return found


def interpolation_matrix(coarse, fine):
    """Sparse matrix (nodes of fine, nodes of coarse) that interpolates nodal values from one space to another.

    coarse, fine: spaces on the same mesh. For vector-valued spaces the matrix acts on one component.
    """
    scalars = [function_space(space.mesh, scalar_element(space.mesh, degree(space))) for space in (fine, coarse)]
    found = to_csr(fenicsx.interpolation_matrix(*scalars[::-1]))
    numberings = [np.empty(found.shape[k], int) for k in range(2)]
    for numbering, space, scalar in zip(numberings, (fine, coarse), scalars):
        numbering[cell_dofs(space)] = cell_dofs(scalar)  # each space numbers its nodes in its own way
    return found[numberings[0]][:, numberings[1]]


def assemble(compiled):
    """Assembled vector (n,) of a compiled linear form."""
    return fem.assemble_vector(compiled).array


def subspace(mixed, index, element):
    """(space, dofs (n,)) of part `index` of a mixed space, as a space of its own: dof i of it is dofs[i] of `mixed`.

    element: the part's element. dolfinx's collapse() does the same, but in 0.5.2 takes forty times as long on cubic
    elements.
    """
    space = function_space(mixed.mesh, element)
    size, cells = space.dofmap.bs, cell_dofs(space)
    own = (size * cells[:, :, None] + np.arange(size)).reshape(len(cells), -1)
    dofs = np.empty(own.max() + 1, np.int32)
    dofs[own] = cell_dofs(mixed.sub(index)).reshape(own.shape)
    return space, dofs


def quadratic_cells(space):
    """(nodes (n, 3), cells (t, 10)) of a quadratic space, with the cells' nodes in the order of geometry.tet10."""
    topology, _, points = fenicsx.vtk_cells(space)
    cells = np.asarray(topology).reshape(-1, 11)[:, 1:]
    return points, cells[:, tet10.VTK_ORDER]

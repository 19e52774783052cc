"""One interface to FEniCSx 0.5 (Debian 12) and 0.9 (Debian 13), and compiled forms.

Elements, function spaces and their data have one name here, so that all other code is the same for both versions. In
the functions for elements `cell` is a cell's name, such as "tetrahedron". `size` is the number of components of a
vector-valued element, None for a scalar one.
"""

import pathlib
import time

import basix
import ufl
from dolfinx import fem, jit, plot

# Longest time in s that a program waits while another one compiles the same form. FEniCSx's default is 10 s.
COMPILE_WAIT_S = 300

if hasattr(fem, "functionspace"):  # FEniCSx 0.9
    import basix.ufl
    from dolfinx.fem.petsc import create_matrix, interpolation_matrix

    JIT_OPTIONS, jit_options, vtk_cells, function_space = (
        "jit_options",
        jit.get_options,
        plot.vtk_mesh,
        fem.functionspace,
    )

    def lagrange(cell, degree, size=None):
        """Lagrange element."""
        return basix.ufl.element("Lagrange", cell, degree, shape=_shape(size))

    def quadrature(cell, degree, size=None):
        """Quadrature element: values at the points of the quadrature rule that is exact to `degree`."""
        return basix.ufl.quadrature_element(cell, _shape(size) or (), degree=degree)

    def mixed(*elements):
        """Mixed element of several elements."""
        return basix.ufl.mixed_element(list(elements))

    def degrees(space):
        """Polynomial degrees of the parts of a mixed space."""
        return [element.degree for element in space.ufl_element().sub_elements]

    def degree_of(space):
        """Polynomial degree of a space that is not mixed."""
        return space.ufl_element().degree

    def petsc_vector(function):
        """The PETSc vector with the values of a fem.Function. It may not be used after the Function is freed."""
        return function.x.petsc_vec

    def expression_values(expression, mesh, cells):
        """Values of a fem.Expression at its evaluation points in `cells` (cell numbers), one row for each cell."""
        return expression.eval(mesh, cells)

    def cell_dofs(space):
        """Numbers of the nodes in each cell of a function space, shape (cells, nodes of a cell).

        For a part of a mixed space: the numbers in the mixed space of the part's degrees of freedom (dofs) in each
        cell.
        """
        return space.dofmap.list

    def _shape(size):
        return None if size is None else (size,)

else:  # FEniCSx 0.5
    from dolfinx.cpp.fem import petsc as cpp_petsc

    JIT_OPTIONS, jit_options, vtk_cells = "jit_params", jit.get_parameters, plot.create_vtk_mesh
    function_space, create_matrix = fem.FunctionSpace, cpp_petsc.create_matrix

    def lagrange(cell, degree, size=None):
        return _element("Lagrange", cell, degree, size)

    def quadrature(cell, degree, size=None):
        return _element("Quadrature", cell, degree, size, quad_scheme="default")

    def mixed(*elements):
        return ufl.MixedElement(*elements)

    def degrees(space):
        return [element.degree() for element in space.ufl_element().sub_elements()]

    def degree_of(space):
        return space.ufl_element().degree()

    def petsc_vector(function):
        return function.vector

    def expression_values(expression, mesh, cells):
        return expression.eval(cells)

    def cell_dofs(space):
        lists = space.dofmap.list.array
        return lists.reshape(-1, len(space.dofmap.cell_dofs(0)))

    def interpolation_matrix(coarse, fine):
        return cpp_petsc.interpolation_matrix(coarse._cpp_object, fine._cpp_object)

    def _element(family, cell, degree, size, **more):
        if size is None:
            return ufl.FiniteElement(family, cell, degree, **more)
        return ufl.VectorElement(family, cell, degree, dim=size, **more)


def cell_name(mesh):
    """Name of a mesh's kind of cell, as `lagrange` and the other elements take it."""
    return mesh.ufl_cell().cellname()


def quadratic_domain(cell):
    """UFL's domain of cells with quadratic (curved) geometry, for dolfinx.mesh.create_mesh."""
    return ufl.Mesh(lagrange(cell, 2, len(basix.topology(getattr(basix.CellType, cell))) - 1))


def form(expression, flags=()):
    """Compiled form of a UFL expression. flags: options of the C compiler, in place of FEniCSx's own."""
    options = {"timeout": COMPILE_WAIT_S}
    if flags:
        options["cffi_extra_compile_args"] = list(flags)
    return fem.form(expression, **{JIT_OPTIONS: options})


def remove_unfinished_cache():
    """Removes files that killed programs left in FEniCSx's compilation cache; returns the files' names.

    A source file without its `.cached` file says that a program is compiling this form. If that program was killed,
    every later one waits for it, and then fails. Only files older than COMPILE_WAIT_S are removed; no form takes that
    long.
    """
    removed = []
    for source in pathlib.Path(jit_options()["cache_dir"]).expanduser().glob("libffcx_*.c"):
        try:
            if not source.with_suffix(".c.cached").exists() and time.time() - source.stat().st_mtime > COMPILE_WAIT_S:
                source.unlink()
                removed.append(source.name)
        except FileNotFoundError:  # another program has just removed it
            continue
    return removed


remove_unfinished_cache()  # before the first function space, which compiles too

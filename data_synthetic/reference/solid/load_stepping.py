"""Loads a solid model in steps by Newton's method. A load step that fails is tried again with half its size."""

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from common import fenicsx
from common.errors import ComputationError

from . import laws

LOAD_NAMES = ("balloon_radius", "balloon_stiffness", "balloon_cap", "balloon_share") + (
    "stent_radius",
    "stent_stiffness",
    "stent_cap",
    "stent_share",
    "pressure",
)
MAX_ITERATIONS = 14  # largest number of Newton's iterations in one load step
MOST_HALVINGS = 10  # a load step is halved at most this many times
DIVERGENCE_FACTOR = 2.0  # Newton's method gives up if the residual exceeds the first one by this factor


class LoadSteppedModel:
    """The load stepping that slices and the solid in three dimensions share.

    The constructor of a subclass sets these attributes, then calls `_set_up_solver(residual)`:

    - u: displacement (fem.Function)
    - _constants: loads by name (fem.Constant)
    - _plastic, _strain: plastic state at the quadrature points after the last load step. It consists of the
    `plastic_size` components of Cp^-1 (see `laws`) and the equivalent plastic strain
    - _update: fem.Expression of the plastic state at the present displacement
    - _cells: cells on which `_update` is evaluated

    Loads are a dict of LOAD_NAMES. They are the parameters of the pressure laws of balloon and stent, and a uniform
    pressure (MPa) for tests. Each law is multiplied by its share, from 0 to 1.
    """

    plastic_size = 4
    kind = "plane-strain slice"
    remedy = "a finer slice (elements_around, elements_through), or a softer plan"

    def _set_up_solver(self, residual):
        """Compiles the residual and its tangent, and sets up the linear solver."""
        self._residual = fenicsx.form(residual)
        self._tangent = fenicsx.form(ufl.derivative(residual, self.u))
        self._matrix = fem_petsc.create_matrix(self._tangent)
        self._vector = fem_petsc.create_vector(self._residual)
        self._solver = PETSc.KSP().create(PETSc.COMM_SELF)
        self._solver.setType("preonly")
        self._solver.getPC().setType("lu")
        self._solver.setOperators(self._matrix)
        self.restart()

    def restart(self):
        """Forgets the last load step, from which the next is predicted. Displacement and plastic state are kept."""
        self.iterations = 0
        self._last_step = None  # (change of the loads, change of the displacement) of the last step

    def _create_loads(self, mesh, more=()):
        """Makes the constants of LOAD_NAMES and of the names `more`, without any load.

        Stiffnesses and caps are 1 rather than 0. The laws are evaluated even at share 0, and would then be 0 / 0.
        """
        self._constants = {name: fem.Constant(mesh, 0.0) for name in (*LOAD_NAMES, *more)}
        self.set_loads(dict.fromkeys(("balloon_stiffness", "balloon_cap", "stent_stiffness", "stent_cap"), 1.0))

    def _quadrature_function(self, mesh, size):
        """Function with `size` values at each quadrature point."""
        element = fenicsx.quadrature(fenicsx.cell_name(mesh), laws.DEVIATORIC_DEGREE, size if size > 1 else None)
        return fem.Function(fenicsx.function_space(mesh, element))

    def set_loads(self, loads):
        """Sets the constants named in `loads` (keys from LOAD_NAMES)."""
        for name, value in loads.items():
            self._constants[name].value = value

    def loads(self):
        """The present loads {name: value}."""
        return {name: float(constant.value) for name, constant in self._constants.items()}

    def _newton(self):
        """Newton's method from the present displacement. Returns whether it converged; u keeps the last iterate."""
        scale, first = 1.0, np.inf
        for iteration in range(MAX_ITERATIONS):
            with self._vector.localForm() as local:
                local.set(0)
            fem_petsc.assemble_vector(self._vector, self._residual)
            norm = self._vector.norm()
            if not np.isfinite(norm) or norm > 1e4:
                return False
            if iteration > 0 and norm < 1e-9 * scale + 1e-10:
                return True
            if iteration > 3 and norm > DIVERGENCE_FACTOR * first:
                return False
            first = norm if iteration == 0 else first
            scale = max(scale, norm)
            self._matrix.zeroEntries()
            fem_petsc.assemble_matrix(self._matrix, self._tangent)
            self._matrix.assemble()
            step = self._vector.duplicate()
            self._solver.solve(self._vector, step)
            change = np.abs(step.array).max()
            self.iterations += 1
            # A long step overshoots the contact. So a step that moves a node by more than 0.25 mm is scaled to 0.25 mm.
            self.u.x.array[:] -= step.array * min(1.0, 0.25 / max(change, 1e-30))
            step.destroy()
            if change < 1e-8:
                return True
        return False

    def _accept_step(self):
        """Makes the plastic state at the present displacement the start of the next step."""
        size = self.plastic_size
        values = fenicsx.expression_values(self._update, self.u.function_space.mesh, self._cells).reshape(-1, size + 1)
        self._plastic.x.array[:] = values[:, :size].ravel()
        self._strain.x.array[:] = values[:, size]

    def _predicted_displacement(self, change):
        """Displacement expected from a change of the loads (array).

        If the loads change in proportion to the last step, it is that step's displacement, scaled. Otherwise it is 0.
        """
        if self._last_step is None:
            return 0.0
        loads, moved = self._last_step
        ratio = (change @ loads) / max(loads @ loads, 1e-300)
        alike = np.allclose(change, ratio * loads, rtol=0, atol=1e-9 * np.abs(change).max())
        return ratio * moved if alike and 0 < ratio <= 2 else 0.0

    def advance(self, target, name="load"):
        """Moves the loads to `target` (dict) in one load step, or in parts of it where Newton's method fails.

        name: name of the load step, for messages. Raises ComputationError if a part of 0.5**MOST_HALVINGS still fails.
        """
        start = self.loads()
        goal = {**start, **target}
        done, step = 0.0, 1.0
        while done < 1:
            step = min(step, 1 - done)
            before = self.u.x.array.copy()
            share = done + step
            change = step * np.array([goal[key] - start[key] for key in sorted(goal)])
            self.set_loads({key: start[key] + share * (goal[key] - start[key]) for key in goal})
            self.u.x.array[:] += self._predicted_displacement(change)
            if self._newton():
                self._accept_step()
                self._last_step = (change, self.u.x.array - before)
                done, step = share, 2 * step
            else:
                self.u.x.array[:] = before
                step *= 0.5
                if step < 0.5**MOST_HALVINGS:
                    raise ComputationError(
                        f"the {self.kind} did not converge",
                        name,
                        f"stopped at {100 * done:.1f} % of the step to {target}",
                        self.remedy,
                    )

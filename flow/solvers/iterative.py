"""Newton's equations by an iterative solver whose memory and work grow as the cells do.

The tangent, bordered by the inflow Q with the inlet's profile g, and outlets i behind resistances R_i with flux f_i:

    [F + sum R_i f_i f_i'   B'   F g ] [du]   [r_u]       F: velocity block of Newton's method (discretisation.forms)
    [B                      0    B g ] [dp] = [r_p]       B: -(q, div u)
    [g' F                   g'B' g'Fg] [dQ]   [r_Q]

R_i and Q are part of the operator, so they are exact. Flexible GMRES solves it, preconditioned in two steps:

1. the coarse mesh's flow, factorized by MUMPS at the flow found there, corrects what it can represent: transport along
   the vessel, the pressure, Q and the outlets (residual carried there by the transposed of solvers.transfer);
2. what is left lies between the two meshes. dp = -L^-1 r_p with L = B D^-1 B', D the diagonal of F with the inertia of
   a local time step (algebraic multigrid, one V-cycle), then du by a few steps of GMRES for F with the stars
   (solvers.star) of F with that inertia.

Stars and L are made once, at the first tangent. The transposed equations, of the error estimate, are solved likewise.
"""

import numpy as np
import scipy.sparse
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from common.errors import ComputationError
from flow.discretisation import compat, tangent
from flow.physics import outlets
from flow.solvers import krylov, nonlinear, star, transfer

TOLERANCE = 1e-2  # of a correction; Newton's method and the secants repeat it
DUAL_TOLERANCE = 1e-3  # of the error estimate's solve
MOST_ITERATIONS = 60
INNER = 6  # steps of GMRES for the velocity
CFL = 20.0  # of the local time step
HINT = "a finer coarse mesh (coarse_rings), or linear_solver direct where memory allows"


class IterativeProblem(nonlinear.FlowProblem):
    """FlowProblem whose corrections are iterative; coarse: solved FlowProblem on a coarser mesh, kept by its owner.

    iterations: of each solve. Its residual's norm counts the divergence, in N as a force of the grad-div term.
    """

    def __init__(self, space, boundaries, document, settings, jet_length, spent, coarse):
        super().__init__(space, boundaries, document, settings, jet_length, spent)
        self.coarse, self.iterations, self.blocks = coarse, [], None
        self.transfer = transfer.Transfer(coarse.space, space)
        volume = fem.assemble_scalar(compat.form(fem.Constant(space.mesh, 1.0) * ufl.dx(space.mesh)))
        width = (volume / len(space.nodes()[1])) ** (1 / 3)
        self.weight = (settings.grad_div_pa_s + document["viscosity_pa_s"]) / width  # N s/m3, of the divergence
        self.fixed = np.zeros(space.dofs, bool)
        self.fixed[space.wall] = self.fixed[space.inlet] = True

    def set_guess(self, space, state, inflow):
        """Takes the values `state` on the coarse mesh's space."""
        velocity = self.transfer.velocity @ state[space.v_map].reshape(-1, 3)
        values = self.state.x.array
        values[self.space.q_map] = self.transfer.pressure @ state[space.q_map]
        values[self.space.v_map] = velocity.ravel()
        values[self.space.wall] = 0.0
        self.inflow = inflow
        values[self.space.inlet] = inflow * self.boundaries.profile.x.array[self.space.inlet]

    def residual(self):
        """As FlowProblem's, its norm with the weighted divergence."""
        free, inlet, _ = super().residual()
        scaled = np.where(self.free_velocity, 1.0, self.weight) * free.array_r
        return free, inlet, float(np.hypot(np.linalg.norm(scaled), inlet * self.boundaries.inlet_area))

    def small(self, norm, absolute, relative):
        """As FlowProblem's; where the answer is wanted (absolute is finite) mass has to be conserved as well."""
        lost = self.boundaries.outflows(self.state_vector()).sum() - self.inflow
        conserved = abs(lost) <= outlets.LARGEST_IMBALANCE * abs(self.inflow)
        return super().small(norm, absolute, relative) and (conserved or not np.isfinite(absolute))

    def linearise(self, form):
        """Assembles the tangent's blocks at the present state. Raises ComputationError for any other `form`."""
        if form is not self.forms.tangent or self.inertia:
            raise ComputationError("the iterative solver takes Newton's steps only", "linear_solver", "iterative", HINT)
        if self.blocks is None:
            self.blocks = Blocks(self)
        self.blocks.assemble()
        self.solver.factorizations += 1

    def forget(self):
        """Nothing is kept from one linearisation to the next but its matrices."""

    def release(self):
        """Frees the matrices."""
        if self.blocks is not None:
            self.blocks.destroy()
            self.blocks = None

    def correction(self, residual, inlet):
        """As FlowProblem's, down to TOLERANCE of the residual."""
        values = np.zeros(self.space.dofs)
        values[self.space.free] = residual.array_r
        found = self._solved(values, inlet, TOLERANCE, False)
        return -found[0][self.space.free], -found[1]

    def answers(self, loads, on_inflow, transposed):
        """As FlowProblem's, at the present state."""
        self.linearise(self.forms.tangent)
        loads = np.where(self.fixed[:, None], 0.0, loads)
        found = [self._solved(load, one, DUAL_TOLERANCE, transposed) for load, one in zip(loads.T, on_inflow)]
        return np.stack([values for values, _ in found], axis=1), np.array([inflow for _, inflow in found])

    def _solved(self, values, inlet, tolerance, transposed):
        """(values over W, Q) of the solution for the right side (values over W, inlet). Raises ComputationError."""
        blocks = self.blocks
        right = blocks.packed(values, inlet)
        found = krylov.fgmres(
            lambda x: blocks.apply(x, transposed),
            lambda x: blocks.precondition(x, transposed),
            right,
            tolerance,
            MOST_ITERATIONS,
        )
        self.iterations.append(found.iterations)
        print(f"    {found.iterations} iterations to {found.residual:.1e}", file=self.log, flush=True)
        if not found.residual <= tolerance:
            raise ComputationError(
                "the linear solver did not converge", f"{found.iterations} iterations", f"{found.residual:.1e}", HINT
            )
        return blocks.unpacked(found.values)


class Blocks:
    """Operator and preconditioner of an IterativeProblem on arrays (velocity dofs of V, dofs of Q, Q).

    The continuity rows are in N by the problem's weight, the inflow's by the inlet's area.
    """

    def __init__(self, problem):
        self.problem, space = problem, problem.space
        self.count = len(space.v_map)
        held = problem.fixed[space.v_map]
        self.keep = np.where(held, 0.0, 1.0)
        self.held = np.flatnonzero(held).astype(np.int32)
        coarse = problem.coarse
        if coarse.bordered is None or coarse.linearised_as != (True, coarse.mixing):
            coarse.linearise(coarse.forms.tangent)
        boundaries = problem.boundaries
        self.profile = boundaries.profile.x.array[space.v_map]
        self.flux = [flux.array_r[space.v_map] * self.keep for flux in boundaries.flux]
        self.area, self.weight = boundaries.inlet_area, problem.weight
        self.velocity = compat.block_matrix(problem.forms.tangent_of_all)
        divergence = tangent.divergence(problem.forms)
        self.of_profile = divergence @ self.profile
        self.divergence = divergence @ scipy.sparse.diags(self.keep)
        self.gradient = self.divergence.T.tocsr()
        self.stars = None
        self.vectors = self.velocity.createVecs()

    def assemble(self):
        """The velocity block and its border at the problem's present state."""
        if self.stars is None:
            self._smoother()
        self._fill(self.velocity, self.problem.forms.tangent_of_all, True)  # each rank applies the whole

    def _fill(self, matrix, form, border=False):
        matrix.zeroEntries()
        fem_petsc.assemble_matrix(matrix, form)
        matrix.assemble()
        if border:
            self.column = self.keep * self._product(self.profile, False)
            self.row = self.keep * self._product(self.profile, True)
            self.corner = float(self.profile @ self._product(self.profile, False))
        matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        matrix.zeroRowsColumns(self.held, diag=1.0)

    def _smoother(self):
        """Stars and L of the velocity block with inertia."""
        form = self.problem.forms.tangent_with_inertia(CFL)
        matrix = compat.block_matrix(form)
        self._fill(matrix, form)
        space = self.problem.space
        groups = star.stars(space.nodes()[1], self.keep.reshape(-1, 3)[:, 0] > 0)

        def between(nodes):
            chosen = PETSc.IS().createBlock(3, nodes.astype(np.int32), comm=PETSc.COMM_SELF)
            part = matrix.createSubMatrix(chosen, chosen)
            plain = part.convert("aij", PETSc.Mat())
            starts, columns, values = plain.getValuesCSR()
            for petsc_object in (chosen, part, plain):
                petsc_object.destroy()
            return scipy.sparse.csr_matrix((values, columns, starts), (3 * len(nodes), 3 * len(nodes)))

        self.stars = star.Stars(groups, between, self.count // 3)
        diagonal = matrix.getDiagonal()
        scaled = self.divergence @ scipy.sparse.diags(self.keep / np.abs(diagonal.array_r)) @ self.gradient
        matrix.destroy()
        laplace = PETSc.Mat().createAIJ(
            scaled.shape, csr=(scaled.indptr, scaled.indices, scaled.data), comm=PETSc.COMM_SELF
        )
        self.ksp = PETSc.KSP().create(PETSc.COMM_SELF)
        self.ksp.setOperators(laplace)
        self.ksp.setType("preonly")
        self.ksp.getPC().setType("hypre")
        self.ksp.setUp()
        self.of_laplace = laplace.createVecs()

    def _product(self, values, transposed):
        """F or its transposed times values (n,)."""
        given, found = self.vectors
        given.array[:] = values
        (self.velocity.multTranspose if transposed else self.velocity.mult)(given, found)
        return found.array_r.copy()

    def packed(self, values, inlet):
        """Array of a right side: values over W (0 where fixed), inlet in Pa."""
        space = self.problem.space
        return np.concatenate([values[space.v_map], self.weight * values[space.q_map], [self.area * inlet]])

    def unpacked(self, array):
        """(values over W, Q)."""
        space, values = self.problem.space, np.zeros(self.problem.space.dofs)
        values[space.v_map], values[space.q_map] = array[: self.count], array[self.count : -1]
        return values, float(array[-1])

    def apply(self, x, transposed):
        """The bordered tangent, or its transposed, times x."""
        velocity, pressure, inflow = x[: self.count], x[self.count : -1], x[-1]
        wanted = self.problem.boundaries.inflow
        column, row = (self.row, self.column) if transposed else (self.column, self.row)
        image = self._product(velocity, transposed) + self.gradient @ pressure
        for resistance, flux in zip(self.problem.boundaries.resistance, self.flux):
            image += resistance * (flux @ velocity) * flux
        out = np.empty_like(x)
        if wanted is None:
            out[: self.count] = image + inflow * column
            out[self.count : -1] = self.weight * (self.divergence @ velocity + inflow * self.of_profile)
            out[-1] = self.area * (row @ velocity + self.of_profile @ pressure + self.corner * inflow)
        else:
            given = self.problem.boundaries.map_pa / wanted
            direct = 0.0 if transposed else inflow
            out[: self.count] = image + direct * column
            out[self.count : -1] = self.weight * (self.divergence @ velocity + direct * self.of_profile)
            back = self.column @ velocity + self.of_profile @ pressure if transposed else 0.0
            out[-1] = self.area * (back + given * inflow)
        return out

    def precondition(self, right, transposed):
        """The two steps of the module's docstring."""
        out = self._coarse(right, transposed)
        left = right - self.apply(out, transposed)
        pressure = -self._laplace(left[self.count : -1] / self.weight)
        out[self.count : -1] += pressure
        velocity = krylov.fgmres(
            lambda x: self._product(x, transposed),
            lambda x: self.stars.solve(x, transposed),
            self.keep * left[: self.count] - self.gradient @ pressure,
            TOLERANCE,
            INNER,
        )
        out[: self.count] += self.keep * velocity.values
        return out

    def _laplace(self, right):
        given, found = self.of_laplace
        given.array[:] = right
        self.ksp.solve(given, found)
        return found.array_r.copy()

    def _coarse(self, right, transposed):
        """The coarse mesh's correction."""
        problem, space, across = self.problem.coarse, self.problem.coarse.space, self.problem.transfer
        profile = problem.boundaries.profile.x.array
        values = np.zeros(space.dofs)
        velocity = (self.keep * right[: self.count]).reshape(-1, 3)
        values[space.v_map] = (across.velocity.T @ velocity).ravel()
        values[space.q_map] = across.pressure.T @ (right[self.count : -1] / self.weight)
        inlet = right[-1] / self.area
        if self.problem.boundaries.inflow is None or transposed:
            inlet += profile[space.inlet] @ values[space.inlet]
        found, inflow = problem.solved_for(values, inlet, transposed)
        found[space.inlet] = inflow * profile[space.inlet]
        out = np.empty_like(right)
        out[: self.count] = self.keep * (across.velocity @ found[space.v_map].reshape(-1, 3)).ravel()
        out[self.count : -1] = across.pressure @ found[space.q_map]
        out[-1] = inflow
        return out

    def destroy(self):
        """Frees PETSc's memory."""
        self.ksp.getOperators()[0].destroy()
        self.ksp.destroy()
        self.velocity.destroy()

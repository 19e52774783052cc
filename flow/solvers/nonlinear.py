"""The discrete flow problem with its boundaries, and the ways to its solution by Newton's method.

Unknowns are the velocity and pressure dofs x that no boundary fixes, the inflow Q, and the outlet pressures P_i. The
velocity at the inlet is Q g, with the profile g of physics.navier_stokes. The state always has P_i = P_v + R_i Q_i, so
these equations leave no residual. The equation of the inflow is the momentum equation tested with g: F(w; g) = MAP, in
Pa. Its residual times the inlet's area enters the norm in N, like the other residuals.

In a single tube, and in a tree that loses little pressure, Newton's method first starts from the flow of the reduced
models (solvers.predicted_start). If that fails in a single tube, the flow is raised from rest in steps (solvers.ramp).
If all this fails, and in other trees at once, an artificial viscosity is lowered step by step (solvers.continuation).
"""

import dataclasses
import sys

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

from common.errors import ComputationError
from flow.discretisation import compat, flow_state, forms, tangent
from flow.physics.units import M3_PER_S_PER_ML_PER_MIN
from flow.solvers import anderson, continuation, linear, newton, predicted_start, ramp

MOST_FROM_STATE = 6  # factorizations from the flow of another state, before the flow is sought in the usual way


@dataclasses.dataclass
class Outcome:
    """Result of a solve: whether it converged, iterations (factorizations), and the norm of the residual.

    residual_absolute in N; residual_relative over the pressure load (FlowProblem.pressure_load).
    """

    converged: bool
    iterations: int
    residual_absolute: float
    residual_relative: float


class FlowProblem(flow_state.FlowState):
    """The discrete equations of one lumen on a mesh, and the present flow: `state` (Function on space.W) and inflow.

    space: discretisation.spaces.LumenSpace, whose W is the mixed space of velocity and pressure; boundaries:
    physics.outlets.Boundaries; document: of boundary.json; earlier_factorizations: factorizations made on other meshes,
    which count against max_newton_iterations; log: stream for messages on progress.
    """

    def __init__(self, space, boundaries, document, settings, earlier_factorizations=0, log=None):
        self.earlier_factorizations, self.allowed_factorizations = (
            earlier_factorizations,
            settings.max_newton_iterations,
        )
        self.space, self.boundaries, self.settings, self.log = space, boundaries, settings, log or sys.stderr
        self.state = fem.Function(space.W)
        self.inflow = 0.0
        self.forms = forms.from_document(space, self.state, document, settings)
        self.free_velocity = np.isin(space.free_dofs, space.v_map)
        self.matrix = None  # discretisation.tangent.FreeMatrix
        self.solver = linear.DirectSolver()
        self.full_residual = compat.new_vector(space.W)
        self.profile = compat.petsc_vector(boundaries.profile)
        self.columns_of_outlets = [self.free_part(flux) for flux in boundaries.flux_vectors]
        self.pressure_load = boundaries.pressure_load(self.columns_of_outlets)
        self.residual_history = []
        self.bordered = None
        self.inertia = None  # solvers.marching.Inertia while the flow is marched in time
        self.flows_found = []  # (eps, values, inflow) of the flows found by continuation, the answer last

    @property
    def factorizations_left(self):
        """Factorizations that are still allowed."""
        return self.allowed_factorizations - self.earlier_factorizations - self.solver.factorizations

    def free_part(self, vector):
        """New vector with the values of `vector` (over W) at the free dofs.

        The values are copied. PETSc's getSubVector would leak memory unless its vector is given back.
        """
        part = self.free_vector()
        part.array[:] = vector.array_r[self.space.free_dofs]
        return part

    def free_vector(self):
        """New vector of the free dofs."""
        return PETSc.Vec().createSeq(len(self.space.free_dofs), comm=PETSc.COMM_SELF)

    def residual(self):
        """Residual at the present state: (PETSc vector of the free dofs, residual of the inflow's equation in Pa, norm
        of both in N).

        The inflow's equation says that the mean inlet pressure is MAP. Where the inflow is given as Q0, it is
        (Q / Q0 - 1) MAP = 0.
        """
        vector = self.full_residual
        self.forms.assemble_residual(vector)
        outflows = self.boundaries.outflows(compat.petsc_vector(self.state))
        vector.maxpy(self.boundaries.pressures(outflows), self.boundaries.flux_vectors)
        if self.inertia:
            self.inertia.add_force(vector, self.state_vector())
        self.mean_inlet_pressure = float(self.profile.dot(vector))
        wanted = self.boundaries.inflow
        if wanted is None:
            inlet = self.mean_inlet_pressure - self.boundaries.map_pa
        else:
            inlet = (self.inflow / wanted - 1.0) * self.boundaries.map_pa
        free = self.free_part(vector)
        norm = float(np.hypot(free.norm(), inlet * self.boundaries.inlet_area))
        return free, inlet, norm

    def residual_norm(self):
        """Norm of the residual in N. Also sets mean_inlet_pressure in Pa, the mean weighted with the profile g."""
        free, _, norm = self.residual()
        free.destroy()
        return norm

    def linearise(self, form):
        """Factorizes the tangent at the present state, for `correction` and `responses`. Raises ComputationError.

        form: its velocity block, `tangent` (Newton) or `picard` of discretisation.forms.
        """
        if self.matrix is None:
            self.matrix = tangent.FreeMatrix(self.space, self.forms)
        self.matrix.assemble(form, self.inertia)
        self.solver.set_matrix(self.matrix.matrix)
        profile = self.boundaries.profile.x.array
        forward, backward = self.matrix.multiply(profile), self.matrix.multiply(profile, transposed=True)
        resistance = self.boundaries.resistance
        outlets = [column for column, r in zip(self.columns_of_outlets, resistance) if r > 0]
        column, row = self.free_vector(), self.free_vector()
        column.array[:], row.array[:] = forward[self.space.free_dofs], backward[self.space.free_dofs]
        columns, rows = [column] + outlets, [row] + outlets
        corner = np.diag(np.concatenate([[profile @ forward], -1.0 / resistance[resistance > 0]]))
        if self.boundaries.inflow is not None:
            rows[0].set(0.0)
            corner[0, 0] = self.boundaries.map_pa / self.boundaries.inflow
        self.free_linearisation()
        self.bordered = linear.BorderedSystem(self.solver, columns, rows, corner)
        self.linearised_as = (form is self.forms.tangent, self.artificial_viscosity)

    def mark_outdated(self):
        """Marks the last factorization as made at a state too far from the present one for `responses`.

        `responses` then factorizes anew.
        """
        self.linearised_as = None

    def free_linearisation(self):
        """Frees the vectors of the last linearisation, but not the factors."""
        if self.bordered:
            for part in (self.bordered.rows[0], self.bordered.columns[0], self.bordered):
                part.destroy()
            self.bordered = None

    def release(self):
        """Frees matrix and factors; the next linearisation makes them anew."""
        self.free_linearisation()
        self.solver.release()
        if self.matrix is not None:
            self.matrix.destroy()
        self.matrix = None

    def correction(self, residual, inlet):
        """(update of the free dofs (n,), update of the inflow in m3/s) by the last linearisation.

        residual, inlet: as `residual` returns them.
        """
        right = np.zeros(len(self.bordered.rows))
        right[0] = inlet
        x, y = self.bordered.solve(residual, right)
        update = -x.array
        x.destroy()
        return update, -float(y[0])

    def responses(self, loads):
        """Solutions w (n, k) over W of K w = load, for loads (n, k) over W; K is Newton's tangent.

        w is the change of the flow by the load, to first order. The derivative of a quantity such as FFR times w is the
        change of that quantity. The last factorization is used again if it was made at a state near by
        (solvers.newton). A given inflow does not change. Raises ComputationError.
        """
        if self.bordered is None or self.linearised_as != (True, self.artificial_viscosity):
            self.linearise(self.forms.tangent)
        space, profile = self.space, self.boundaries.profile.x.array
        rights = [PETSc.Vec().createWithArray(load[space.free_dofs], comm=PETSc.COMM_SELF) for load in loads.T]
        on_border = np.zeros((len(rights), len(self.bordered.rows)))
        if self.boundaries.inflow is None:
            on_border[:, 0] = profile @ loads
        values = np.zeros(loads.shape)
        for k, (x, y) in enumerate(self.bordered.solve_all(rights, on_border)):
            values[space.free_dofs, k] = x.array_r
            if self.boundaries.inflow is None:
                values[space.inlet_dofs, k] = profile[space.inlet_dofs] * y[0]
            x.destroy()
        for right in rights:
            right.destroy()
        return values

    def acceleration(self):
        """New solvers.anderson.AndersonAcceleration for states of the free dofs and the inflow.

        It weighs velocities (m/s) by 1, pressures (Pa) by 1 / rho, and the inflow by 0.
        """
        weights = np.where(self.free_velocity, 1.0, 1.0 / self.forms.density)
        return anderson.AndersonAcceleration(np.append(weights, 0.0))

    def residual_is_small(self, norm, absolute, relative):
        """Whether the residual `norm` (N) meets both limits: `absolute` in N, `relative` times the pressure load."""
        return norm <= absolute and norm <= relative * self.pressure_load

    def outcome(self, norm, absolute, relative, iterations):
        """Outcome for a residual `norm` in N; it has converged if `residual_is_small`. iterations: factorizations."""
        return Outcome(self.residual_is_small(norm, absolute, relative), iterations, norm, norm / self.pressure_load)

    def report(self, norm, kind):
        """Notes the residual `norm` (N) in `residual_history`, and prints it with the words `kind` on the step."""
        self.residual_history.append(norm)
        flow = self.inflow / M3_PER_S_PER_ML_PER_MIN
        print(f"  residual {norm:.3e} N, {kind}, inflow {flow:.2f} mL/min", file=self.log, flush=True)

    def solve(self, resistances_at, predictor, stop_early=False):
        """Outcome at full flow: from the flow of the reduced models, if it is near enough, or else from rest.

        resistances_at(fraction) -> (n,) outlet resistances in Pa s/m3, as solvers.ramp needs them; predictor:
        reduced.coupled.Predictor. stop_early: a finer mesh follows. A single tube then tries the reduced models' flow
        alone, and in a tree continuation ends early (continuation.from_rest). Raises ComputationError when no flow with
        eps <= continuation.LARGEST_EPS is found.
        """
        outcome = predicted_start.try_predicted_flow(self, predictor)
        if outcome and outcome.converged:
            return outcome
        if predictor.covers_lumen:
            if stop_early:
                raise self.stall_error(outcome)
            self.set_to_rest()
            outcome = ramp.raise_flow(self, resistances_at)
            if outcome.converged:
                outcome.iterations = self.solver.factorizations
                return outcome
        self.set_to_rest()
        return continuation.from_rest(self, stop_early)

    def solve_from_guess(self, coarse, full_effort=False):
        """Outcome at full flow from the flow on another mesh of the same lumen, `coarse` (a solved FlowProblem).

        full_effort: eps is lowered further even if that mesh did not reach 0. If no flow is found, the state is set to
        rest and the result is None. Without `full_effort`, ComputationError is raised if no flow is found.
        """
        try:
            return continuation.from_guess(self, coarse, full_effort)
        except ComputationError:
            if not full_effort:
                raise
            self.flows_found.clear()
            self.set_to_rest()
            return None

    def solve_from_state(self, start):
        """Outcome at full flow, without artificial viscosity, from the flow of another state of the vessel.

        start: inputs.solution.StartState. Raises ComputationError where Newton's method does not converge from there.
        """
        self.boundaries.set_full_flow()
        self.forms.artificial_viscosity.value = 0.0
        self.set_flow(*start.fields_at(self.space.nodes()[0]), start.inflow)
        settings = self.settings
        outcome = newton.newton(self, settings.residual_absolute, settings.residual_relative, MOST_FROM_STATE)
        if not outcome.converged:
            raise self.stall_error(outcome)
        self.flows_found.append((0.0, self.state.x.array.copy(), self.inflow))
        outcome.iterations = self.solver.factorizations
        return outcome

    def stall_error(self, outcome):
        """ComputationError with the eps and the residual at which the solve ended.

        outcome: that of the last attempt, or None; then the residual is that of the present state.
        """
        norm = outcome.residual_absolute if outcome else self.residual_norm()
        return ComputationError(
            "the flow solver stalled",
            f"artificial viscosity {self.artificial_viscosity:.3g}, {self.solver.factorizations} factorizations",
            f"residual {norm:.3e} N, relative {norm / self.pressure_load:.3e}",
            "raise rings, cells_per_radius, outlet_extension_diameters or max_newton_iterations",
        )

    def destroy(self):
        """Frees PETSc's memory."""
        self.release()
        self.solver.destroy()
        for petsc_object in [self.full_residual] + self.columns_of_outlets:
            petsc_object.destroy()

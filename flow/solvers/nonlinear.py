"""The discrete flow problem with its boundaries, and the ways to its solution by Newton's method.

Unknowns are the velocity and pressure dofs x that no boundary fixes, the inflow Q, and the outlet pressures P_i. The
velocity at the inlet is Q g, with the profile g of physics.navier_stokes. The state always has P_i = P_v + R_i Q_i, so
these equations leave no residual. The equation of the inflow is the momentum equation tested with g: F(w; g) = MAP, in
Pa. Its residual times the inlet's area enters the norm in N, like the other residuals.

In a single tube, and in a tree that loses little pressure, Newton's method first starts from the flow of the reduced
models (solvers.predicted_start). If that fails in a single tube, the flow is raised from rest in steps (solvers.ramp).
If all this fails, and in other trees at once, an artificial viscosity is lowered step by step (solvers.continuation).
"""

import sys

import numpy as np
from dolfinx import fem

from common.errors import ComputationError
from flow.discretisation import forms, tangent
from flow.physics.units import M3_PER_S_PER_ML_PER_MIN
from flow.solvers import anderson, continuation, linear, newton, predicted_start, ramp

MOST_FROM_STATE = 6  # most factorizations from the flow of another state, before the flow is sought in the usual way


class FlowProblem:
    """The discrete equations of one lumen on a mesh, and the present flow.

    The flow is `state` (Function on space.W: velocity in m/s, pressure in Pa) and `inflow` in m3/s.

    space: discretisation.spaces.LumenSpace, whose W is the mixed space of velocity and pressure; boundaries:
    physics.outlets.Boundaries; document: content of boundary.json; earlier_factorizations: factorizations made on other
    meshes, which count against max_newton_iterations; log: stream for messages on progress.
    """

    def __init__(self, space, boundaries, document, settings, earlier_factorizations=0, log=None):
        self.allowed_factorizations = settings.max_newton_iterations - earlier_factorizations
        self.space, self.boundaries, self.settings, self.log = space, boundaries, settings, log or sys.stderr
        self.state = fem.Function(space.W)
        self.inflow = 0.0
        self.forms = forms.from_document(space, self.state, document, settings)
        self.free_velocity = np.isin(space.free_dofs, space.v_map)
        self.matrix = None  # discretisation.tangent.FreeMatrix
        self.solver = linear.DirectSolver()
        self.pressure_load = boundaries.pressure_load()
        self.residual_history = []
        self.bordered = None
        self.inertia = None  # solvers.marching.Inertia while the flow is marched in time
        self.flows_found = []  # (eps, values, inflow) of the flows found by continuation, the answer last

    @property
    def artificial_viscosity(self):
        """Factor eps of the artificial viscosity at the present state."""
        return float(self.forms.artificial_viscosity.value)

    @property
    def factorizations_left(self):
        """Factorizations that are still allowed."""
        return self.allowed_factorizations - self.solver.factorizations

    def move(self, base, base_inflow, update, inflow_update, factor):
        """Sets the flow to base (n,) over W plus factor times update, the change of the free dofs.

        The inflow in m3/s becomes base_inflow plus factor times inflow_update. It sets the velocity at the inlet.
        """
        values = base.copy()
        values[self.space.free_dofs] += factor * update
        self._set_values(values, base_inflow + factor * inflow_update)

    def _set_values(self, values, inflow):
        """Sets the state to values (n,) over W with the velocities at the inlet of an inflow in m3/s."""
        inlet, self.inflow = self.space.inlet_dofs, inflow
        values[inlet] = inflow * self.boundaries.profile[inlet]
        self.state.x.array[:] = values

    def set_to_rest(self):
        """Sets the flow to rest."""
        self.state.x.array[:] = 0.0
        self.inflow = 0.0

    def scale_flow(self, ratio):
        """Multiplies velocities and inflow by `ratio`, and pressure losses (MAP minus pressure) by its square."""
        values, pressure = self.state.x.array, self.space.q_map
        loss = values[pressure] - self.boundaries.map_pa
        values *= ratio
        values[pressure] = self.boundaries.map_pa + ratio**2 * loss
        self.inflow *= ratio

    def set_flow(self, velocity, pressure, inflow):
        """Sets the flow to velocity (n, 3) in m/s and pressure (n,) in Pa at the velocity nodes, and inflow in m3/s.

        Velocities on the wall are set to 0, those at the inlet to the profile of the inflow.
        """
        values = np.empty(self.space.dofs)
        values[self.space.v_map] = velocity.ravel()
        values[self.space.wall_dofs] = 0.0
        values[self.space.q_map] = self.space.corner_values(pressure)
        self._set_values(values, inflow)

    def set_guess(self, space, state, inflow):
        """Sets the flow to the flow on another mesh, interpolated to this mesh's nodes.

        state: values over W of that mesh's LumenSpace `space`; inflow in m3/s.
        """
        velocity, pressure, _ = space.sampler(state)(self.space.nodes()[0])
        self.set_flow(velocity, pressure, inflow)

    def velocity_norm(self, update):
        """Size of an update of the free dofs: the Euclidean norm of its nodal velocities in m/s, without pressures."""
        return float(np.linalg.norm(update[self.free_velocity]))

    def residual(self):
        """(residual (n,) in N at the free dofs, residual of the inflow's equation in Pa, norm of both in N).

        All are at the present state. The inflow's equation says that the mean inlet pressure is MAP. Also sets
        mean_inlet_pressure in Pa, the mean weighted with the profile g.
        """
        values, state = self.forms.assemble_residual(), self.state.x.array
        values += self.boundaries.pressures(self.boundaries.outflows(state)) @ self.boundaries.flux
        if self.inertia:
            self.inertia.add_force(values, state)
        self.mean_inlet_pressure = float(self.boundaries.profile @ values)
        inlet = self.mean_inlet_pressure - self.boundaries.map_pa
        free = values[self.space.free_dofs]
        return free, inlet, float(np.hypot(np.linalg.norm(free), inlet * self.boundaries.inlet_area))

    def linearise(self, form):
        """Factorizes the tangent at the present state, for `correction` and `responses`. Raises ComputationError.

        form: form of the tangent's velocity block, `tangent` (Newton) or `picard` of discretisation.forms.
        """
        if self.matrix is None:
            self.matrix = tangent.FreeMatrix(self.space, self.forms)
        self.bordered = None  # its borders belong to the matrix before
        self.matrix.assemble(form, self.inertia)
        self.solver.set_matrix(self.matrix.matrix)
        profile, free = self.boundaries.profile, self.space.free_dofs
        forward, backward = self.matrix.multiply(profile), self.matrix.multiply(profile, transposed=True)
        outlets = self.boundaries.flux[:, free]
        slopes = self.boundaries.pressure_slopes(self.boundaries.outflows(self.state.x.array))
        corner = np.diag([profile @ forward, *(-1.0 / slopes)])
        columns, rows = np.vstack([forward[free], outlets]).T, np.vstack([backward[free], outlets])
        self.bordered = linear.BorderedSystem(self.solver, columns, rows, corner)
        self.linearised_as = (form is self.forms.tangent, self.artificial_viscosity)

    def mark_outdated(self):
        """Marks the last factorization as made at a state too far from the present one for `responses`.

        `responses` then factorizes anew.
        """
        self.linearised_as = None

    def release(self):
        """Frees matrix and factors; the next linearisation makes them anew."""
        self.bordered = None
        self.solver.release()
        if self.matrix is not None:
            self.matrix.destroy()
        self.matrix = None

    def correction(self, residual, inlet):
        """(update of the free dofs (n,), update of the inflow in m3/s) by the last linearisation.

        residual, inlet: as `residual` returns them.
        """
        on_border = np.zeros((len(self.bordered.rows), 1))
        on_border[0] = inlet
        x, y = self.bordered.solve_for_correction(residual[:, None], on_border)
        return -x[:, 0], -float(y[0, 0])

    def responses(self, loads):
        """Solutions w (n, k) over W of K w = load, for loads (n, k) over W; K is Newton's tangent.

        w is the change of the flow by the load, to first order. The change of a quantity such as FFR is its derivative
        times w. The last factorization is used again if it was made at a state near by (solvers.newton). Raises
        ComputationError.
        """
        if self.bordered is None or self.linearised_as != (True, self.artificial_viscosity):
            self.linearise(self.forms.tangent)
        space, profile = self.space, self.boundaries.profile
        on_border = np.zeros((len(self.bordered.rows), loads.shape[1]))
        on_border[0] = profile @ loads
        x, y = self.bordered.solve(loads[space.free_dofs], on_border)
        values = np.zeros(loads.shape)
        values[space.free_dofs] = x
        values[space.inlet_dofs] = np.outer(profile[space.inlet_dofs], y[0])
        return values

    def acceleration(self):
        """New solvers.anderson.AndersonAcceleration for states of the free dofs and the inflow.

        It weighs velocities (m/s) by 1, pressures (Pa) by 1 / rho, and the inflow by 0.
        """
        weights = np.where(self.free_velocity, 1.0, 1.0 / self.forms.density)
        return anderson.AndersonAcceleration(np.append(weights, 0.0))

    def report(self, norm, kind):
        """Notes the residual `norm` (N) in `residual_history`, and prints it with the words `kind` on the step."""
        self.residual_history.append(norm)
        flow = self.inflow / M3_PER_S_PER_ML_PER_MIN
        print(f"  residual {norm:.3e} N, {kind}, inflow {flow:.2f} mL/min", file=self.log, flush=True)

    def solve(self, resistances_at, predictor, stop_early=False):
        """Outcome at full flow: from the flow of the reduced models, if it is near enough, or else from rest.

        resistances_at(fraction) -> (n,) outlet resistances in Pa s/m3, as solvers.ramp needs them; predictor:
        reduced.coupled.Predictor. stop_early: a finer mesh follows, so less is tried. In a single tube it is only the
        reduced models' flow. In a tree continuation ends early (continuation.from_rest). Raises ComputationError when
        no flow with eps <= continuation.LARGEST_EPS is found.
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
                return outcome
        self.set_to_rest()
        return continuation.from_rest(self, stop_early)

    def solve_from_guess(self, coarse, full_effort=False):
        """Outcome at full flow from the flow on another mesh of the same lumen, `coarse` (a solved FlowProblem).

        full_effort: eps is lowered further even if that mesh did not reach 0. If no flow is found, the state is then
        set to rest and the result is None. Without `full_effort`, ComputationError is raised if no flow is found.
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
        fields = start.fields_at(self.space.nodes()[0])
        outcome = newton.newton_from(self, fields, start.inflow, MOST_FROM_STATE)
        if not outcome.converged:
            raise self.stall_error(outcome)
        return outcome

    def stall_error(self, outcome):
        """ComputationError with the eps and the residual at which the solve ended.

        outcome: Outcome of the last attempt. If it is None, the residual is computed from the present state.
        """
        norm = outcome.residual_absolute if outcome else self.residual()[2]
        return ComputationError(
            "the flow solver stalled",
            f"artificial viscosity {self.artificial_viscosity:.3g}, {self.solver.factorizations} factorizations",
            f"residual {norm:.3e} N, relative {norm / self.pressure_load:.3e}",
            "raise rings, cells_per_radius, outlet_extension_diameters or max_newton_iterations",
        )

    def destroy(self):
        """Frees PETSc's memory."""
        self.release()

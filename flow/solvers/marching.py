"""Marching the flow in time by the two-step backward differentiation formula (BDF2) with steps of any length.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I (1993), chapter III.5. With w = dt / dt_before

    du/dt = (1 + 2 w) / (1 + w) u / dt - (1 + w) u_1 / dt + w^2 / (1 + w) u_2 / dt

where u_1 and u_2 are the velocities one and two steps ago. The first step is a backward Euler step. All other terms,
and the unknowns of the boundaries, are implicit as in the steady problem. Newton's method solves each step with an old
factorization of the tangent, and makes a new one where it converges too slowly. The error of a step follows from the
difference to the extrapolated flow. The caller (flow.audit) chooses the length of the next step by this error.
"""

import numpy as np
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from common.errors import ComputationError
from flow.discretisation import compat

RESIDUAL_TOLERANCE = 1e-5  # residual over the pressure load at which a step has converged
MOST_CORRECTIONS = 24  # most Newton corrections in one step
# An old factorization is used again while the factor of u in du/dt, over the factor at that factorization, lies between
# these.
REUSABLE_RATIO = (0.3, 3.0)
MOST_FACTORIZATIONS = 3  # most factorizations in one step
# A correction is slow if it leaves more than SLOW_REDUCTION of the residual. After more than MOST_SLOW_CORRECTIONS slow
# ones the tangent is factorized anew.
SLOW_REDUCTION, MOST_SLOW_CORRECTIONS = 0.5, 2
MANY_CORRECTIONS = 8  # after a step with more corrections the next step factorizes anew


class Inertia:
    """The force of inertia rho du/dt in a FlowProblem, mass (weight u - past_terms).

    `mass` is rho times the mass matrix. By the formula above du/dt is weight u - past_terms. `weight` in 1/s is the
    factor of u; `past_terms` (n,) in m/s2 are minus the terms with u_1 and u_2.
    """

    def __init__(self, problem):
        self.mass, self.v_map = compat.block_matrix(problem.forms.mass), problem.space.v_map
        fem_petsc.assemble_matrix(self.mass, problem.forms.mass)
        self.mass.assemble()
        self.weight = 0.0
        self.past_terms = np.zeros(problem.space.dofs)  # over W
        self._given, self._force = self.mass.createVecs()

    def add_force(self, residual, state):
        """residual += mass (weight state - past_terms), both arrays (n,) over W."""
        self._given.array[:] = (self.weight * state - self.past_terms)[self.v_map]
        self.mass.mult(self._given, self._force)
        residual[self.v_map] += self._force.array_r

    def add_tangent(self, velocity):
        """velocity += weight mass; velocity: PETSc matrix, the velocity block of the tangent."""
        velocity.axpy(self.weight, self.mass, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)

    def destroy(self):
        """Frees PETSc's memory."""
        for petsc_object in (self.mass, self._given, self._force):
            petsc_object.destroy()


class Stepper:
    """Marches a FlowProblem in time from its present state.

    time: time in s since the start; steps: number of steps done.
    """

    def __init__(self, problem):
        self.problem, self.time, self.steps = problem, 0.0, 0
        problem.inertia = self.inertia = Inertia(problem)
        self.last_values = [problem.state.x.array.copy()]  # values of up to three flows, the latest first
        self.last_inflows = [problem.inflow]
        self.last_steps = []
        self.factorized_weight, self.acceleration = None, problem.acceleration()

    def step(self, dt):
        """Makes a step of dt (s). Returns its error in m/s (root mean square over the nodes).

        The error is None in the first two steps. Where Newton's method fails, restores the state before the step and
        raises ComputationError.
        """
        problem = self.problem
        self._extrapolate(dt)
        guess = problem.state.x.array.copy()
        try:
            self._solve()
        except ComputationError:
            problem.state.x.array[:], problem.inflow = self.last_values[0], self.last_inflows[0]
            self.factorized_weight = None  # the factors may be the cause
            raise
        new = problem.state.x.array.copy()
        error = self._error(new - guess, dt) if len(self.last_values) == 3 else None
        self.last_values = [new, *self.last_values[:2]]
        self.last_inflows = [problem.inflow, *self.last_inflows[:2]]
        self.last_steps = [dt, *self.last_steps[:1]]
        self.time += dt
        self.steps += 1
        return error

    def _extrapolate(self, dt):
        """Sets the weights of BDF2, and as first guess of the state a parabola in time through the last three flows.

        With two flows it is a straight line, with one a constant.
        """
        problem, inertia = self.problem, self.inertia
        times = -np.cumsum([0.0, *self.last_steps])  # times in s of the flows, from the last one
        values, count = self.last_values, len(self.last_values)
        if count == 1:
            weights = [1.0, -1.0]
        else:
            ratio = dt / self.last_steps[0]
            weights = [(1 + 2 * ratio) / (1 + ratio), -(1 + ratio), ratio**2 / (1 + ratio)]
        inertia.weight = weights[0] / dt
        past_terms = sum(-weight / dt * value for weight, value in zip(weights[1:], values))
        inertia.past_terms = past_terms
        coefficients = [
            np.prod([(dt - times[k]) / (times[i] - times[k]) for k in range(count) if k != i]) for i in range(count)
        ]
        problem.state.x.array[:] = sum(s * value for s, value in zip(coefficients, values))
        problem.inflow = float(np.dot(coefficients, self.last_inflows))
        inlet = problem.space.inlet_dofs
        problem.state.x.array[inlet] = problem.inflow * problem.boundaries.profile[inlet]

    def _error(self, gap, dt):
        """Error of a BDF2 step in m/s; gap (n,): the new flow minus the extrapolated parabola, over W."""
        one, two = self.last_steps
        # for a flow that is cubic in time BDF2 and the parabola err in opposite directions, by u''' dt (dt + one) / 6
        # times these factors
        formula, parabola = dt * (one + dt) / (one + 2 * dt), dt + one + two
        velocity = gap[self.problem.space.v_map]
        return formula / (formula + parabola) * float(np.sqrt(3 * np.mean(velocity**2)))

    def _solve(self):
        """Newton's method with the last factorization and Anderson acceleration; factorizes anew where that is slow.

        Raises ComputationError where the residual stays above RESIDUAL_TOLERANCE times the pressure load.
        """
        problem, factorizations, slow_corrections = self.problem, 0, 0
        tolerance = RESIDUAL_TOLERANCE * problem.pressure_load
        free, inlet, norm = problem.residual()
        self.acceleration.skip_difference()
        for count in range(MOST_CORRECTIONS):
            if norm <= tolerance:
                if count > MANY_CORRECTIONS:
                    self.factorized_weight = None
                return
            if not self._factorization_fits() or slow_corrections > MOST_SLOW_CORRECTIONS:
                if factorizations == MOST_FACTORIZATIONS:
                    break
                self._factorize()
                factorizations, slow_corrections = factorizations + 1, 0
            last_norm = norm
            update, inflow_update = problem.correction(free, inlet)
            base, base_inflow = problem.state.x.array.copy(), problem.inflow
            step = self.acceleration.step(
                np.append(base[problem.space.free_dofs], base_inflow), np.append(update, inflow_update)
            )
            problem.move(base, base_inflow, step[:-1], step[-1], 1.0)
            free, inlet, norm = problem.residual()
            if not np.isfinite(norm):
                break
            slow_corrections += norm > max(SLOW_REDUCTION * last_norm, tolerance)
        self.factorized_weight = None
        raise ComputationError(
            "a step in time failed", f"{self.time:.4g} s", f"residual {norm:.3g} N", "a shorter step may help"
        )

    def _factorization_fits(self):
        """Whether there is a factorization, made for a step of about this length."""
        return (
            self.factorized_weight is not None
            and REUSABLE_RATIO[0] < self.inertia.weight / self.factorized_weight < REUSABLE_RATIO[1]
        )

    def _factorize(self):
        """Factorizes the tangent at the present state."""
        self.problem.linearise(self.problem.forms.tangent)
        self.factorized_weight, self.acceleration = self.inertia.weight, self.problem.acceleration()

    def destroy(self):
        """Makes the problem steady again and frees PETSc's memory."""
        self.problem.inertia = self.problem.bordered = None
        self.inertia.destroy()

"""The flow in a lumen as numbers: values over the space W and the inflow Q, taken, moved and scaled."""

import numpy as np

from flow.discretisation import compat
from flow.geometry import locate


class FlowState:
    """state (Function on space.W) and inflow (m3/s).

    A subclass sets space, boundaries and forms (discretisation.forms).
    """

    @property
    def artificial(self):
        """Factor eps of the artificial viscosity at the present state."""
        return float(self.forms.artificial.value)

    def move(self, base, base_inflow, update, inflow_update, factor):
        self.inflow = base_inflow + factor * inflow_update
        values = base.copy()
        values[self.space.free] += factor * update
        values[self.space.inlet] = self.inflow * self.boundaries.profile.x.array[self.space.inlet]
        self.state.x.array[:] = values

    def speed(self, update):
        """Size of an update of the free dofs: the norm of its velocities in m/s."""
        return float(np.linalg.norm(update[self.free_velocity]))

    def restart(self):
        """Back to rest."""
        self.state.x.array[:] = 0.0
        self.inflow = 0.0

    def scale_to(self, ratio):
        """Multiplies velocities by `ratio` and pressure losses by its square."""
        values, pressure = self.state.x.array, self.space.q_map
        loss = values[pressure] - self.boundaries.map_pa
        values *= ratio
        values[pressure] = self.boundaries.map_pa + ratio**2 * loss
        self.inflow *= ratio

    def state_vector(self):
        """The state's PETSc vector."""
        return compat.petsc_vector(self.state)

    def set_guess(self, space, state, inflow):
        """Takes a flow on another mesh as the first guess: `state` over that mesh's `space`, at this mesh's nodes."""
        points, _ = self.space.nodes()
        velocity, pressure, _ = locate.FieldSampler(space, state)(points)
        self.take(velocity, pressure, inflow)

    def take(self, velocity, pressure, inflow):
        """Takes velocity (n, 3) and pressure (n,) at the velocity nodes, and the inflow, as the state."""
        values = self.state.x.array
        values[self.space.v_map] = velocity.ravel()
        values[self.space.wall] = 0.0
        self.inflow = inflow
        values[self.space.inlet] = inflow * self.boundaries.profile.x.array[self.space.inlet]
        values[self.space.q_map] = self.space.corner_values(pressure)

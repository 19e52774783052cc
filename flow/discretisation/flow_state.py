"""The state of the discrete flow in a lumen: values over the space W and the inflow Q, and how they are set."""

import numpy as np

from flow.discretisation import compat
from flow.geometry import locate


class FlowState:
    """A flow: `state` (Function on space.W: velocity in m/s, pressure in Pa) and `inflow` (m3/s).

    A subclass sets space (spaces.LumenSpace), boundaries (physics.outlets.Boundaries), forms (forms.NavierStokes),
    state, inflow and free_velocity.
    """

    @property
    def artificial_viscosity(self):
        """Factor eps of the artificial viscosity at the present state."""
        return float(self.forms.artificial_viscosity.value)

    def move(self, base, base_inflow, update, inflow_update, factor):
        """Sets the flow to base (n,) over W plus factor times update, the change of the free dofs.

        base_inflow, inflow_update: likewise for the inflow in m3/s, which sets the velocity at the inlet.
        """
        self.inflow = base_inflow + factor * inflow_update
        values = base.copy()
        values[self.space.free_dofs] += factor * update
        values[self.space.inlet_dofs] = self.inflow * self.boundaries.profile.x.array[self.space.inlet_dofs]
        self.state.x.array[:] = values

    def velocity_norm(self, update):
        """Size of an update of the free dofs: the Euclidean norm of its nodal velocities in m/s, without pressures."""
        return float(np.linalg.norm(update[self.free_velocity]))

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

    def state_vector(self):
        """The state's PETSc vector."""
        return compat.petsc_vector(self.state)

    def set_guess(self, space, state, inflow):
        """Sets the flow to one of another mesh, interpolated to this mesh's nodes.

        state: values over W of that mesh's LumenSpace `space`; inflow in m3/s.
        """
        points, _ = self.space.nodes()
        velocity, pressure, _ = locate.FieldSampler(space, state)(points)
        self.set_flow(velocity, pressure, inflow)

    def set_flow(self, velocity, pressure, inflow):
        """Sets the flow to velocity (n, 3) in m/s and pressure (n,) in Pa at the velocity nodes, and inflow in m3/s.

        Velocities on the wall are set to 0, those at the inlet to the profile of the inflow.
        """
        values = self.state.x.array
        values[self.space.v_map] = velocity.ravel()
        values[self.space.wall_dofs] = 0.0
        self.inflow = inflow
        values[self.space.inlet_dofs] = inflow * self.boundaries.profile.x.array[self.space.inlet_dofs]
        values[self.space.q_map] = self.space.corner_values(pressure)

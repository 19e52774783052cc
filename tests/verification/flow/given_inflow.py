"""Flows with a given inflow, for comparisons with other programs: python3 .../given_inflow.py solve ...

Runs the command line of `flow` with an outlet whose resistance is STIFFNESS times that of boundary.json. The pressure
behind the resistance is lowered so that the outlet still has its planned pressure P_v + R Q at its planned flow Q. A
pressure drop in the lumen then changes the flow STIFFNESS times less than with the resistance of boundary.json. The
mean pressure at the inlet stays MAP.
"""

import pathlib
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[3])]

from flow import __main__ as command_line  # noqa: E402
from flow.physics import outlets  # noqa: E402

STIFFNESS = 1e5


class GivenInflow(outlets.Boundaries):
    """physics.outlets.Boundaries of a lumen with one outlet, through which the planned flow passes."""

    def __init__(self, space, document):
        (outlet,) = document["outlets"]
        resistance, self.planned = outlet["resistance_pa_s_per_m3"], outlet["flow_m3_per_s"]
        self.outlet_pa = document["venous_pressure_pa"] + resistance * self.planned
        outlet = outlet | {"resistance_pa_s_per_m3": STIFFNESS * resistance}
        super().__init__(space, document | {"outlets": [outlet]})

    def set_flow(self, flow):
        """Sets the flow in m3/s that must pass the outlet."""
        self.venous_pa = self.outlet_pa - self.resistance[0] * flow

    def set_full_flow(self):
        """Sets the planned flow."""
        super().set_full_flow()
        self.set_flow(self.planned)

    def set_flow_fraction(self, fraction, resistances_at):
        """Sets a fraction of the planned flow."""
        self.set_flow(fraction * self.planned)

    def pressure_load(self):
        """Norm in N of the loads of MAP and of the outlet's pressure."""
        of_outlet = np.linalg.norm(self.flux[0, self.space.free_dofs]) * self.outlet_pa
        return float(np.hypot(of_outlet, self.map_pa * self.inlet_area))


if __name__ == "__main__":
    outlets.Boundaries = GivenInflow
    command_line.main()

"""The boundaries' unknowns: inflow at given mean pressure, outlet pressures behind resistances, coupled exactly."""

import numpy as np

from common.errors import InputError
from flow.mesh import PHYSICAL_INLET, physical_tag


class Boundaries:
    """Inlet at MAP and outlets with resistances on a LumenSpace.

    profile: Function, unit inflow; flux: [vector of outlet i]; resistance (n,), venous, map in SI.
    """

    def __init__(self, space, document):
        self.space = space
        outlets = {physical_tag(outlet["region_id"]): outlet for outlet in document["outlets"]}
        if sorted(outlets) != space.outlets:
            have, need = space.outlets, sorted(outlets)
            raise InputError(
                "mesh and boundary values differ", "outlets", f"mesh {have}, boundary {need}", "match them"
            )
        self.names = [outlets[tag]["name"] for tag in space.outlets]
        self.full_resistance = np.array([outlets[tag]["resistance_pa_s_per_m3"] for tag in space.outlets])
        self.planned_flow = np.array([outlets[tag]["flow_m3_per_s"] for tag in space.outlets])
        self.map_pa, self.venous_pa = document["map_pa"], document["venous_pressure_pa"]
        self.profile = space.inlet_profile()
        self.flux = [space.flux_vector(tag) for tag in space.outlets]
        self.inlet_area = space.area(PHYSICAL_INLET)
        self.resistance = self.full_resistance.copy()

    def outflows(self, vector):
        """Flow through each outlet in m3/s of a state's vector."""
        return np.array([flux.dot(vector) for flux in self.flux])

    def pressures(self, outflows):
        """P_i = P_v + R_i Q_i."""
        return self.venous_pa + self.resistance * outflows

    def destroy(self):
        for vector in self.flux:
            vector.destroy()

"""Conditions at inlet and outlets: the mean inlet pressure is MAP, and each outlet has a resistance.

The inflow and the outlet pressures are unknowns of the same nonlinear system as the flow.
"""

import numpy as np

from common.errors import InputError
from flow.geometry.tags import PHYSICAL_INLET, physical_tag
from flow.physics.units import M_PER_MM


def check_outlet_places(space, document, tree, where):
    """Raises InputError unless each outlet of the mesh file `where` lies at the end of its branch.

    An outlet must be nearer to that end than to the tree's other ends and its inlet. Otherwise mesh and boundary values
    number the outlets differently, and resistances would be exchanged unnoticed. space: LumenSpace on the mesh;
    document: content of boundary.json; tree: geometry.centreline.Tree with the mesh's extensions.
    """
    ends = {f"the end of {branch.name}": branch.point(branch.length_mm) for branch in tree}
    ends["the inlet"] = tree.main.point(0.0)
    for one in document["outlets"]:
        own, centre = f"the end of {one['branch']}", space.centre(physical_tag(one["region_id"])) / M_PER_MM
        found = min(ends, key=lambda end: np.linalg.norm(ends[end] - centre))
        if found != own:
            remedy = f"it should be {own}: give mesh, centreline and boundary values of one patient, numbered alike"
            raise InputError("outlet is at another end of the tree", f"{where}: {one['name']}", f"at {found}", remedy)


class Boundaries:
    """The conditions of boundary.json's document at inlet and outlets of a LumenSpace, in SI units.

    The outlet pressures are P_i = P_v + resistance[i] Q_i. profile (n,): the velocity g over W of an inflow of 1 m3/s;
    flux (o, n): matrix whose product with a state gives the flows through the o outlets.
    """

    def __init__(self, space, document):
        self.space = space
        outlets = {physical_tag(outlet["region_id"]): outlet for outlet in document["outlets"]}
        if sorted(outlets) != space.outlet_tags:
            have, need = space.outlet_tags, sorted(outlets)
            raise InputError(
                "mesh and boundary values differ", "outlets", f"mesh {have}, boundary {need}", "match them"
            )
        self.outlet_names = [outlets[tag]["name"] for tag in space.outlet_tags]
        self.full_resistance = np.array([outlets[tag]["resistance_pa_s_per_m3"] for tag in space.outlet_tags])
        self.map_pa, self.venous_pa = document["map_pa"], document["venous_pressure_pa"]
        self.profile = space.inlet_profile()
        self.flux = np.array([space.flux_vector(tag) for tag in space.outlet_tags])
        self.inlet_area = space.area(PHYSICAL_INLET)
        self.set_full_flow()

    def set_full_flow(self):
        """Sets the outlet resistances of boundary.json, also after `set_flow_fraction` has changed them."""
        self.resistance = self.full_resistance

    def set_flow_fraction(self, fraction, resistances_at):
        """Sets outlet resistances under which about `fraction` of the full flow passes.

        resistances_at(fraction) -> (n,) in Pa s/m3.
        """
        self.resistance = resistances_at(fraction)

    def pressure_load(self):
        """Norm in N of the pressure load at rest, MAP on the inlet and P_v on the outlets, the measure of residuals."""
        of_outlets = np.linalg.norm(self.flux[:, self.space.free_dofs], axis=1) * self.venous_pa
        return float(np.linalg.norm([*of_outlets, self.map_pa * self.inlet_area]))

    def outflows(self, state):
        """Flow (o,) in m3/s through the outlets at a state (n,) over W."""
        return self.flux @ state

    def pressures(self, outflows):
        """Outlet pressures P_i (o,) in Pa at outflows (o,) in m3/s."""
        return self.venous_pa + self.resistance * outflows

    def pressure_slopes(self, outflows):
        """dP_i/dQ_i (o,) in Pa s/m3 at outflows (o,) in m3/s, which Newton's method and the error estimate need."""
        return np.broadcast_to(self.resistance, np.shape(outflows))

"""Conditions at inlet and outlets: the mean inlet pressure is MAP, and each outlet has a resistance.

The inflow and the outlet pressures are unknowns of the same nonlinear system as the flow. Instead of MAP the inflow may
be given (`inlet_flow_m3_per_s` of boundary.json). Instead of a resistance an outlet may have a given pressure
(`pressure_pa`, in place of P_v and with resistance 0).
"""

import numpy as np

from common.errors import InputError
from flow.geometry.tags import PHYSICAL_INLET, physical_tag
from flow.physics.units import M_PER_MM


def check_outlet_places(space, document, tree, where):
    """Raises InputError unless each outlet of the mesh file `where` lies at the end of its branch.

    An outlet must be nearer to that end than to the tree's other ends and its inlet. Otherwise mesh and boundary values
    number the outlets differently, and resistances would be exchanged unnoticed. space: LumenSpace on the mesh;
    document: of boundary.json; tree: geometry.centreline.Tree with the mesh's extensions.
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

    profile: Function on the mixed space W, the velocity g of an inflow of 1 m3/s; flux: [vector over W whose product
    with a state is the flow through outlet i]; inflow: the given flow, or None if the inlet is at MAP. The outlet
    pressures are P_i = downstream[i] + resistance[i] Q_i.
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
        self.map_pa = document["map_pa"]
        venous = document["venous_pressure_pa"]
        self.full_downstream = np.array([outlets[tag].get("pressure_pa", venous) for tag in space.outlet_tags])
        self.full_inflow = document.get("inlet_flow_m3_per_s")
        self.profile = space.inlet_profile()
        self.flux_vectors = [space.flux_vector(tag) for tag in space.outlet_tags]
        self.inlet_area = space.area(PHYSICAL_INLET)
        self.set_full_flow()

    def set_full_flow(self):
        """Sets the conditions of boundary.json, also after `set_flow_fraction` has changed them."""
        self.resistance, self.downstream = self.full_resistance.copy(), self.full_downstream.copy()
        self.inflow = self.full_inflow

    def set_flow_fraction(self, fraction, resistances_at):
        """Sets conditions under which about `fraction` of the full flow passes.

        resistances_at(fraction) -> outlet resistances (n,) in Pa s/m3, used if the inlet is at MAP and every outlet has
        a resistance.
        """
        self.set_full_flow()
        if self.inflow is not None:
            self.inflow *= fraction
        elif (self.resistance > 0).all():
            self.resistance = resistances_at(fraction)
        else:
            self.resistance /= fraction
            self.downstream = self.map_pa - fraction * (self.map_pa - self.downstream)

    def pressure_load(self, columns):
        """Norm in N of the pressure load at rest: MAP on the inlet, P_v or the given pressure on the outlets.

        columns: [flux vector of outlet i, at the free dofs]. Residuals are compared with this load.
        """
        parts = [column.norm() * pressure for column, pressure in zip(columns, self.downstream)]
        return float(np.linalg.norm(parts + [self.map_pa * self.inlet_area]))

    def outflows(self, vector):
        """Flow (n,) in m3/s through the outlets; vector: PETSc vector of a state over W."""
        return np.array([flux.dot(vector) for flux in self.flux_vectors])

    def pressures(self, outflows):
        """Outlet pressures P_i (n,) in Pa at outflows (n,) in m3/s."""
        return self.downstream + self.resistance * outflows

    def destroy(self):
        """Frees PETSc's memory."""
        for vector in self.flux_vectors:
            vector.destroy()

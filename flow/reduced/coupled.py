"""The 1D network with the axisymmetric model in the branch of the probe `distal`: a fast FFR, and a flow to start from.

The axisymmetric model is solved at the flows that the network gives. The two models differ in the pressure loss along
the branch. This difference is added to the network's loss, growing with the square of the flow, and the network is
solved again. This is repeated until the flows no longer change.
"""

import sys
import time

import numpy as np
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator
from scipy.spatial import cKDTree

from common.errors import ComputationError
from flow.physics import viscosity
from flow.physics.units import M3_PER_S_PER_ML_PER_MIN, M_PER_MM
from flow.reduced.axisymmetric import Tube
from flow.meshing.sweep import stations

CELL_LENGTH_FACTOR = (
    0.5  # length of a cell of the axisymmetric model over the distance of sections in the swept 3D mesh
)
# Most rounds of the coupling. It ends when no outlet's flow changes by more than FLOW_TOLERANCE of the total flow.
MOST_ROUNDS, FLOW_TOLERANCE = 12, 1e-5
LEFT_PARENT_RADII = (
    1.0  # a side branch is outside its parent when its axis is this many parent radii from the parent's axis
)
SHORTEST_RADII = 4.0  # least length, over the radius at its start, of a branch that gets an axisymmetric model


class Predictor:
    """The answer of the two models for one lumen: FFR, and velocity and pressure at any point.

    Results of the coupled models: flows (outlets,) in m3/s, pressures {branch: (s in m, pressure in Pa)}. Results of
    the network by itself: network_flows, network_pressures. With coupled = False the axisymmetric model is not used.
    Then, or if it finds no flow, `tube` is None and `reason` says why; flows and pressures are the network's. Raises
    ComputationError where the network has no solution.
    """

    def __init__(self, network, tree, document, settings, coupled=True):
        self.network, self.tree, self.document = network, tree, document
        self.network_flows = self.flows = network.solve()
        self.network_pressures = self.pressures = network.pressures(self.flows)
        self.tube, self.reason, begin = None, None, time.process_time()
        self.branch, self.s_probe_mm, _ = tree.project_probe(document["probes"][0])
        self.radius_mm = {name: _radius_function(*profile) for name, profile in network.area_profile.items()}
        if not coupled:
            self.reason, self.cpu_seconds = "not asked for", 0.0
            return
        try:
            self._couple(settings)
        except ComputationError as error:
            self.reason, self.flows, self.pressures = str(error), self.network_flows, self.network_pressures
            print(f"the axisymmetric model gives no answer:\n{error}", file=sys.stderr, flush=True)
        self.cpu_seconds = time.process_time() - begin

    def _couple(self, settings):
        """Repeats the coupling until the flows agree. Raises ComputationError where they do not."""
        network, name = self.network, self.branch.name
        self.start_mm = self._exit_from_parent_mm()
        tube, outlets_fed, total = self._make_tube(settings), network.downstream(name, 0.0), float(np.sum(self.flows))
        flows = self.flows
        for _ in range(MOST_ROUNDS):
            tube.solve(flows[outlets_fed].sum(), [flows[one].sum() for one in self.leak_outlets])
            s, drop = tube.axis_pressure()
            own_s, own = network.pressures(flows)[name]
            missing_loss = np.interp(s, own_s, own) - np.interp(s[0], own_s, own) - drop
            network.add_loss(name, s, missing_loss, flows[outlets_fed].sum())
            before, flows = flows, network.solve()
            if np.abs(flows - before).max() < FLOW_TOLERANCE * total:
                self.tube, self.flows = tube, flows
                self.pressures = network.pressures(flows)
                return
        network.added_losses.clear()
        network.solve()
        raise ComputationError(
            "the axisymmetric model and the network do not agree on a flow",
            f"branch {name}",
            f"change {np.abs(flows - before).max() / M3_PER_S_PER_ML_PER_MIN:.3g} mL/min",
            "check sections.csv",
        )

    def _exit_from_parent_mm(self):
        """Arc length in mm at which the branch has left its parent, at most half its length; 0 for the root branch."""
        if self.branch.name == self.network.root:
            return 0.0
        parent, where = self.network.parent[self.branch.name]
        return min(LEFT_PARENT_RADII * float(self.radius_mm[parent](where)), 0.5 * self.branch.length_mm)

    def _make_tube(self, settings):
        """The Tube of the branch of `distal`, from where it has left its parent to its end."""
        name = self.branch.name
        s_mm, _ = self.network.area_profile[name]
        end_mm = min(self.branch.length_mm, float(s_mm[-1]))
        radius = self.radius_mm[name]
        if end_mm - self.start_mm < SHORTEST_RADII * radius(self.start_mm):
            raise ComputationError("branch too short for a model of its own", name, f"{end_mm:.1f} mm", "none needed")
        at = stations.place_stations(self.branch, settings, self.start_mm, end_mm, CELL_LENGTH_FACTOR)
        s_mm = np.sort(np.concatenate([at, 0.5 * (at[1:] + at[:-1])]))
        leaks, self.leak_outlets = [], []
        for where, child in self.network.children[name]:
            outside = min(float(radius(where)), 0.5 * self.tree[child].length_mm)
            leaks.append((where * M_PER_MM, 2.0 * self.tree[child].radius(outside) * M_PER_MM))
            self.leak_outlets.append(self.network.downstream(child, 0.0))
        return Tube(
            s_mm * M_PER_MM,
            radius(s_mm) * M_PER_MM,
            leaks,
            self.document["density_kg_per_m3"],
            viscosity.from_document(self.document),
            settings.backflow_coefficient,
        )

    @property
    def covers_lumen(self):
        """Whether the axisymmetric model covers the whole lumen: it has a flow, and the lumen is a single branch."""
        return self.tube is not None and len(self.network.area_profile) == 1

    def destroy(self):
        """Frees PETSc's memory."""
        if self.tube is not None:
            self.tube.destroy()

    def ffr(self, pressures):
        """FFR at the probe `distal`, by pressures {branch: (s in m, pressure in Pa)}."""
        return float(np.interp(self.s_probe_mm * M_PER_MM, *pressures[self.branch.name]) / self.document["map_pa"])

    def answers(self):
        """Entries `network` and `axisymmetric` of ffr.json's `models`."""
        network = {"ffr": self.ffr(self.network_pressures), "outlet_flows_m3_per_s": self.network_flows.tolist()}
        if self.tube is None:
            return {"network": network, "axisymmetric": {"ffr": None, "reason": self.reason}}
        axisymmetric = {"ffr": self.ffr(self.pressures), "outlet_flows_m3_per_s": self.flows.tolist()}
        axisymmetric.update(branch=self.branch.name, dofs=self.tube.dofs, cpu_seconds=self.cpu_seconds)
        return {"network": network, "axisymmetric": axisymmetric}

    def fields(self, points):
        """(velocity (m, 3) in m/s, pressure (m,) in Pa) at points (m, 3) in m.

        In the branch of the axisymmetric model, from start_mm on, both are taken from that model. Elsewhere the
        velocity has a parabolic profile, and the pressure is that of the 1D network.
        """
        velocity, pressure = np.zeros_like(points), np.zeros(len(points))
        owner = self._nearest_branches(points / M_PER_MM)
        for number, branch in enumerate(self.tree):
            mine = np.flatnonzero(owner == number)
            s, along, outward, rho = self._local_coordinates(branch, points[mine] / M_PER_MM)
            flow = np.array([self.flows[self.network.downstream(branch.name, x)].sum() for x in np.unique(s)])
            flow = flow[np.unique(s, return_inverse=True)[1]]
            area = np.pi * (self.radius_mm[branch.name](s) * M_PER_MM) ** 2
            axial, radial = 2.0 * flow / area * (1.0 - rho**2), np.zeros(len(s))
            pressure[mine] = np.interp(s * M_PER_MM, *self.pressures[branch.name])
            if self.tube is not None and branch.name == self.branch.name:
                inside = s >= self.start_mm
                axial[inside], radial[inside], pressure[mine[inside]] = self._tube_fields(s[inside], rho[inside])
            velocity[mine] = axial[:, None] * along + radial[:, None] * outward
        return velocity, pressure

    def _tube_fields(self, s_mm, rho):
        """(axial, radial velocity in m/s, pressure in Pa), each (m,), of the axisymmetric model.

        s_mm: arc lengths (m,) in the branch; rho: distances (m,) from the axis over the local radius.
        """
        s, across, *grids = self.tube.fields()
        at = np.stack([np.clip(s_mm * M_PER_MM, s[0], s[-1]), rho], axis=1)
        axial, radial, drop = (RegularGridInterpolator((s, across), grid)(at) for grid in grids)
        return axial, radial, drop + np.interp(s[0], *self.pressures[self.branch.name])

    def _nearest_branches(self, points_mm):
        """Number (m,) in the tree of the branch whose axis is nearest to each of points (m, 3).

        The part of a branch's axis that lies inside its parent does not count.
        """
        kept, number = [], []
        for k, branch in enumerate(self.tree):
            outside = np.ones(len(branch.points), bool)
            if branch.name != self.network.root:
                outside = branch.outside_parent(self.tree[self.network.parent[branch.name][0]], LEFT_PARENT_RADII)
            kept.append(branch.points[outside])
            number.append(np.full(outside.sum(), k))
        _, nearest = cKDTree(np.concatenate(kept)).query(points_mm)
        return np.concatenate(number)[nearest]

    def _local_coordinates(self, branch, points_mm):
        """(s in mm (m,), unit vectors along the axis (m, 3), away from it (m, 3), rho (m,)) of points (m, 3) in mm.

        rho is the distance from the branch's axis over its radius, at most 1.
        """
        slope = np.gradient(branch.points, branch.s_mm, axis=0)
        slope /= np.linalg.norm(slope, axis=1)[:, None]
        _, sample = cKDTree(branch.points).query(points_mm)
        step = np.einsum("ij,ij->i", points_mm - branch.points[sample], slope[sample])
        s = np.clip(branch.s_mm[sample] + step, 0.0, branch.length_mm)
        along = slope[sample]
        gap = points_mm - branch.points[sample] - step[:, None] * along
        distance = np.linalg.norm(gap, axis=1)
        outward = gap / np.maximum(distance, 1e-12)[:, None]
        return s, along, outward, np.minimum(distance / self.radius_mm[branch.name](s), 1.0)


def _radius_function(s_mm, area_mm2):
    """Function of s in mm: smoothly interpolated radius in mm of the circle with the area of the section.

    Beyond the first and the last section the radius is constant.
    """
    smooth = PchipInterpolator(s_mm, np.sqrt(area_mm2 / np.pi))
    return lambda s: smooth(np.clip(s, s_mm[0], s_mm[-1]))

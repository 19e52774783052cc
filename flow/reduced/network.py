"""1D network: steady flow through the cross-sections of the tree.

A segment is a piece of a branch between two junctions. Along it the flow Q is constant. With the area A(s), the static
pressure p and U = Q / A:

    p(s) = p(0) - 8 pi Q int mu ds / A^2 - rho/2 (U(s)^2 - U(0)^2) - sum over expansions K rho/2 (U_t - U(s))^2

mu is the viscosity (physics.viscosity) at the wall shear rate 4 U / R of a parabolic profile. t is the narrowest
section before an expansion. K is the setting expansion_loss (1.14: Borda-Carnot with the jet's profile). Total pressure
p + rho/2 U^2 is equal on both sides of a junction, so a junction itself loses nothing. The outlets have p_i = P_v +
R_i Q_i.
"""

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from common.errors import ComputationError, InputError
from flow.physics.units import M_PER_MM
from flow.physics import viscosity as viscosities

END_DISTANCE_RADII = 2.0  # largest distance of the last section from the branch's end, in radii
# Limits of a section's radius sqrt(A / pi) over the radius of the largest inscribed sphere. In the study this ratio is
# 1.00 to 1.15, at ostia 1.4.
LEAST_RADIUS_RATIO, LARGEST_RADIUS_RATIO = 0.8, 2.5
PROMINENCE = 1.1  # factor by which the area must grow behind a narrowing, and shrink again before the next one


class Segment:
    """Piece of a branch between two junctions: s (n,) in m, area (n,) in m2, indices of all outlets downstream."""

    def __init__(self, branch, s, area, outlets):
        self.branch, self.s, self.area, self.outlets = branch, s, area, outlets
        self.throat_index = _throat_of_each_section(area)

    def losses(self, flow, density, viscosity, expansion_loss):
        """Static pressure at the segment's start minus the static pressure at each section, (n,) in Pa.

        flow in m3/s; density in kg/m3; viscosity: law of physics.viscosity; expansion_loss: K.
        """
        velocity = flow / self.area
        wall_rate = 4 * abs(velocity) * np.sqrt(np.pi / self.area)
        slope = 8 * np.pi * viscosity(wall_rate) * flow / self.area**2
        friction = np.concatenate([[0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(self.s))])
        dynamic = 0.5 * density * (velocity**2 - velocity[0] ** 2)
        expansion = np.zeros_like(velocity)
        loss_before, current = 0.0, -1
        for k, throat in enumerate(self.throat_index):
            if throat != current:
                loss_before, current = expansion[k - 1] if k else 0.0, throat
            jet = 0.0 if throat < 0 else max(velocity[throat] - velocity[k], 0.0)
            expansion[k] = loss_before + 0.5 * expansion_loss * density * jet**2
        return friction + dynamic + np.maximum.accumulate(expansion)


def _throat_of_each_section(area):
    """For each section the index of the narrowing in whose jet it lies, (n,); -1 for none. area (n,) in m2.

    The sections are walked downstream. `low` is the section of least area so far. It is a narrowing once the area
    behind it exceeds PROMINENCE times its area. From then on `high` is the section of largest area. The jet ends at the
    first section with less than 1 / PROMINENCE of the area of `high`. There the search for the next `low` begins.
    """
    throat = np.full(len(area), -1)
    low = high = 0
    rising = False
    for k in range(1, len(area)):
        if rising:
            if area[k] > area[high]:
                high = k
            if area[k] * PROMINENCE < area[high] or k == len(area) - 1:
                throat[low : k + 1] = low
                low, rising = k, False
        else:
            if area[k] <= area[low]:
                low = k
            if area[k] > PROMINENCE * area[low]:
                high, rising = k, True
    if rising:
        throat[low:] = low
    return throat


class Network:
    """The 1D network of one tree.

    anatomy: document of anatomy.json; sections: table of `read_sections`; document: content of boundary.json;
    expansion_loss: K. Raises InputError where anatomy, sections and outlets disagree.
    """

    def __init__(self, anatomy, sections, document, expansion_loss):
        self.document, self.expansion_loss = document, expansion_loss
        self.viscosity = viscosities.from_document(document)
        self.outlets = document["outlets"]
        branches = {branch["name"]: branch for branch in anatomy["branches"]}
        self.children, self.parent = {name: [] for name in branches}, {}  # each with the place s_mm on the parent
        for branch in branches.values():
            if branch["parent"]:
                self.parent[branch["name"]] = branch["parent"], branch["s_on_parent_mm"]
                self.children[branch["parent"]].append((branch["s_on_parent_mm"], branch["name"]))
        self.area_profile = {}
        for name in branches:
            rows = sections[sections["branch"] == name].sort_values("s_mm")
            if len(rows) < 2:
                raise InputError("branch without cross-sections", "sections.csv", name, "run the anatomy step again")
            self.area_profile[name] = rows["s_mm"].to_numpy(), rows["area_mm2"].to_numpy()
        self.resistance = np.array([outlet["resistance_pa_s_per_m3"] for outlet in self.outlets])
        self.outlet_names = [outlet["name"] for outlet in self.outlets]
        self.outlet_index = {outlet["branch"]: k for k, outlet in enumerate(self.outlets)}
        alone = sorted(set(self.outlet_index) ^ set(branches))
        if alone:
            what = "outlet without a branch, or branch without an outlet"
            raise InputError(what, "boundary.json", alone, "make it from this anatomy")
        self.added_losses = {}
        self.segments = []
        self.root = next(name for name, branch in branches.items() if not branch["parent"])
        self._add_segments(self.root, 0.0)

    def downstream(self, branch, s_mm):
        """Indices of the outlets fed through `branch` at arc length s_mm.

        They are the branch's own outlet, and those of side branches there or further downstream.
        """
        found = [self.outlet_index[branch]]
        for where, child in self.children[branch]:
            if where >= s_mm:
                found += self.downstream(child, 0.0)
        return found

    def _add_segments(self, branch, start_mm):
        """Adds the segments of a branch from start_mm on, and those of its side branches."""
        s, area = self.area_profile[branch]
        cuts = sorted({float(where) for where, _ in self.children[branch] if s[0] < where < s[-1]})
        bounds = [max(start_mm, s[0])] + cuts + [s[-1]]
        for a, b in zip(bounds, bounds[1:]):
            inner = (s > a) & (s < b)
            here = np.concatenate([[a], s[inner], [b]])
            values = np.interp(here, s, area)
            outlets = self.downstream(branch, 0.5 * (a + b))
            self.segments.append(Segment(branch, here * M_PER_MM, values * M_PER_MM**2, outlets))
        for _, child in sorted(self.children[branch]):
            self._add_segments(child, 0.0)

    def pressures(self, flows):
        """Static pressure along each branch, from MAP at the inlet: {branch: (s (n,) in m, pressure (n,) in Pa)}.

        flows: flow through each outlet (outlets,) in m3/s.
        """
        document, result, total_at = self.document, {}, {}
        for segment in self.segments:
            flow = flows[segment.outlets].sum()
            velocity = flow / segment.area
            if segment.branch in result:
                start = result[segment.branch][1][-1] + 0.5 * document["density_kg_per_m3"] * (
                    total_at[segment.branch] - velocity[0] ** 2
                )
            elif segment.branch == self.root:
                start = document["map_pa"]
            else:
                start = self._at_junction(segment, result, flows, velocity[0])
            loss = segment.losses(flow, document["density_kg_per_m3"], self.viscosity, self.expansion_loss)
            loss += self._added_loss(segment, flows)
            s, p = result.get(segment.branch, (np.zeros(0), np.zeros(0)))
            result[segment.branch] = np.concatenate([s, segment.s]), np.concatenate([p, start - loss])
            total_at[segment.branch] = velocity[-1] ** 2
        return result

    def add_loss(self, branch, s, pressure, flow):
        """Adds `pressure` (n,) in Pa to the loss from the branch's start to the places s (n,) in m.

        This loss holds at the branch's flow `flow` (m3/s), and grows with the square of the flow. Losses that were
        added before stay.
        """
        if branch in self.added_losses:
            pressure = pressure + self.added_losses[branch][1] * (flow / self.added_losses[branch][2]) ** 2
        self.added_losses[branch] = s, pressure, flow

    def _added_loss(self, segment, flows):
        """Loss added by `add_loss` from the segment's start to each of its sections, (n,) in Pa, at these flows."""
        if segment.branch not in self.added_losses:
            return 0.0
        s, pressure, flow = self.added_losses[segment.branch]
        here = np.interp(segment.s, s, pressure)
        return (here - here[0]) * (flows[self.downstream(segment.branch, 0.0)].sum() / flow) ** 2

    def _at_junction(self, segment, result, flows, velocity):
        """Static pressure in Pa at the start of a side branch, from its parent's total pressure before the junction.

        result: pressures so far, as `pressures` gives them; velocity: velocity in m/s at the side branch's start. The
        parent has two pressures at the junction, before and behind it, since its flow and with it its head fall there.
        """
        parent, where = self.parent[segment.branch]
        s, p = result[parent]
        area = np.interp(where, *self.area_profile[parent]) * M_PER_MM**2
        upstream = flows[self.downstream(parent, where)].sum() / area
        static = p[min(np.searchsorted(s, where * M_PER_MM), len(p) - 1)]
        return static + 0.5 * self.document["density_kg_per_m3"] * (upstream**2 - velocity**2)

    def outlet_pressures(self, flows):
        """Static pressure (outlets,) in Pa at the outlets; flows as for `pressures`."""
        result = self.pressures(flows)
        return np.array([result[outlet["branch"]][1][-1] for outlet in self.outlets])

    def solve(self):
        """Outlet flows (outlets,) in m3/s at which each outlet has the pressure P_v + R_i Q_i.

        Raises ComputationError.
        """
        map_pa, venous_pa = self.document["map_pa"], self.document["venous_pressure_pa"]
        most = (map_pa - venous_pa) / self.resistance  # flows if the vessels lost no pressure

        def imbalance(share):
            flows = share * most
            return (self.outlet_pressures(flows) - venous_pa - self.resistance * flows) / map_pa

        start = np.full(len(most), 0.8)
        found = least_squares(imbalance, start, bounds=(0, 1.2), xtol=1e-13, ftol=1e-13, gtol=1e-13)
        if np.abs(found.fun).max() > 1e-6:
            raise ComputationError(
                "reduced model did not converge",
                "reduced network",
                np.abs(found.fun).max(),
                "check sections.csv (mm) and the resistances of boundary.json (Pa s/m3)",
            )
        return found.x * most

    def resistances_at(self, flows, fraction):
        """Outlet resistances (outlets,) in Pa s/m3 at which this model's flows are `fraction` times `flows` (m3/s)."""
        if fraction == 1.0:
            return self.resistance
        return (self.outlet_pressures(fraction * flows) - self.document["venous_pressure_pa"]) / (fraction * flows)


def read_sections(path):
    """sections.csv as a DataFrame with branch, s_mm (arc length) and area_mm2. Raises InputError."""
    remedy = "run the anatomy step"
    try:
        table = pd.read_csv(path)
    except FileNotFoundError as error:
        raise InputError("no such file of cross-sections", path, "missing", remedy) from error
    except (OSError, ValueError) as error:  # an empty file, no text, or rows of unequal length
        raise InputError("not a table of cross-sections", path, error, remedy) from error
    lacking = [column for column in ("branch", "s_mm", "area_mm2") if column not in table.columns]
    if lacking:
        raise InputError("cross-sections lack columns", path, lacking, remedy)
    table["branch"] = table["branch"].astype(str)
    for column in ("s_mm", "area_mm2"):
        given, table[column] = table[column], pd.to_numeric(table[column], errors="coerce").astype(float)
        _refuse_row(path, given, ~np.isfinite(table[column]), f"{column} is not a number", remedy)
    _refuse_row(path, table["area_mm2"], ~(table["area_mm2"] > 0), "area is not positive", remedy)
    again = table.duplicated(["branch", "s_mm"])
    _refuse_row(path, table["s_mm"], again, "two sections of a branch at the same s_mm", remedy)
    return table


def check_sections(table, tree, path):
    """Raises InputError for cross-sections (table of `read_sections`, at `path`) that are not of the tree's lumen.

    The last section must lie near its branch's end. The sections' radii must fit the centreline's radii, which are
    those of the largest inscribed spheres. A section may be wider than its sphere: just behind a sudden expansion the
    narrow part still limits the sphere. So the sphere is compared with the narrowest section within its radius along s.
    """
    remedy = "give the sections of the centreline's lumen, both in mm"
    for branch in tree:
        rows = table[table["branch"] == branch.name]
        s, radius = rows["s_mm"].to_numpy(), np.sqrt(rows["area_mm2"].to_numpy() / np.pi)
        where = f"{path}, branch {branch.name}"
        if len(s) and abs(s.max() - branch.length_mm) > END_DISTANCE_RADII * branch.radius_mm[-1]:
            value = f"last at {s.max():.4g} of {branch.length_mm:.4g} mm"
            raise InputError("cross-sections of another branch", where, value, remedy)
        sphere = branch.radius(s)
        near = np.abs(s - s[:, None]) <= sphere[:, None]
        narrowest = np.where(near, radius, np.inf).min(axis=1)
        for k in np.flatnonzero((radius < LEAST_RADIUS_RATIO * sphere) | (narrowest > LARGEST_RADIUS_RATIO * sphere))[
            :1
        ]:
            value = f"radius {radius[k]:.4g} mm at {s[k]:.4g} mm, of the centreline {sphere[k]:.4g} mm"
            raise InputError("cross-sections of another lumen", where, value, remedy)


def _refuse_row(path, values, refused, what, remedy):
    """Raises InputError for the first of `values` that is `refused` (bool); the message has its line in the file."""
    if refused.any():
        row = int(refused.to_numpy().argmax())
        raise InputError(what, f"{path}, row {row + 2}", values[row], remedy)

"""Estimated error of FFR at the outlets and along the pull-back.

The estimate follows the same method as at the probes (errors.error_estimate), from the same flows
(error_estimate.EstimateBasis). At a point of the pull-back the interpolation error is added. It matters in a throat,
since the pressure is linear in each cell.

Shapes below: o outlets, e of them with an extension of the mesh, m points of the pull-back.
"""

import numpy as np

from flow.errors import error_estimate
from flow.physics import ffr
from flow.physics.units import M_PER_MM

ESTIMATE_COLUMN = "ffr_error_estimate"  # column of pullback.csv


def add_estimates(solved, case, answer, table):
    """Writes the estimates into `answer`, the document of ffr.json, and into `table`, the table of pullback.csv.

    Each outlet gets `error_estimate`, the table the column ESTIMATE_COLUMN, and the document `pullback_error_estimate`.
    They are None, or NaN in the table, where the error is not known. solved: solvers.solved_mesh.SolvedMesh or
    reduced.answer.ReducedAnswer; case: reduced.extended.ExtendedLumen.
    """
    if solved.estimate is None:
        for outlet in answer["outlets"]:
            outlet["error_estimate"] = None
        table[ESTIMATE_COLUMN], answer["pullback_error_estimate"] = np.nan, None
        return
    places = FfrPlaces(solved, case, [outlet["name"] for outlet in answer["outlets"]], table)
    errors, method = estimate_errors(solved, places)
    count = len(places.outlet_names)
    for outlet, error in zip(answer["outlets"], errors):
        outlet["error_estimate"] = float(error)
    table[ESTIMATE_COLUMN] = errors[count:]
    answer["pullback_error_estimate"] = {"largest": float(errors[count:].max()), "method": method}


class FfrPlaces:
    """The places at which FFR is read: the outlets `outlet_names` (o) and the points of the pull-back's table (m).

    At an outlet with an extension, FFR is read where the vessel ends without it. points_mm (e + m, 3) and the vessel's
    radii_mm (e + m,) list these ends first, then the points of the pull-back. ends: places (e,) of these outlets in
    outlet_names.
    """

    def __init__(self, solved, case, names, table):
        self.case, self.outlet_names, self.boundaries, self.tree = case, names, solved.boundaries, case.original_tree
        longer = {one.region_id for one in case.extensions}
        ends = {one["name"]: self.tree[one["branch"]] for one in case.document["outlets"] if one["region_id"] in longer}
        self.ends = [names.index(name) for name in ends]
        on = [(branch, branch.length_mm) for branch in ends.values()]
        on += [(self.tree[name], s_mm) for name, s_mm in zip(table["branch"], table["s_mm"])]
        self.points_mm = np.array([branch.point(s_mm) for branch, s_mm in on])
        self.radii_mm = np.array([branch.radius(s_mm) for branch, s_mm in on])

    def read_ffr(self, sampler, outflows):
        """FFR (o + m,) of a flow, from its sampler and its flows through the outlets (m3/s)."""
        ends = ffr.at_outlets(self.outlet_names, self.boundaries.pressures(outflows), self.case, sampler)
        points = self.points_mm[len(self.ends) :] * M_PER_MM
        return np.concatenate([ends, sampler(points)[1] / self.case.document["map_pa"]])

    def errors_by_field(self, field):
        """[errors (o + m,) by the mesh, effects (o + m,) of the artificial viscosity] on FFR.

        The effects are multiplied by error_estimate.SAFETY_FACTOR. field: error_field.ErrorField.
        """
        parts = field.ffr_changes(self.outlet_names, self.points_mm, self.radii_mm)
        at_points = field.interpolation_error_pa(self.points_mm) / self.case.document["map_pa"]
        mesh, count = error_estimate.error_of_parts(parts[:, :-1]), len(self.outlet_names)
        mesh[count:] += at_points
        artificial = error_estimate.SAFETY_FACTOR * np.abs(parts[:, -1])
        return [self._move_to_ends(errors) for errors in (mesh, artificial)]

    def _move_to_ends(self, errors):
        """Errors (o + m,) from errors (o + e + m,): an outlet with an extension takes the error at the vessel's end."""
        count = len(self.outlet_names)
        errors[self.ends] = errors[count : count + len(self.ends)]
        return np.delete(errors, count + np.arange(len(self.ends)))


def estimate_errors(solved, places):
    """(estimated errors (o + m,) of FFR at the FfrPlaces, method in words) of a solvers.solved_mesh.SolvedMesh.

    `solved` must have an estimate.
    """
    basis = solved.estimate["basis"]
    found, methods, artificial = [], [], 0.0
    if basis.field:
        mesh, artificial = places.errors_by_field(basis.field)
        found.append(mesh)
        methods.append("dual-weighted residual, linear interpolation")
    if basis.pair:
        fine, coarse, share = basis.pair
        found.append(share * np.abs(places.read_ffr(*fine) - places.read_ffr(*coarse)))
        methods.append("two meshes")
    return np.max(found, axis=0) + artificial, ", ".join(methods)

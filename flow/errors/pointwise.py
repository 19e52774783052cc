"""Estimated error of FFR at the outlets and along the pull-back.

The estimate follows the same method as at the probes (errors.error_estimate), from the same flows
(error_estimate.Basis). At a point of the pull-back the interpolation error is added: the pressure is linear in each
cell, which matters in a throat.

Shapes below: o outlets, e of them with an extension of the mesh, m points of the pull-back.
"""

import numpy as np

from flow.errors import error_estimate
from flow.physics import ffr
from flow.physics.units import M_PER_MM

COLUMN = "ffr_error_estimate"  # column of pullback.csv


def write(solved, case, answer, table):
    """Writes the estimates into `answer`, the document of ffr.json, and `table`, that of pullback.csv.

    Each outlet gets `error_estimate`, the table COLUMN, the document `pullback_error_estimate`. They are None, or NaN
    in the table, where the error is not known. solved: solvers.solved_mesh.Solved or reduced.answer.Reduced; case:
    reduced.extended.Extended.
    """
    if solved.estimate is None:
        for outlet in answer["outlets"]:
            outlet["error_estimate"] = None
        table[COLUMN], answer["pullback_error_estimate"] = np.nan, None
        return
    places = Places(solved, case, [outlet["name"] for outlet in answer["outlets"]], table)
    errors, method = of(solved, places)
    count = len(places.names)
    for outlet, error in zip(answer["outlets"], errors):
        outlet["error_estimate"] = float(error)
    table[COLUMN] = errors[count:]
    answer["pullback_error_estimate"] = {"largest": float(errors[count:].max()), "method": method}


class Places:
    """The places at which FFR is read: the outlets `names` (o) and the points of the pull-back's table (m).

    At an outlet with an extension, FFR is read where the vessel ends without it. points_mm (e + m, 3) and the vessel's
    radii_mm (e + m,) are those of these ends, then of the pull-back. ends: numbers (e,) of these outlets.
    """

    def __init__(self, solved, case, names, table):
        self.case, self.names, self.boundaries, self.tree = case, names, solved.boundaries, case.original
        longer = {one.region_id for one in case.extensions}
        ends = {one["name"]: self.tree[one["branch"]] for one in case.document["outlets"] if one["region_id"] in longer}
        self.ends = [names.index(name) for name in ends]
        on = [(branch, branch.length_mm) for branch in ends.values()]
        on += [(self.tree[name], s_mm) for name, s_mm in zip(table["branch"], table["s_mm"])]
        self.points_mm = np.array([branch.point(s_mm) for branch, s_mm in on])
        self.radii_mm = np.array([branch.radius(s_mm) for branch, s_mm in on])

    def read(self, sampler, outflows):
        """FFR (o + m,) of a flow, by its sampler and its flows through the outlets (m3/s)."""
        reference = ffr.reference_pa(self.case.document, self.tree, sampler)
        ends = ffr.at_ends(self.names, self.boundaries.pressures(outflows), self.case, sampler, reference)
        points = self.points_mm[len(self.ends) :] * M_PER_MM
        return np.concatenate([ends, sampler(points)[1] / reference])

    def of_field(self, field):
        """[error (o + m,) by the mesh, SAFETY times the effect (o + m,) of the artificial viscosity] on FFR.

        field: error_field.Field.
        """
        document = self.case.document
        parts = field.parts(document, self.tree, self.names, self.points_mm, self.radii_mm)
        at_points = field.interpolation_pa(self.points_mm) / ffr.reference_pa(document, self.tree, field.sampler)
        mesh, count = error_estimate.of_parts(parts[:, :-1]), len(self.names)
        mesh[count:] += at_points
        artificial = error_estimate.SAFETY * np.abs(parts[:, -1])
        return [self._at_ends(errors) for errors in (mesh, artificial)]

    def _at_ends(self, errors):
        """Errors (o + m,) from errors (o + e + m,): an outlet with an extension takes the error at the vessel's end."""
        count = len(self.names)
        errors[self.ends] = errors[count : count + len(self.ends)]
        return np.delete(errors, count + np.arange(len(self.ends)))

    def exact(self):
        """Numbers of the outlets whose FFR has no error, because their pressure and the inlet's are both given."""
        if self.case.document.get("inlet_flow_m3_per_s") is not None:
            return []
        resistance = dict(zip(self.boundaries.names, self.boundaries.resistance))
        return [i for i, name in enumerate(self.names) if resistance[name] == 0 and i not in self.ends]


def of(solved, places):
    """(estimated errors (o + m,) of FFR at a Places, method in words) of a solvers.solved_mesh.Solved.

    `solved` must have an estimate.
    """
    basis = solved.estimate["basis"]
    found, methods, artificial = [], [], 0.0
    if basis.field:
        mesh, artificial = places.of_field(basis.field)
        found.append(mesh)
        methods.append("dual-weighted residual, linear interpolation")
    if basis.pair:
        fine, coarse, share = basis.pair
        found.append(share * np.abs(places.read(*fine) - places.read(*coarse)))
        methods.append("two meshes")
    errors = np.max(found, axis=0) + artificial
    errors[places.exact()] = 0.0
    return errors, ", ".join(methods)

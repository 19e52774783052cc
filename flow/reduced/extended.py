"""A lumen with the extensions of its mesh (meshing.extension), as the reduced models need it.

Reduced models include the extensions, as the mesh does. FFR at an outlet is read where the original lumen ends.
"""

import pathlib

import numpy as np
import pandas as pd

from common.documents import json_reader, schema
from common.errors import InputError
from common.files import sha256
from flow.discretisation import compat
from flow.meshing import extension
from flow.reduced import coupled as coupled_model, network as network_model
from flow.geometry.surface import INLET

UNIT_TOLERANCE = 1e-6  # largest |length - 1| of the vector `direction` of an extension
SHARED_KEYS = ("made_from_sha256", "extensions")  # keys that must agree in the reports of two meshes of one solve


def read_report(path, mesh, coarse=()):
    """([meshing.extension.Extension], [warning], SHA-256 or None) from the report of a mesh.

    path: report that `flow mesh` wrote with the file `mesh`; coarse: files of the coarser meshes. A warning names each
    mesh that could not be swept. The SHA-256 is that of the surface and centrelines from which the mesh was made, None
    where the report lacks it. Raises InputError, also where the report is of another mesh, or a coarse mesh of another
    lumen.
    """
    document = json_reader.read(path, "mesh.json")
    schema.validate(document, schema.read("mesh_report"), "a report of the volume mesh")
    report = document.data
    stated, found = report["cells"], compat.count_cells(mesh)
    extensions = [extension.Extension(**one) for one in report["extensions"]]
    reasons = {name: part["swept"].get("reason") for name, part in _named_reports(report)}
    remedy = "give --mesh-report the file that `flow mesh` wrote with this mesh"
    if stated != found:
        raise InputError("the report is of another mesh", path, f"{stated} cells, {mesh} has {found}", remedy)
    if not _has_sha256(report, mesh):
        value = f"SHA-256 {report['file_sha256']}, {mesh} has {sha256(mesh)}"
        raise InputError("the report is of another mesh", path, value, remedy)
    for one in coarse:
        _check_coarse(report, path, one)
    warnings = [
        f"the {name} mesh is not swept along the vessels, its tetrahedra are of one size in all directions: "
        + " ".join(reason.split())
        for name, reason in reasons.items()
        if reason
    ]
    return extensions, warnings, report.get("made_from_sha256")


def _check_coarse(report, path, coarse):
    """Raises InputError unless the mesh file `coarse` is of the same lumen as the finest mesh.

    The flow on it may be the answer. report: document of the finest mesh's report, at `path`. Either this report lists
    the coarse mesh, or the coarse mesh has a report of its own with the same lumen and extensions.
    """
    own, known = pathlib.Path(coarse).with_suffix(".json"), report.get("coarse", [])
    if not known and own.is_file():
        other = json_reader.read(own, "mesh.json").data
        if all(other.get(key) == report.get(key) for key in SHARED_KEYS):
            known = [other]
    cells = compat.count_cells(coarse)
    if not any(part.get("cells") == cells and _has_sha256(part, coarse) for part in known):
        stated = ", ".join(f"one of {one.get('cells')}, SHA-256 {one.get('file_sha256')}" for one in known) or "none"
        value = f"{cells} cells, {path} knows {stated}"
        remedy = "make both with one `flow mesh ... --coarse`"
        raise InputError("the coarse mesh is not known to be of the same lumen", coarse, value, remedy)


def _has_sha256(part, mesh):
    """Whether a mesh file has the SHA-256 in the report's entry `part`. Also True for an older entry without one."""
    return "file_sha256" not in part or part["file_sha256"] == sha256(mesh)


def _named_reports(report):
    """[(name, entry)] of the meshes in a report, with the names fine, coarse, coarsest."""
    return list(zip(("fine", "coarse", "coarsest"), (report, *report.get("coarse", [])[::-1])))


def read_report_if_any(path, mesh, coarse=()):
    """As `read_report`, but the report may be missing. Then there are no extensions, and a warning says so."""
    if path.is_file():
        return read_report(path, mesh, coarse)
    warning = f"no report of the mesh ({path.name}): reduced models take it as without extensions; give --mesh-report"
    return [], [warning], None


class ExtendedLumen:
    """A lumen's centreline tree with the extensions (`extended_tree`) and without (`original_tree`).

    `network` is the 1D network without extensions. anatomy: document of anatomy.json; sections: table of
    network.read_sections; document: content of boundary.json; warnings: those of `read_report` or `read_report_if_any`.
    Raises InputError where an extension is of another lumen.
    """

    def __init__(self, extensions, tree, anatomy, sections, document, settings, warnings=()):
        self.extensions, self.original_tree, self.warnings = extensions, tree, list(warnings)
        self.document, self.settings = document, settings
        ends = {(outlet["region_id"], outlet["branch"]) for outlet in document["outlets"]} | {(INLET, tree.main.name)}
        for one in extensions:
            if (one.region_id, one.branch) not in ends or abs(np.linalg.norm(one.direction) - 1) > UNIT_TOLERANCE:
                remedy = "give mesh, its report, centreline and boundary values of one lumen"
                raise InputError("extension of another lumen", "report of the mesh: extensions", one, remedy)
        self._anatomy_and_sections = anatomy, sections
        self.network = self.network_at(document)
        self.extended_tree = extension.extend_tree(tree, extensions)
        self._extended_anatomy = extend_anatomy(anatomy, sections, extensions)

    def network_at(self, document):
        """The 1D network without extensions, with the boundary values `document`."""
        return network_model.Network(*self._anatomy_and_sections, document, self.settings.expansion_loss)

    def predictor(self):
        """flow.reduced.coupled.Predictor of the tree with its extensions.

        With setting `model` = network it is the network alone, without the axisymmetric model.
        """
        network = network_model.Network(*self._extended_anatomy, self.document, self.settings.expansion_loss)
        coupled = self.settings.model != "network"
        return coupled_model.Predictor(network, self.extended_tree, self.document, self.settings, coupled)

    def extended_ends(self):
        """Entry `extensions.ends` of ffr.json: [{name, length_mm, narrowing_mm}]."""
        names = {outlet["region_id"]: outlet["name"] for outlet in self.document["outlets"]} | {INLET: "inlet"}
        return [
            {"name": names[one.region_id], "length_mm": one.length_mm, "narrowing_mm": one.distance_mm}
            for one in self.extensions
        ]


def extend_anatomy(anatomy, sections, extensions):
    """(anatomy, sections) with the extensions, for flow.reduced.network.Network.

    An extension has the cross-sectional area of the branch's last section, or of the root's first one at the inlet.
    """
    for one in extensions:
        rows = sections[sections["branch"] == one.branch].sort_values("s_mm")
        if one.region_id == INLET:
            sections, end = sections.copy(), rows.iloc[[0]].copy()
            sections.loc[sections["branch"] == one.branch, "s_mm"] += one.length_mm
            anatomy = {**anatomy, "branches": [_shift_on_parent(branch, one) for branch in anatomy["branches"]]}
            end["s_mm"] = 0.0
        else:
            end = rows.iloc[[-1]].copy()
            end["s_mm"] += one.length_mm
        sections = pd.concat([sections, end], ignore_index=True)
    return anatomy, sections


def _shift_on_parent(branch, one):
    """Entry of anatomy.json for a branch, its place on the parent moved if that has the inlet extension `one`."""
    if branch["parent"] != one.branch:
        return branch
    return {**branch, "s_on_parent_mm": branch["s_on_parent_mm"] + one.length_mm}

"""Whether a mesh was made from a given surface, by the SHA-256 of the coordinates in its report."""

from common import json_reader
from common.errors import InputError
from flow.geometry import surface
from flow.meshing import mesh


def check(lumen, tree, report):
    """Raises InputError unless the mesh of the file `report` was made from the surface file `lumen` and the centrelines
    `tree`, both as `flow mesh` took them."""
    made_from = json_reader.read(report, "mesh.json").data.get("made_from_sha256")
    if not made_from:
        remedy = "make the mesh anew with `flow mesh`, or leave --lumen out"
        raise InputError("the report does not say what its mesh was made from", report, "no made_from_sha256", remedy)
    found = mesh.fingerprint(surface.read(lumen), tree)
    if found != made_from:
        remedy = "give the surface and the centreline that `flow mesh` was given, or mesh this one"
        what = "the mesh was made from another surface or centreline"
        raise InputError(what, lumen, f"SHA-256 {found[:12]}..., {report} says {made_from[:12]}...", remedy)

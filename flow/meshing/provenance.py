"""Whether a mesh was made from a given surface and centreline, by a SHA-256 in the mesh's report."""

import hashlib

import numpy as np

from common.errors import InputError
from flow.geometry import surface


def fingerprint(surface, tree):
    """SHA-256, in hexadecimal, of the Surface and the Tree that a mesh is made from.

    It covers the surface's points, triangles and region ids, and the centrelines' points and radii.
    """
    found = hashlib.sha256()
    for array in (
        surface.points,
        surface.triangles,
        surface.region,
        *(a for b in tree for a in (b.points, b.radius_mm)),
    ):
        found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def check(lumen, tree, made_from, report):
    """Raises InputError unless a mesh was made from the surface file `lumen` and the centrelines `tree`.

    made_from: `made_from_sha256` of the mesh's report, or None; report: path of that report.
    """
    if not made_from:
        remedy = "make the mesh anew with `flow mesh`, or leave --lumen out"
        raise InputError("the report does not say what its mesh was made from", report, "no made_from_sha256", remedy)
    found = fingerprint(surface.read(lumen), tree)
    if found != made_from:
        remedy = "give the surface and the centreline that `flow mesh` was given, or mesh this one"
        what = "the mesh was made from another surface or centreline"
        raise InputError(what, lumen, f"SHA-256 {found[:12]}..., {report} says {made_from[:12]}...", remedy)

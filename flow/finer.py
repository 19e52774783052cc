"""Meshes finer than those given: made from the lumen, as fine as the error estimate of the last one asks."""

import math
import pathlib
import shutil
import sys

from common import json_reader
from common.errors import InputError
from flow import output
from flow.discretisation import parallel
from flow.errors import error_estimate
from flow.geometry import surface
from flow.meshing import mesh
from flow import settings as settings_module

MARGIN = 0.8  # of the tolerance is aimed at
MOST_RATIO = 1.5  # of a mesh's rings to those of the one before: the estimate of a coarse mesh is no better than that
MOST_RINGS = 12


class Finer:
    """Finer meshes of one lumen, in a folder of their own in `folder` until `close`; its ComputationErrors are those of
    meshing.mesh.

    lumen: path of the surface that the mesh with the report `report` was made from, tree: its centrelines (both as
    `flow mesh` took them); settings: of the solve. Raises InputError where they do not belong together.
    """

    def __init__(self, lumen, tree, report, settings, folder):
        self.tree, self.settings, self.folder, self.scratch = tree, settings, pathlib.Path(folder), None
        document = json_reader.read(report, "mesh.json").data
        try:
            self.of_mesh = settings_module.make(**document["settings"])
            self.rings, self.cells_per_radius = document["rings"], document["cells_per_radius"]
            made_from = document["made_from_sha256"]
        except (KeyError, TypeError) as error:
            remedy = "make the mesh anew with `flow mesh`, or leave --lumen out"
            raise InputError("the report does not say how its mesh was made", report, error, remedy) from error
        self.surface = surface.read(lumen)
        found = mesh.fingerprint(self.surface, tree)
        if found != made_from:
            remedy = "give the surface and the centreline that `flow mesh` was given, or mesh this one"
            what = "the mesh was made from another surface or centreline"
            raise InputError(what, lumen, f"SHA-256 {found[:12]}..., {report} says {made_from[:12]}...", remedy)
        self.report = None  # of the last mesh that was made

    def make(self, dofs, estimate, most_dofs):
        """Path of the next mesh after one of so many dofs whose FFR has the error `estimate`; None, said why, where it
        would have more than most_dofs. Raises ComputationError where it is not good enough."""
        # the first rank decides for all: most_dofs may depend on the memory that each finds free
        rings = parallel.from_first(lambda: self.rings_for(dofs, estimate, most_dofs))
        if rings is None:
            return None
        print(f"the error {estimate:.2g} asks for a mesh of {rings} rings", file=sys.stderr, flush=True)
        path, self.report = parallel.from_first(lambda: self._written(rings))
        self.rings = rings
        return path

    def close(self):
        """Removes the meshes."""
        if self.scratch and parallel.first():
            shutil.rmtree(self.scratch, ignore_errors=True)

    def rings_for(self, dofs, estimate, most_dofs):
        """Rings of the next mesh, or None where it would have more than most_dofs or MOST_RINGS; see `make`."""
        wanted = (estimate / (MARGIN * self.settings.ffr_tolerance)) ** (1 / error_estimate.ORDER)
        allowed = self.rings * (most_dofs / dofs) ** (1 / 3)
        most = min(math.floor(allowed), max(math.floor(MOST_RATIO * self.rings), self.rings + 1), MOST_RINGS)
        rings = min(max(math.ceil(self.rings * wanted), self.rings + 1), most)
        if rings > self.rings:
            return rings
        least = self.rings + 1
        larger = round(dofs * (least / self.rings) ** 3)
        said = f"about {larger} dofs, {most_dofs} are allowed"
        print(
            f"no finer mesh: of {least} rings (at most {MOST_RINGS}) it would have {said}", file=sys.stderr, flush=True
        )
        return None

    def _written(self, rings):
        """(path, report) of a mesh with so many rings; its other sizes go with them."""
        ratio = rings / self.rings
        cells = self.cells_per_radius * ratio
        built, report = mesh.build(self.surface, self.tree, cells, self.of_mesh, rings, self.of_mesh.rings / rings)
        self.cells_per_radius = cells
        self.scratch = self.scratch or output.scratch(self.folder)
        path = self.scratch / f"mesh_{rings}_rings.msh"
        mesh.write(built, path)
        return path, report

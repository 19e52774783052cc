"""Meshes finer than those given: made from the lumen, as fine as the error estimate of the last one asks."""

import math
import pathlib
import sys

from common import json_reader
from common.errors import InputError
from flow import error_estimate, extension, mesh, parallel, surface
from flow import settings as settings_module

MARGIN = 0.8  # of the tolerance is aimed at
MOST_RATIO = 1.5  # of a mesh's rings to those of the one before: the estimate of a coarse mesh is no better than that
MOST_RINGS = 12
SAME_VOLUME = 0.01  # by which the volume of the surface may differ from its mesh's, which has curved walls


class Finer:
    """Finer meshes of one lumen, written to `folder`; its ComputationErrors are those of flow.mesh.

    lumen: path of the surface that the mesh with the report `report` was made from, tree: its centrelines (both as
    `flow mesh` took them); settings: of the solve. Raises InputError where they do not belong together.
    """

    def __init__(self, lumen, tree, report, settings, folder):
        self.tree, self.settings, self.folder = tree, settings, pathlib.Path(folder)
        document = json_reader.read(report, "mesh.json").data
        try:
            self.of_mesh = settings_module.make(**document["settings"])
            self.rings, self.cells_per_radius = document["rings"], document["cells_per_radius"]
            volume = document["volume_mm3"]
        except (KeyError, TypeError) as error:
            remedy = "make the mesh anew with `flow mesh`, or leave --lumen out"
            raise InputError("the report does not say how its mesh was made", report, error, remedy) from error
        self.surface = surface.read(lumen)
        extensions = extension.needed(self.surface, tree, self.of_mesh)
        found = extension.extend(self.surface, extensions).volume_mm3()
        if not abs(found / volume - 1) <= SAME_VOLUME:
            remedy = "give --lumen the surface that the mesh was made from"
            what = "the surface is not that of the mesh"
            raise InputError(what, lumen, f"{found:.4g} mm3, the mesh has {volume:.4g}", remedy)
        self.report = None  # of the last mesh that was made

    def make(self, dofs, estimate):
        """Path of the next mesh after one of so many dofs whose FFR has the error `estimate`; None, said why, where it
        would be too large. Raises ComputationError where it is not good enough."""
        rings = self.rings_for(dofs, estimate)
        if rings is None:
            return None
        print(f"the error {estimate:.2g} asks for a mesh of {rings} rings", file=sys.stderr, flush=True)
        path, self.report = parallel.from_first(lambda: self._written(rings))
        self.rings = rings
        return path

    def rings_for(self, dofs, estimate):
        """Rings of the next mesh, or None where it would have more than `most_dofs` or MOST_RINGS; see `make`."""
        wanted = (estimate / (MARGIN * self.settings.ffr_tolerance)) ** (1 / error_estimate.ORDER)
        allowed = self.rings * (self.settings.most_dofs / dofs) ** (1 / 3)
        most = min(math.floor(allowed), max(math.floor(MOST_RATIO * self.rings), self.rings + 1), MOST_RINGS)
        rings = min(max(math.ceil(self.rings * wanted), self.rings + 1), most)
        if rings > self.rings:
            return rings
        least = self.rings + 1
        larger = round(dofs * (least / self.rings) ** 3)
        said = f"about {larger} dofs, most_dofs is {self.settings.most_dofs}"
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
        path = self.folder / f"mesh_{rings}_rings.msh"
        mesh.write(built, path)
        return path, report

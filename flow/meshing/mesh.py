"""Volume meshes of a lumen: refined, extended surface -> linear tetrahedra -> curved quadratic tetrahedra -> files."""

import contextlib
import dataclasses
import math
import pathlib
import sys

import numpy as np

from common.errors import ComputationError
from common.files import replacing, sha256, write_json
from flow.geometry import curving, folds, refine, smooth_surface
from flow.geometry.tags import PHYSICAL_VOLUME, physical_tag
from flow.geometry.tet10 import LEAST_JACOBIAN_RATIO, count_overlapping
from flow.meshing import extension, hybrid, size_field, volume_mesh


def build(surface, tree, cells_per_radius, settings, rings=None, coarsening=1.0):
    """(curving.QuadraticMesh, report) of the lumen, by the first of ATTEMPTS whose cells are good enough to solve on.

    cells_per_radius: number of isotropic cells per radius; rings: number of rings of the swept discs (default:
    settings.rings); coarsening: factor of the discs' distance. The report is a part of mesh.json. Raises
    ComputationError.
    """
    rings = rings or settings.rings
    original, surface = surface, folds.unfold(surface)
    extensions = extension.find_extensions(surface, tree, settings)
    tree = extension.extend_tree(tree, extensions)
    sizes = size_field.SizeField(tree, cells_per_radius, settings.jet_spread)
    refused = []
    for attempt in ATTEMPTS:
        wall = extension.extend_surface(attempt.make_surface(surface, sizes), extensions)
        try:
            linear = attempt.make_cells(wall, tree, sizes, settings, rings, coarsening)
            mesh = curving.curve(
                linear.boundary, linear.region, linear.points, linear.tetrahedra, linear.edges, linear.middles
            )
            quality = _checked_quality(mesh, linear.swept)
            break
        except (hybrid.NoSpans, ComputationError) as error:
            refused.append(f"{attempt.name}: " + " ".join(str(error).split()))
            print(refused[-1], file=sys.stderr, flush=True)
    else:
        raise ComputationError("no volume mesh", "lumen", "; ".join(refused), "check the surface for self-contact")
    swept = {"way": attempt.name, "cells": int(linear.swept.sum()), "spans": linear.spans, "moved": linear.moved_ends}
    if refused:
        swept |= {"reason": "; ".join(refused) + _layer_warning(settings), "cost": attempt.cost}
    report = {
        "element_order": 2,
        "cells": len(mesh.tetrahedra),
        "nodes": len(mesh.points),
        "dofs": 3 * len(mesh.points) + len(np.unique(mesh.tetrahedra[:, :4])),
        "unfolded_facets": int((original.triangles != surface.triangles).any(axis=1).sum()),
        "surface_triangles": len(mesh.triangles),
        "cells_per_radius": cells_per_radius,
        "rings": rings,
        "wall_layers": settings.wall_layers if swept["cells"] else 1,
        "swept": swept,
        "quality": quality,
        "volume_mm3": wall.volume_mm3(),
        "extensions": [dataclasses.asdict(one) for one in extensions],
    }
    return mesh, report


def build_sequence(paths, surface, tree, settings, report):
    """Makes the meshes of a lumen: [(QuadraticMesh or None, its part of `report`, path)], the finest first.

    paths: [(path, rings)], the coarsest first. A mesh with no fewer cells than the next finer one is left out: None
    stands in its place. This happens where a coarse mesh cannot be swept, since isotropic tetrahedra may be more
    numerous. `report`, the document of mesh.json, gets the finest mesh's figures, and the lists `coarse` and `left_out`
    of the others, the coarsest first. Raises ComputationError.
    """
    meshes, fewest = [], math.inf
    for path, rings in reversed(paths):
        size = settings.cells_per_radius if rings == settings.rings else settings.coarse_cells_per_radius
        built, part = build(surface, tree, size, settings, rings, settings.rings / rings)
        if part["cells"] >= fewest:
            print(f"the mesh of {rings} rings is left out: it is not coarser", file=sys.stderr, flush=True)
            name = pathlib.Path(path).name
            built, part = None, {"file": name, "rings": rings, "cells": part["cells"], "not_fewer_than": fewest}
        elif not meshes:
            report.update(part)
            part = report
        meshes.append((built, part, path))
        fewest = min(fewest, part["cells"])
    for key, was_built in (("coarse", True), ("left_out", False)):
        parts = [part for built, part, _ in meshes[:0:-1] if bool(built) == was_built]
        report.update({key: parts} if parts else {})
    return meshes


def build_coarsest(paths, surface, tree, settings, report):
    """Makes the coarsest mesh only, for the last file of `paths`, on which to show the fields of a reduced model.

    Arguments and result are those of `build_sequence`, with None for the other meshes.
    """
    (*others, (path, _)), coarse_rings = paths, paths[0][1]
    coarsest = build_sequence([(path, coarse_rings)], surface, tree, settings, report)
    return [*coarsest, *((None, {}, other) for other, _ in others)]


def _layer_warning(settings):
    """Warning that setting wall_layers has no effect as nothing is swept; empty for a single layer. Also prints it."""
    if settings.wall_layers == 1:
        return ""
    warning = (
        f"no wall_layers, {settings.wall_layers} were asked for: they are of swept stretches, and nothing is swept"
    )
    print(warning, file=sys.stderr, flush=True)
    return f"\n{warning}"


def _isotropic_cells(surface, tree, sizes, *_):
    """hybrid.LinearMesh with isotropic tetrahedra everywhere, filled by gmsh."""
    points, tetrahedra = volume_mesh.fill(surface, sizes)
    edges, side = surface.edges()
    middles = smooth_surface.edge_middles(surface, edges, side)
    nothing = np.zeros(len(tetrahedra), bool)
    return hybrid.LinearMesh(points, tetrahedra, nothing, surface.triangles, surface.region, edges, middles, [], [])


@dataclasses.dataclass
class Attempt:
    """One way to make a mesh.

    make_surface(surface, sizes) -> Surface to be filled; make_cells(wall, tree, sizes, settings, rings, coarsening) ->
    hybrid.LinearMesh; cost: in words, what this way costs more than the first one.
    """

    name: str
    make_surface: object
    make_cells: object
    cost: str


ISOTROPIC_COST = (
    "1.5 times the unknowns of a swept mesh of the same settings (62 % lesion); the error is that estimated in ffr.json"
)
ATTEMPTS = (
    Attempt("swept", refine.refine, hybrid.build, ""),
    Attempt("isotropic", refine.refine, _isotropic_cells, ISOTROPIC_COST),
    # the smooth surface, on which refined facets lie, may cross itself in a narrow cleft where the given facets do not
    Attempt("isotropic, facets as given", lambda surface, _: surface, _isotropic_cells, ISOTROPIC_COST),
)


def _checked_quality(mesh, swept):
    """Quality figures (curving.quality) of a QuadraticMesh; swept (t,) bool: its swept cells.

    Raises ComputationError if cells overlap or the least Jacobian ratio is below LEAST_JACOBIAN_RATIO.
    """
    folded = count_overlapping(mesh.tetrahedra[:, :4])
    if folded:
        raise ComputationError(
            "volume mesh is not good enough", "cells that overlap", f"{folded} faces", "none may be: it was folded"
        )
    figures = curving.quality(mesh, swept)
    name, least = "jacobian_ratio_min", LEAST_JACOBIAN_RATIO
    if not figures[name] >= least:
        where, needed = f"mesh quality {name}", f"at least {least} is needed"
        raise ComputationError("volume mesh is not good enough", where, figures[name], needed)
    return figures


def write(mesh, path):
    """Writes a QuadraticMesh as a binary gmsh 4.1 file with the physical groups of geometry.tags."""
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 2)
        gmsh.option.setNumber("Mesh.Binary", 1)
        gmsh.model.add("lumen")
        volume = gmsh.model.addDiscreteEntity(3, 1)
        gmsh.model.mesh.addNodes(3, volume, np.arange(1, len(mesh.points) + 1), mesh.points.ravel())
        # gmsh's order of the ten nodes is that of geometry.tet10
        gmsh.model.mesh.addElementsByType(volume, 11, [], (mesh.tetrahedra + 1).ravel())
        gmsh.model.addPhysicalGroup(3, [volume], PHYSICAL_VOLUME)
        gmsh.model.setPhysicalName(3, PHYSICAL_VOLUME, "lumen")
        for region in sorted(set(mesh.region.tolist())):
            entity = gmsh.model.addDiscreteEntity(2, region + 1)
            chosen = mesh.triangles[mesh.region == region] + 1
            gmsh.model.mesh.addElementsByType(entity, 9, [], chosen.ravel())
            name = {0: "wall", 1: "inlet"}.get(region, f"outlet{region - 1}")
            gmsh.model.addPhysicalGroup(2, [entity], physical_tag(region))
            gmsh.model.setPhysicalName(2, physical_tag(region), name)
        with replacing(path) as partial:
            gmsh.write(str(partial))
    finally:
        gmsh.finalize()


def write_all(meshes, report, path):
    """Writes `meshes` of `build_sequence` or `build_coarsest`, and `report` with the SHA-256 of each file to `path`.

    A mesh that is None gets an empty file, since a study's workflow expects every file. All files are written under
    other names first. Then they are moved into place, the report last. If anything fails, no file is left.
    """
    try:
        with contextlib.ExitStack() as replacements:  # moves the files into place in reverse order
            report_made = replacements.enter_context(replacing(path))
            for built, part, file in meshes:
                made = replacements.enter_context(replacing(file))
                if built is None:
                    made.touch()
                    continue
                write(built, made)
                part["file_sha256"] = sha256(made)
            write_json(report_made, report)
    except BaseException:
        for file in (path, *(file for *_, file in meshes)):
            pathlib.Path(file).unlink(missing_ok=True)
        raise

"""Volume mesh of a lumen: surface -> refined, extended surface -> linear tetrahedra -> curved tetrahedra -> files."""

import contextlib
import dataclasses
import hashlib
import pathlib
import sys

import numpy as np

from common.errors import ComputationError
from common.files import replacing, sha256, write_json
from flow.geometry import curving, refine, tet10
from flow.geometry.tags import PHYSICAL_VOLUME, physical_tag
from flow.geometry.tet10 import LEAST_JACOBIAN_RATIO, overlapping
from flow.meshing import extension, hybrid, size_field, volume_mesh

LEAST_GAMMA = 0.02  # below it an element is a sliver that spoils the whole solve
# radii by which swept stretches are shortened: where a junction gets a sliver, a cut elsewhere seldom does
SHORTER = (0.0, 0.15, 0.3, 0.45)
OTHER_SIZES = (1.0, 1.1, 0.9, 0.8)  # of the coarse mesh's cells per radius, tried in turn


def fingerprint(surface, tree):
    """SHA-256 of what a mesh is made from, the surface's and centrelines' coordinates and the tags, in hexadecimal."""
    found = hashlib.sha256()
    for array in (
        surface.points,
        surface.triangles,
        surface.region,
        *(a for b in tree for a in (b.points, b.radius_mm)),
    ):
        found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def build(surface, tree, cells_per_radius, settings, rings=None, coarsening=1.0):
    """(QuadraticMesh, report) of the lumen: swept where the tree allows (meshing.hybrid), else tetrahedra of one size
    in all directions. rings: of the swept discs (default: settings.rings); coarsening: factor of their distance.

    Raises ComputationError where the mesh is not good enough to be solved on.
    """
    rings = rings or settings.rings
    extensions = extension.needed(surface, tree, settings)
    tree = extension.prolonged(tree, extensions)
    sizes = size_field.SizeField(tree, cells_per_radius, settings.jet_spread)
    surface = extension.extend(refine.refine(surface, sizes), extensions)
    try:
        mesh, figures, swept = _swept(surface, tree, sizes, settings, rings, coarsening)
    except (hybrid.NoSpans, ComputationError) as error:
        points, tetrahedra = volume_mesh.fill(surface, sizes, spacing_mm=max(0.25, float(sizes.size.min())))
        mesh = curving.curve(surface, points, _positive(points, tetrahedra))
        figures = _checked(mesh, np.zeros(len(tetrahedra), bool))
        swept = {"cells": 0, "spans": [], "reason": _unswept(error, settings)}
    report = {
        "element_order": 2,
        "cells": len(mesh.tetrahedra),
        "nodes": len(mesh.points),
        "dofs": 3 * len(mesh.points) + len(np.unique(mesh.tetrahedra[:, :4])),
        "surface_triangles": len(mesh.triangles),
        "cells_per_radius": cells_per_radius,
        "rings": rings,
        "wall_layers": settings.wall_layers if swept["cells"] else 1,
        "swept": swept,
        "quality": figures,
        "volume_mm3": surface.volume_mm3(),
        "extensions": [dataclasses.asdict(one) for one in extensions],
    }
    return mesh, report


def coarser(fine, surface, tree, cells_per_radius, settings, rings, coarsening):
    """As `build`, of fewer cells than `fine`: where junctions with slivers leave isotropic tetrahedra that are more,
    with other sizes in the junctions. Raises ComputationError."""
    for factor in OTHER_SIZES:
        built, report = build(surface, tree, factor * cells_per_radius, settings, rings, coarsening)
        if report["cells"] < fine:
            return built, report
        print(f"{report['cells']} cells, not fewer than {fine}: another size is tried", file=sys.stderr, flush=True)
    remedy = "another coarse_cells_per_radius or coarse_rings; or mesh without --coarse"
    raise ComputationError("the coarse mesh is not coarser than the fine one", "cells", report["cells"], remedy)


def _unswept(error, settings):
    """Why no stretch is swept, and, printed too, what of the settings that leaves undone."""
    if settings.wall_layers == 1:
        return str(error)
    lost = f"no wall_layers, {settings.wall_layers} were asked for: they are of swept stretches, and nothing is swept"
    print(lost, file=sys.stderr, flush=True)
    return f"{error}\n{lost}"


def _swept(surface, tree, sizes, settings, rings, coarsening):
    """(QuadraticMesh, quality, record of the spans): the first of SHORTER that gives cells good enough. Raises NoSpans,
    or the ComputationError of the last."""
    for shorter in SHORTER:
        try:
            linear = hybrid.build(surface, tree, sizes, settings, rings, coarsening, shorter)
            linear.tetrahedra = _positive(linear.points, linear.tetrahedra)
            mesh = curving.curve_with(
                linear.boundary, linear.region, linear.points, linear.tetrahedra, linear.edges, linear.middles
            )
            figures = _checked(mesh, linear.swept)
        except ComputationError as error:
            refused = error
            continue
        return mesh, figures, {"cells": int(linear.swept.sum()), "spans": linear.spans, "shorter_radii": shorter}
    raise refused


def _checked(mesh, swept):
    """Quality figures, or ComputationError where one is below what is needed."""
    folded = overlapping(mesh.tetrahedra[:, :4])
    if folded:
        raise ComputationError(
            "volume mesh is not good enough", "cells that overlap", f"{folded} faces", "none may be: it was folded"
        )
    figures = curving.quality(mesh, swept)
    for name, least in (("gamma_min", LEAST_GAMMA), ("jacobian_ratio_min", LEAST_JACOBIAN_RATIO)):
        if figures[name] is not None and not figures[name] >= least:
            raise ComputationError(
                "volume mesh is not good enough", f"mesh quality {name}", figures[name], f"at least {least} is needed"
            )
    return figures


def _positive(points, tetrahedra):
    """The tetrahedra with positive volume by orientation (swaps two corners where it is negative)."""
    negative = tet10.six_volumes(points, tetrahedra) < 0
    tetrahedra = tetrahedra.copy()
    tetrahedra[negative] = tetrahedra[negative][:, [0, 2, 1, 3]]
    return tetrahedra


def write(mesh, path):
    """Writes a gmsh 4.1 binary file with physical groups (module docstring of meshing.mesh)."""
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 2)
        gmsh.option.setNumber("Mesh.Binary", 1)
        gmsh.model.add("lumen")
        volume = gmsh.model.addDiscreteEntity(3, 1)
        gmsh.model.mesh.addNodes(3, volume, np.arange(1, len(mesh.points) + 1), mesh.points.ravel())
        # gmsh's tetrahedron of ten nodes has its last two middles in the order 23, 13, as geometry.tet10.EDGES
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
    """Writes [(QuadraticMesh, its part of `report`, file)] and `report`, which gets each file's SHA-256, to `path`.

    All are made before the first is moved into place, the report last; where that fails none is left.
    """
    try:
        with contextlib.ExitStack() as until_made:  # moves them in the opposite order
            report_made = until_made.enter_context(replacing(path))
            for built, part, file in meshes:
                made = until_made.enter_context(replacing(file))
                write(built, made)
                part["file_sha256"] = sha256(made)
            write_json(report_made, report)
    except BaseException:
        for file in (path, *(file for *_, file in meshes)):
            pathlib.Path(file).unlink(missing_ok=True)
        raise

"""Linear tetrahedra inside the lumen surface by gmsh (HXT), in a process of its own.

gmsh raises C++ exceptions that Python cannot catch: `fill` starts this file as a program, which reads a surface
and a size
field from one .npz file and writes nodes and tetrahedra to another.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from common.errors import ComputationError

ROOT = pathlib.Path(__file__).resolve().parent.parent
HXT = 10
OPTIMISE_PASSES = 2


def fill(surface, size_field, spacing_mm):
    """(points (n, 3), tetrahedra (t, 4)): the surface's vertices come first, in their order. Raises
    ComputationError."""
    with tempfile.TemporaryDirectory(prefix="flow-mesh-") as folder:
        folder = pathlib.Path(folder)
        origin, spacing, shape, values = size_field.grid(surface.points, spacing_mm)
        np.savez(
            folder / "surface.npz",
            points=surface.points,
            triangles=surface.triangles,
            region=surface.region,
            origin=origin,
            spacing=spacing,
            shape=shape,
            values=values,
        )
        command = [sys.executable, "-m", "flow.volume_mesh", str(folder / "surface.npz"), str(folder / "volume.npz")]
        done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True)
        if done.returncode != 0 or not (folder / "volume.npz").is_file():
            tail = (done.stdout + done.stderr).strip().splitlines()[-3:]
            raise ComputationError(
                "gmsh could not fill the lumen", "volume mesh", "; ".join(tail), "check the surface for self-contact"
            )
        with np.load(folder / "volume.npz") as volume:
            points, tetrahedra = volume["points"], volume["tetrahedra"]
    if len(tetrahedra) == 0:
        raise ComputationError("gmsh made no tetrahedra", "volume mesh", 0, "check the surface for self-contact")
    if not np.allclose(points[: len(surface.points)], surface.points, rtol=0, atol=1e-12):
        raise ComputationError("gmsh moved the surface", "volume mesh", "vertices differ", "report this surface")
    return points, tetrahedra


def _structured_field(path, origin, spacing, shape, values):
    """gmsh's binary structured grid: origin, spacings (doubles), counts (ints), values with z running fastest."""
    with open(path, "wb") as file:
        file.write(np.asarray(origin, "<f8").tobytes())
        file.write(np.full(3, spacing, "<f8").tobytes())
        file.write(np.asarray(shape, "<i4").tobytes())
        file.write(np.asarray(values, "<f8").tobytes())


def _main(source, target):
    import gmsh

    data = np.load(source)
    field_file = str(pathlib.Path(target).with_name("size.bin"))
    _structured_field(field_file, data["origin"], float(data["spacing"]), data["shape"], data["values"])
    gmsh.initialize(["gmsh"], False)
    options = {
        "General.Verbosity": 2,
        "General.NumThreads": 1,
        "Mesh.Algorithm3D": HXT,
        "Mesh.MeshSizeExtendFromBoundary": 0,
        "Mesh.MeshSizeFromPoints": 0,
        "Mesh.MeshSizeFromCurvature": 0,
        "Mesh.Optimize": OPTIMISE_PASSES,
        "Mesh.RandomSeed": 1,
        "Mesh.Renumber": 0,
    }
    for name, value in options.items():
        gmsh.option.setNumber(name, value)
    gmsh.model.add("lumen")
    points, triangles, region = data["points"], data["triangles"], data["region"]
    entities = []
    count = 0
    for k, tag in enumerate(sorted(set(region.tolist()))):
        entity = gmsh.model.addDiscreteEntity(2, 1 + tag)
        entities.append(entity)
        if k == 0:
            gmsh.model.mesh.addNodes(2, entity, np.arange(1, len(points) + 1), points.ravel())
        chosen = triangles[region == tag]
        ids = np.arange(count + 1, count + len(chosen) + 1)
        count += len(chosen)
        gmsh.model.mesh.addElementsByType(entity, 2, ids, (chosen + 1).ravel())
    gmsh.model.mesh.createTopology()
    loop = gmsh.model.geo.addSurfaceLoop([tag for _, tag in gmsh.model.getEntities(2)])
    gmsh.model.geo.addVolume([loop])
    gmsh.model.geo.synchronize()
    field = gmsh.model.mesh.field.add("Structured")
    gmsh.model.mesh.field.setString(field, "FileName", field_file)
    gmsh.model.mesh.field.setNumber(field, "TextFormat", 0)
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    gmsh.model.mesh.generate(3)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    tags, coordinates = tags[order].astype(np.int64), coordinates.reshape(-1, 3)[order]
    position = np.zeros(tags.max() + 1, np.int64)
    position[tags] = np.arange(len(tags))
    _, nodes = gmsh.model.mesh.getElementsByType(4)
    gmsh.finalize()
    np.savez(target, points=coordinates, tetrahedra=position[nodes.reshape(-1, 4).astype(np.int64)])


if __name__ == "__main__":
    _main(*sys.argv[1:3])

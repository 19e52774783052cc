"""Fills closed surfaces with tetrahedra by gmsh: a program that meshing.volume_mesh starts once and then asks often.

Each line of its input names a folder, as a JSON string. The program reads SURFACE in this folder, and writes VOLUME,
LOG and the auxiliary file FIELD there. Then it prints the exit code of this job. Each job runs in a forked process:
gmsh and numpy are loaded only once, and a crash of gmsh ends that job alone. The program imports nothing of this
repository.

gmsh's Delaunay algorithm gives the same tetrahedra on every run. Its algorithm HXT does not, since gmsh 4.8 hands it
the vertices in the order of their memory addresses.
"""

import json
import os
import signal
import sys

import numpy as np

SURFACE, FIELD, VOLUME, LOG = "surface.npz", "size.bin", "volume.npz", "log.txt"
DELAUNAY = 1  # gmsh's number of the algorithm
OPTIMISE_PASSES = 2  # value of gmsh's option Mesh.Optimize


def _write_structured_field(path, origin, spacing, shape, values):
    """Writes gmsh's binary structured grid: origin, spacings (doubles), counts (ints), values with z running fastest.

    origin (3,) and spacing in mm; shape (3,): numbers of nodes; values: cell sizes in mm at the nodes.
    """
    with open(path, "wb") as file:
        file.write(np.asarray(origin, "<f8").tobytes())
        file.write(np.full(3, spacing, "<f8").tobytes())
        file.write(np.asarray(shape, "<i4").tobytes())
        file.write(np.asarray(values, "<f8").tobytes())


def fill(gmsh):
    """Reads SURFACE in the working folder, fills it, and writes VOLUME. gmsh: the module."""
    data = np.load(SURFACE)
    _write_structured_field(FIELD, data["origin"], float(data["spacing"]), data["shape"], data["values"])
    gmsh.initialize(["gmsh"], False)
    options = {
        "General.Verbosity": 2,
        "General.NumThreads": 1,
        "Mesh.Algorithm3D": DELAUNAY,
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
    gmsh.model.mesh.field.setString(field, "FileName", FIELD)
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
    np.savez(VOLUME, points=coordinates, tetrahedra=position[nodes.reshape(-1, 4).astype(np.int64)])


def run_job(gmsh, folder):
    """Fills the surface in `folder` in a process of its own. Returns its exit code, negative for a signal."""
    job = os.fork()
    if job == 0:
        code = 1
        try:
            os.chdir(folder)
            log = os.open(LOG, os.O_WRONLY | os.O_CREAT)
            os.dup2(log, 1)
            os.dup2(log, 2)
            fill(gmsh)
            code = 0
        except Exception as error:
            print(f"{type(error).__name__}: {error}", file=sys.stderr)
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(job, 0)[1])


def main():
    """Runs the job of each folder named on standard input and prints its exit code."""
    import gmsh

    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends program and job without a traceback
    for line in sys.stdin:
        print(run_job(gmsh, json.loads(line)), flush=True)


if __name__ == "__main__":
    main()

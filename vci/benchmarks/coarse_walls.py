"""Seconds of a study's cases on coarser walls and devices, and the error of moving a fine surface with a coarse wall.

/usr/bin/python3 -m vci.benchmarks.coarse_walls results/cases/lad02 --out results/coarse_walls

Each case is deployed as in the study, then on its own lumen remeshed to longer edges. The CSV file has each time next
to the time of the study's mesh in the same run. The displacement of the coarse wall is interpolated to the points of
the study's mesh. The error is the normal distance between these points and their places after the study's own run.
"""

import argparse
import csv
import json
import os
import pathlib
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import ComputationError, guarded
from vci.benchmarks.benchmark import outcome_of
from vci.benchmarks.programs import reason_of, run

EDGES = ((None, None), (0.8, 0.9), (0.6, 0.675), (0.8, None), (1.0, 1.125))  # wall, device, mm; None: the study's
MOVED_MM = 0.05  # points that move by less do not count, since most of a vessel does not move
AREAS = ("mean_csa", "mla")
COLUMNS = ("case", "wall_edge_mm", "device_edge_mm", "wall_vertices", "steps", "cpu_seconds", "time_ratio")
COLUMNS += tuple(f"{key}_change_percent" for key in AREAS)
COLUMNS += ("max_penetration_mm", "carried_mean_mm", "carried_rms_mm", "carried_worst_mm")
REMEDY = "run the study's rules up to vci/scene.json of this case"


def interpolated(surface, values, at):
    """Values (n, 3) of a triangle surface (vtkPolyData), interpolated linearly to the points on it nearest to `at`
    (m, 3)."""
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(surface)
    locator.BuildLocator()
    nearest, cells = np.empty_like(at), np.empty(len(at), int)
    place, cell, found = [0.0] * 3, vtk.vtkGenericCell(), vtk.reference(0)
    part, square = vtk.reference(0), vtk.reference(0.0)
    for k, point in enumerate(at):
        locator.FindClosestPoint(point, place, cell, found, part, square)
        nearest[k], cells[k] = place, int(found)
    points, triangles = vtp.arrays(surface)
    corners = triangles[cells]
    a, b, c = (points[corners[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    size = np.sum(area * area, axis=1)
    second = np.sum(np.cross(nearest - a, c - a) * area, axis=1) / size
    third = np.sum(np.cross(b - a, nearest - a) * area, axis=1) / size
    weights = np.stack([1 - second - third, second, third], axis=1)
    return np.einsum("nk,nkd->nd", weights, values[corners])


def carried_errors(coarse, fine):
    """Mean, root mean square and largest size (mm) of the normal distance of the carried points; each argument is
    (surface before, surface after) with the same points."""
    motion = vtp.points(coarse[1]) - vtp.points(coarse[0])
    before, after = vtp.points(fine[0]), vtp.points(fine[1])
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(fine[1])
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    normal = vtk_to_numpy(normals.GetOutput().GetPointData().GetNormals())
    off = np.sum((before + interpolated(coarse[0], motion, before) - after) * normal, axis=1)
    off = off[np.linalg.norm(after - before, axis=1) > MOVED_MM]
    return float(off.mean()), float(np.sqrt(np.mean(off**2))), float(np.abs(off).max())


def remeshed(build, case, edge, folder):
    """The case's lumen with edges of `edge` mm, and its centreline in the same folder. Raises ComputationError."""
    line = [build / "lumen", "process", case / "anatomy" / "lumen.vtp", "--edge", edge]
    code, messages, _ = run([*line, "--like", case / "anatomy" / "anatomy.json", "--out", folder])
    if code:
        raise ComputationError("a lumen was not remeshed", case, edge, reason_of(messages))
    return folder / "lumen.vtp"


def deployed(build, case, lumen, device, folder):
    """The results of a deployment in `lumen`, and the surfaces before and after it. Raises ComputationError if it is
    refused."""
    folder.mkdir(parents=True, exist_ok=True)
    scene = json.loads((case / "vci" / "scene.json").read_text(encoding="utf-8"))
    for key, file in (("lumen", lumen), ("centreline", lumen.parent / "centreline.vtp")):
        scene[key] = os.path.relpath(file, folder)
    if device is not None:
        scene["numerics"] = scene.get("numerics", {}) | {"device_edge_mm": device}
    (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
    found = outcome_of(build / "vci", folder / "scene.json")
    if found["outcome"] != "balanced":
        raise ComputationError("a deployment did not balance", case, (str(lumen), device), found["reason"])
    return found, tuple(vtp.read_triangles(f, REMEDY) for f in (lumen, folder / "vci" / "lumen.vtp"))


def rows(build, case, out):
    """The case's rows; the row of the study's own mesh comes first."""
    usual, lumens = None, {None: case / "anatomy" / "lumen.vtp"}
    for wall, device in EDGES:
        if wall not in lumens:
            lumens[wall] = remeshed(build, case, wall, out / case.name / f"anatomy_{wall}")
        name = f"wall_{wall or 'study'}_device_{device or 'study'}"
        found, surfaces = deployed(build, case, lumens[wall], device, out / case.name / name)
        usual = usual or (found, surfaces)
        row = {"case": case.name, "wall_edge_mm": wall, "device_edge_mm": device}
        row |= {key: found[key] for key in ("wall_vertices", "steps", "cpu_seconds", "max_penetration_mm")}
        row["time_ratio"] = found["cpu_seconds"] / usual[0]["cpu_seconds"]
        for key in AREAS:
            row[f"{key}_change_percent"] = 100 * (found[f"{key}_mm2"] / usual[0][f"{key}_mm2"] - 1)
        if wall is not None:
            errors = carried_errors(surfaces, usual[1])
            row |= dict(zip(("carried_mean_mm", "carried_rms_mm", "carried_worst_mm"), errors))
        yield row


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmarks.coarse_walls", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="+", type=pathlib.Path, help="folders with anatomy/ and vci/scene.json")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of vci and lumen")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for coarse_walls.csv and the runs")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "coarse_walls.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for case in options.cases:
            for row in rows(options.build, case, options.out):
                writer.writerow(row)
                file.flush()
                print(", ".join(f"{key} {value}" for key, value in row.items()), file=sys.stderr)


if __name__ == "__main__":
    main()

"""Seconds of a study's cases on coarser walls and devices, and the errors of the lumen that such a wall carries.

/usr/bin/python3 -m vci.benchmarks.coarse_walls results/cases/lad02 --out results/coarse_walls

Each case is deployed on the mesh of the study, and on its lumen remeshed to the edge lengths in MESHES. Errors are
relative to the first mesh of REFERENCE_MESHES that reaches force balance. A coarse wall carries the points of the
study's lumen with it (`coarse_lumen` of a scene). So areas are measured on the surface in which the flow is solved.
`normal_rms_mm` is the distance of these points, along the normal, from where the study's own mesh puts them. The runs
follow one another on one core.
"""

import argparse
import json
import pathlib
import statistics
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import ComputationError, error_summary, guarded
from vci.benchmarks.benchmark import run_outcome, section_areas, write_table
from vci.benchmarks.programs import case_scene, run_program

REFERENCE_MESHES = ((0.25, 0.28), (0.3, 0.34), (0.35, 0.4))  # edges of wall and devices, mm
STUDY_MESH = (None, None)
MESHES = (STUDY_MESH, (0.6, 0.675), (0.8, 0.45), (0.8, 0.9), (1.0, 0.9), (1.0, 1.125))
MOVED_MM = 0.05  # points that move by less do not count, since most of a vessel does not move
ERROR_COLUMNS = ("mean_csa_error_percent", "mla_error_percent")
RUN_COLUMNS = ("wall_vertices", "steps", "cpu_seconds", "max_penetration_mm")
COLUMNS = (
    "case",
    "wall_edge_mm",
    "device_edge_mm",
    "outcome",
    "reason",
    *RUN_COLUMNS,
    "time_ratio",
    *ERROR_COLUMNS,
    "normal_rms_mm",
    "normal_worst_mm",
)
REMEDY = "run the study's rules up to vci/scene.json of this case"


def normal_distances(before, one, other):
    """(root mean square, largest) distance in mm along the normal between two deformed states of the surface `before`,
    over the points that move. All three are vtkPolyData with the same points."""
    start, first, second = (vtp.points(surface) for surface in (before, one, other))
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(other)
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    normal = vtk_to_numpy(normals.GetOutput().GetPointData().GetNormals())
    distances = np.sum((first - second) * normal, axis=1)[np.linalg.norm(second - start, axis=1) > MOVED_MM]
    return float(np.sqrt(np.mean(distances**2))), float(np.abs(distances).max())


def remesh_lumen(build, case, edge, folder):
    """Writes the case's lumen with edges of `edge` mm and its centreline; returns the file. Raises ComputationError."""
    line = [build / "lumen", "process", case / "anatomy" / "lumen.vtp", "--edge", edge]
    code, messages, _ = run_program([*line, "--like", case / "anatomy" / "anatomy.json", "--out", folder])
    if code:
        raise ComputationError("a lumen was not remeshed", case, edge, error_summary(messages))
    return folder / "lumen.vtp"


def deploy_scene(build, case, files, device, folder):
    """Deploys the case's scene and returns (outcome, areas in mm2 along the segment).

    files: {`lumen`, `coarse_lumen`, `centreline`: file} that replace the scene's. device: edge of the devices in mm;
    None: the scene's. The areas are None if the run did not balance. An area is NaN where the section has no closed
    outline.
    """
    folder.mkdir(parents=True, exist_ok=True)
    scene = case_scene(case, folder, files)
    if device is not None:
        scene["numerics"] = scene.get("numerics", {}) | {"device_edge_mm": device}
    (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
    outcome = run_outcome(build / "vci", folder / "scene.json")
    return outcome, section_areas(folder / "vci") if outcome["outcome"] == "balanced" else None


def area_errors(areas, truth):
    """Errors (per cent) of mean and smallest area over the sections that have an area in both runs."""
    known = np.isfinite(areas) & np.isfinite(truth)
    areas, truth = areas[known], truth[known]
    return dict(zip(ERROR_COLUMNS, (100 * (areas.mean() / truth.mean() - 1), 100 * (areas.min() / truth.min() - 1))))


def case_rows(build, case, out):
    """Yields the case's rows: references until one balances, the study's mesh, then walls that carry its lumen."""
    study_files = {key: case / "anatomy" / f"{key}.vtp" for key in ("lumen", "centreline")}
    coarse, reference, study_row = {}, None, None

    def row_of(wall, device, carry):
        if wall is not None and wall not in coarse:
            coarse[wall] = remesh_lumen(build, case, wall, out / case.name / f"anatomy_{wall}")
        files = study_files | {"coarse_lumen": coarse[wall]} if carry else study_files
        if wall is not None and not carry:
            files = {"lumen": coarse[wall], "centreline": coarse[wall].parent / "centreline.vtp"}
        folder = out / case.name / f"wall_{wall or 'study'}_device_{device or 'study'}"
        outcome, areas = deploy_scene(build, case, files, device, folder)
        return {"case": case.name, "wall_edge_mm": wall, "device_edge_mm": device} | outcome, areas

    for wall, device in REFERENCE_MESHES:
        reference, truth = row_of(wall, device, carry=False)
        yield reference
        if reference["outcome"] == "balanced":
            break
    else:
        raise ComputationError("no reference reaches force balance", case, REFERENCE_MESHES, reference["reason"])
    for wall, device in MESHES:
        row, areas = row_of(wall, device, carry=wall is not None)
        study_row = study_row or row
        if row["outcome"] == "balanced":
            row["time_ratio"] = row["cpu_seconds"] / study_row["cpu_seconds"]
            row |= area_errors(areas, truth)
        if row["outcome"] == "balanced" and row is not study_row:
            folders = (f"wall_{wall}_device_{device or 'study'}", "wall_study_device_study")
            surface_files = [study_files["lumen"], *(out / case.name / name / "vci" / "lumen.vtp" for name in folders)]
            distances = normal_distances(*(vtp.read_triangles(file, REMEDY) for file in surface_files))
            row |= dict(zip(("normal_rms_mm", "normal_worst_mm"), distances))
        yield row


def summary_rows(rows):
    """Yields a row for each mesh: median and largest CPU seconds and errors (per cent) of the cases that balanced."""
    cases = len(dict.fromkeys(row["case"] for row in rows))
    rows_with_error = [row for row in rows if ERROR_COLUMNS[0] in row]
    for mesh in dict.fromkeys((row["wall_edge_mm"], row["device_edge_mm"]) for row in rows_with_error):
        mesh_rows = [row for row in rows_with_error if (row["wall_edge_mm"], row["device_edge_mm"]) == mesh]
        seconds = [row["cpu_seconds"] for row in mesh_rows]
        yield {
            "wall_edge_mm": mesh[0] or "study",
            "device_edge_mm": mesh[1] or "study",
            "balanced": f"{len(mesh_rows)} of {cases}",
            "median_cpu_seconds": statistics.median(seconds),
            "largest_cpu_seconds": max(seconds),
            **{f"median_{key}": statistics.median(abs(row[key]) for row in mesh_rows) for key in ERROR_COLUMNS},
            **{f"largest_{key}": max((row[key] for row in mesh_rows), key=abs) for key in ERROR_COLUMNS},
        }


@guarded
def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m vci.benchmarks.coarse_walls", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="+", type=pathlib.Path, help="folders with anatomy/ and vci/scene.json")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of vci and lumen")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for coarse_walls.csv and the runs")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for case in options.cases:
        for row in case_rows(options.build, case, options.out):
            rows.append({key: row[key] for key in COLUMNS if key in row})
            write_table(rows, COLUMNS, options.out / "coarse_walls.csv")
            print(", ".join(f"{key} {value}" for key, value in rows[-1].items()), file=sys.stderr)
    mesh_summary = list(summary_rows(rows))
    write_table(mesh_summary, list(mesh_summary[0]), options.out / "summary.csv")


if __name__ == "__main__":
    main()

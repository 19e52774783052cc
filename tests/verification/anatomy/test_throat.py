"""A severe narrowing has as many edges round it as the healthy vessel. So it stays round when it is opened."""

import csv
import json
import subprocess

import numpy as np
import pytest
import surfaces
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

HEALTHY, LENGTH, THROAT_AT, EDGE = 1.6, 24.0, 12.0, 0.4


def radius(s):
    """Radius of a vessel with a stenosis of 66 % by diameter, 8 mm long."""
    inside = np.abs(s - THROAT_AT) < 4
    return HEALTHY * (1 - 0.66 * np.where(inside, np.cos(np.pi * (s - THROAT_AT) / 8) ** 2, 0))


@pytest.fixture(scope="module")
def states(binary, tmp_path_factory):
    """{state: (summary, rows, polydata)}: of the narrowed tube, of this result processed again, and of the tube opened
    to HEALTHY."""
    folder, out = tmp_path_factory.mktemp("throat"), {}

    def run(surface, name, *options):
        command = [binary("lumen"), "process", surface, "--edge", EDGE, "--spacing", 0.25, "--out", folder / name]
        done = subprocess.run([str(c) for c in [*command, *options]], text=True, capture_output=True)
        assert done.returncode == 0, done.stderr
        with (folder / name / "sections.csv").open() as file:
            rows = list(csv.DictReader(file))
        summary = json.loads((folder / name / "anatomy.json").read_text())
        out[name] = (summary, rows, surfaces.read(folder / name / "lumen.vtp"))

    run(surfaces.write(folder / "tube.stl", *surfaces.tube(surfaces.straight, radius, LENGTH, 0.1)), "pre")
    like = ("--like", folder / "pre" / "anatomy.json")
    run(folder / "pre" / "lumen.vtp", "again", *like)
    opened = surfaces.read(folder / "pre" / "lumen.vtp")
    points, _ = surfaces.arrays(opened)
    points[:, 1:] *= (HEALTHY / radius(points[:, 0]))[:, None]
    opened.GetPoints().SetData(numpy_to_vtk(points, deep=True))
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(folder / "opened.vtp"))
    writer.SetInputData(opened)
    writer.Write()
    run(folder / "opened.vtp", "opened", *like)
    return out


def section(data, x):
    """(area, mean edge length of the triangles cut) of a closed surface at this x."""
    points, triangles = surfaces.arrays(data)
    plane = vtk.vtkPlane()
    plane.SetOrigin(x, 0, 0)
    plane.SetNormal(1, 0, 0)
    cutter = vtk.vtkCutter()
    cutter.SetInputData(data)
    cutter.SetCutFunction(plane)
    cutter.Update()
    loop, lines = (cutter.GetOutput().GetPoints(), cutter.GetOutput().GetLines())
    yz = vtk_to_numpy(loop.GetData())[:, 1:].astype(float)
    ends = yz[vtk_to_numpy(lines.GetData()).reshape(-1, 3)[:, 1:]]
    area = 0.5 * np.abs(ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0]).sum()  # star-shaped
    corners = points[triangles]
    cut = corners[(corners[:, :, 0].min(axis=1) < x) & (corners[:, :, 0].max(axis=1) > x)]
    return area, np.linalg.norm(cut - np.roll(cut, 1, axis=1), axis=2).mean()


def test_as_many_edges_round_the_throat(states):
    data = states["pre"][2]
    around = [2 * np.pi * radius(x) / section(data, x)[1] for x in (THROAT_AT, 4.0)]
    assert around[0] > 0.8 * around[1]
    summary = states["pre"][0]["mesh"]
    assert summary["edge_mm"] == EDGE and 0.05 < summary["smallest_edge_mm"] < 0.2


def test_area_at_the_throat(states):
    area, _ = section(states["pre"][2], THROAT_AT)
    assert area == pytest.approx(np.pi * radius(THROAT_AT) ** 2, rel=0.01)


@pytest.mark.parametrize("state", ["pre", "again"])
def test_sections_follow_the_narrowing(states, state):
    rows = [row for row in states[state][1] if row["flag"] == "ok"]
    s, area = (np.array([float(row[k]) for row in rows]) for k in ("x_mm", "area_mm2"))
    ratio = area / (np.pi * radius(s) ** 2)
    at_throat = np.abs(s - THROAT_AT) < 0.3
    assert at_throat.any() and np.abs(ratio[at_throat] - 1).max() < 0.01
    assert abs(ratio.mean() - 1) < 0.01


def test_opened_throat_is_round(states):
    rows = [row for row in states["opened"][1] if row["flag"] == "ok"]
    area = np.array([float(row["area_mm2"]) for row in rows])
    assert np.abs(area / (np.pi * HEALTHY**2) - 1).max() < 0.01
    assert not states["opened"][0]["lesions"]


@pytest.mark.parametrize("state", ["pre", "again", "opened"])
def test_mesh_is_sound(states, state):
    summary, _, data = states[state]
    _, triangles = surfaces.arrays(data)
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forward = {tuple(edge) for edge in edges}
    assert len(forward) == len(edges) and all((b, a) in forward for a, b in forward)
    assert summary["mesh"]["min_angle_deg"] >= 30
    assert set(vtk_to_numpy(data.GetCellData().GetArray("region_id"))) == {0, 1, 2}

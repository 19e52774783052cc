"""Real pull-backs: the shipped one and those of the shared data, from tables to the measured lumen."""

import csv
import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest
import vtk

from anatomy.contours import run
from anatomy.lumen_results import read_sections
from anatomy.planning import outer_wall
from anatomy.register.run import run as register
from common import vtp

PULL_BACKS = ["ivus_full", "ivus_prestent", "ivus_poststent", "ivus_rest", "aivus"]
FULL = {"outer_wall": "eem_diastolic_contours.csv", "calcium": "calcium_diastolic_contours.csv"}


def shipped(repo_root):
    folder = repo_root / "config" / "patients" / "ivus_plaque"
    return {name: folder / f"{name}.csv" for name in ("lumen", "outer_wall", "calcium", "branches", "landmarks")}


def tables_of(shared_data, name):
    folder = "aivus" if name == "aivus" else f"multimoda/{name}"
    files = {"lumen": "diastolic_contours.csv", "landmarks": "diastolic_reference_points.csv"}
    files |= FULL if name == "ivus_full" else {}
    return {key: shared_data(f"{folder}/{file}") for key, file in files.items()}


def area_across(surface, z):
    """Area of the section of a surface at z."""
    plane, cutter, stripper = vtk.vtkPlane(), vtk.vtkCutter(), vtk.vtkStripper()
    plane.SetOrigin(0, 0, z)
    plane.SetNormal(0, 0, 1)
    cutter.SetCutFunction(plane)
    cutter.SetInputData(surface)
    stripper.SetInputConnection(cutter.GetOutputPort())
    stripper.JoinContiguousSegmentsOn()
    stripper.Update()
    cut = stripper.GetOutput()
    x, y = vtp.points(cut)[max(vtp.lines(cut), key=len)][:, :2].T
    return abs(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def check_surface(folder, document):
    """Areas at and between the frames, volume, tags."""
    surface = vtp.read_triangles(folder / "lumen.vtp", "")
    rows = document["frames"]
    z = np.array([row["z_mm"] for row in rows])
    areas = np.array([row["lumen_area_mm2"] for row in rows])
    cut = np.array([area_across(surface, at) for at in z[1:-1]])
    assert cut == pytest.approx(areas[1:-1], rel=0.001)
    for low, high, one, other in zip(z, z[1:], areas, areas[1:]):
        between = area_across(surface, 0.5 * (low + high))
        assert min(one, other) * 0.995 < between < max(one, other) * 1.005
    trapezoids = np.sum(0.5 * (areas[1:] + areas[:-1]) * np.diff(z))
    assert document["volume_mm3"] == pytest.approx(trapezoids, rel=0.02)
    region = np.array(surface.GetCellData().GetArray("region_id"))
    assert set(region) == {0, 1, 2}
    points, triangles = vtp.points_and_triangles(surface)
    assert points[triangles[region == 1]][..., 2] == pytest.approx(z.max(), abs=1e-9)
    assert points[triangles[region == 2]][..., 2] == pytest.approx(z.min(), abs=1e-9)


@pytest.mark.parametrize("name", PULL_BACKS)
def test_areas_of_the_lofted_lumen_are_the_contours(shared_data, tmp_path, name):
    check_surface(tmp_path, run.run(tables_of(shared_data, name), tmp_path))


@pytest.mark.parametrize("name", PULL_BACKS[:4])
def test_published_areas_are_reproduced(shared_data, tmp_path, name):
    published = shared_data("multimoda/areas_diastole.csv")
    files = tables_of(shared_data, name)
    rows = [row for row in csv.DictReader(published.open()) if row["pullback"] == name]
    found = run.run(files, tmp_path)["frames"]
    assert [frame["z_mm"] for frame in found] == pytest.approx([float(row["z_mm"]) for row in rows], abs=0.001)
    assert [frame["lumen_area_mm2"] for frame in found] == pytest.approx(
        [float(row["area_mm2"]) for row in rows], abs=0.001
    )


def test_the_shipped_pull_back_is_the_source_s(repo_root, shared_data, tmp_path):
    own = run.run(shipped(repo_root), tmp_path / "own")["frames"]
    source = run.run(tables_of(shared_data, "ivus_full"), tmp_path / "source")["frames"]
    for key in ("lumen_area_mm2", "outer_wall_area_mm2"):
        assert [frame[key] for frame in own] == pytest.approx([frame[key] for frame in source], rel=0.0005)
    arcs = [(one["calcium_arc_deg"], other["calcium_arc_deg"]) for one, other in zip(own, source)]
    assert max(abs(one - other) for one, other in arcs) < 10


def test_the_shipped_lesion(repo_root, tmp_path):
    document = run.run(shipped(repo_root), tmp_path)
    check_surface(tmp_path, document)
    rows = document["frames"]
    tightest = min(rows, key=lambda row: row["lumen_area_mm2"])
    assert tightest["lumen_area_mm2"] == pytest.approx(1.877, abs=0.005) and tightest["z_mm"] == pytest.approx(
        12.70, abs=0.01
    )
    assert tightest["plaque_burden_percent"] == pytest.approx(75.5, abs=0.5)
    assert document["healthy_wall_mm"] == pytest.approx(0.12, abs=0.005)
    assert max(row["calcium_arc_deg"] for row in rows) > 330
    said = " ".join(document["warnings"])
    assert "side branch" in said and "shadow" in said


@pytest.mark.parametrize("name", ["shipped", *PULL_BACKS[1:]])
def test_pull_backs_go_through_the_anatomy(binary, repo_root, shared_data, tmp_path, name):
    document = run.run(shipped(repo_root) if name == "shipped" else tables_of(shared_data, name), tmp_path)
    command = [binary("lumen"), "process", tmp_path / "lumen.vtp", "--out", tmp_path / "anatomy"]
    subprocess.run(command, check=True, capture_output=True)
    anatomy = json.loads((tmp_path / "anatomy" / "anatomy.json").read_text())
    ends = {end["kind"]: end for end in anatomy["ends"]}
    rows = document["frames"]
    assert len(anatomy["ends"]) == 2
    for kind, row in (("inlet", rows[-1]), ("outlet", rows[0])):
        assert ends[kind]["centre_mm"][2] == pytest.approx(row["z_mm"], abs=0.01)
        assert ends[kind]["area_mm2"] == pytest.approx(row["lumen_area_mm2"], rel=0.01)
    assert anatomy["mesh"]["volume_mm3"] == pytest.approx(document["volume_mm3"], rel=0.02)
    if name == "shipped":
        arrays = vtp.read_triangles(tmp_path / "anatomy" / "lumen.vtp", "").GetPointData()
        assert set(np.array(arrays.GetArray("plaque_type"))) == {0, 1, 3}
        assert np.array(arrays.GetArray("plaque_thickness_mm")).max() == pytest.approx(1.1, abs=0.1)


def test_plaque_where_the_wall_was_traced_in_part(binary, tmp_path):
    """The vessel is 30 mm long and 3 mm wide, its outer wall 3.8 mm. The wall was traced only in the throat, as in
    clinical routine."""
    turn = 2 * np.pi * np.arange(60) / 60
    for name, frames in (("lumen", range(61)), ("wall", [24])):
        with (tmp_path / f"{name}.csv").open("w") as file:
            for k in frames:
                narrowed = 0.35 * (1 + np.cos(np.pi * (k - 24) / 10)) if abs(k - 24) < 10 else 0
                radius = 1.9 if name == "wall" else 1.5 - narrowed
                file.writelines(f"{k},{radius * np.cos(t):.4f},{radius * np.sin(t):.4f},{k / 2}\n" for t in turn)
    run.run({"lumen": tmp_path / "lumen.csv", "outer_wall": tmp_path / "wall.csv"}, tmp_path)
    command = [binary("lumen"), "process", tmp_path / "lumen.vtp", "--out", tmp_path / "anatomy"]
    subprocess.run(command, check=True, capture_output=True)
    found = outer_wall.with_lumen_and_plaque_reference(
        read_sections(tmp_path / "anatomy"), tmp_path / "anatomy" / "lumen.vtp"
    )["main"]
    at = np.array([row["z_mm"] for row in found])
    plaque = np.array([np.nan if row["plaque_mm"] is None else row["plaque_mm"] for row in found])
    diameter = np.array([row["reference_diameter_mm"] for row in found])
    healthy = np.abs(at - 12) > 5
    assert np.nanmax(plaque[healthy]) < 0.05 and diameter[healthy] == pytest.approx(3.0, abs=0.1)
    assert plaque[np.abs(at - 12).argmin()] == pytest.approx(0.8, abs=0.05)
    assert diameter[~healthy].min() > 2.9 and diameter.max() < 3.3


@pytest.mark.slow
@pytest.mark.parametrize("z_from", ["distal", "proximal"])
def test_landmarks_of_a_registration_are_read_off_the_tables(binary, repo_root, tmp_path, z_from):
    """The shipped vessel before and after its stent, also with z reversed (25 - z). Formerly a wrong sign gave an error
    of 8.1 mm."""
    places, case = {"before": 15.68, "after": 19.75}, repo_root / "config" / "cases" / "ivus_stent.yaml"
    given = case.read_text()
    for name, z in places.items():
        table = (repo_root / "config" / "patients" / "ivus_stent" / f"{name}.csv").read_text()
        if z_from == "proximal":
            head, *rows = (line.split(",") for line in table.splitlines())
            rows = [[*row[:3], f"{25 - float(row[3]):.4f}"] for row in rows]
            table = "\n".join(",".join(row) for row in [head, *rows])
            given = given.replace(f"[0, 0, {z}]", f"[0, 0, {25 - z:.2f}]")
            places[name] = 25 - z
        (tmp_path / f"{name}.csv").write_text(table)
        run.run({"lumen": tmp_path / f"{name}.csv"}, tmp_path / name, reading={"z_from": z_from})
        command = [binary("lumen"), "process", tmp_path / name / "lumen.vtp", "--out", tmp_path / name / "anatomy"]
        subprocess.run(command, check=True, capture_output=True)
    (tmp_path / "case.yaml").write_text(given)
    folders = (tmp_path / name / "anatomy" for name in places)
    register(tmp_path / "case.yaml", *folders, tmp_path / "post")
    found = json.loads((tmp_path / "post" / "registration.json").read_text())
    assert found["translation_mm"][2] == pytest.approx(places["before"] - places["after"], abs=0.05)
    assert found["landmarks_off_mm"][0] < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["shipped", *PULL_BACKS[1:]])
def test_changes_from_frame_to_frame_are_kept(binary, repo_root, shared_data, tmp_path, name):
    """At the frames the areas of sections.csv equal the outlines' own, where the axis is perpendicular to the frame.

    Areas are interpolated between sections 0.1 mm apart. A section that leans by 5 degrees extends over 0.1 mm of the
    vessel.
    """
    document = run.run(shipped(repo_root) if name == "shipped" else tables_of(shared_data, name), tmp_path)
    command = [binary("lumen"), "process", tmp_path / "lumen.vtp", "--out", tmp_path / "anatomy", "--spacing", "0.1"]
    subprocess.run(command, check=True, capture_output=True)
    assert "areas smoothed" not in (tmp_path / "anatomy" / "anatomy.json").read_text()
    with (tmp_path / "anatomy" / "sections.csv").open() as file:
        rows = sorted((row for row in csv.DictReader(file) if row["flag"] == "ok"), key=lambda row: float(row["z_mm"]))
    z, area, across = (np.array([float(row[key]) for row in rows]) for key in ("z_mm", "area_mm2", "tz"))
    at, frames = np.array([(row["z_mm"], row["lumen_area_mm2"]) for row in document["frames"]]).T
    straight = (at > z[0]) & (at < z[-1]) & (np.abs(np.interp(at, z, across)) > np.cos(np.radians(5)))
    assert straight.sum() >= 10
    off = np.abs(np.interp(at, z, area) / frames - 1)[straight]
    assert off.mean() < 0.012 and off.max() < 0.04


def test_a_pull_back_on_a_ct_centreline(repo_root, shared_data, tmp_path):
    """Centreline and pull-back are of different patients. But the line bends like a coronary, and the sections must
    keep their areas."""
    centreline = shared_data("multimoda/lca_cl.vtp")
    placement_settings = {"centreline": centreline, "line": 2, "proximal_s_mm": 60.0}
    document = run.run(shipped(repo_root), tmp_path, placement_settings=placement_settings)
    straight = run.run(shipped(repo_root), tmp_path / "straight")
    assert document["placing"]["distal_s_mm"] == pytest.approx(60 + document["length_mm"])
    assert document["volume_mm3"] == pytest.approx(straight["volume_mm3"], rel=0.01)
    points = vtp.points(vtp.read_triangles(tmp_path / "lumen.vtp", ""))
    line = vtp.points(vtp.read(centreline, ""))
    near = np.array([np.linalg.norm(line - point, axis=1).min() for point in points[::50]])
    assert near.max() < 2.2  # the widest section's farthest point


def test_the_command_leaves_nothing_behind_where_it_refuses(repo_root, tmp_path):
    files = shipped(repo_root)
    command = [sys.executable, "-m", "anatomy", "contours", files["outer_wall"], "--outer-wall", files["lumen"]]
    found = subprocess.run([*command, "--out", tmp_path / "out"], cwd=repo_root, capture_output=True, text=True)
    assert found.returncode == 2 and "outside the outer wall" in found.stderr and "Traceback" not in found.stderr
    assert not pathlib.Path(tmp_path / "out").exists()

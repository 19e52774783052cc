"""Axis, sections and names of surfaces whose truth is known, from file to files."""

import json

import numpy as np
import pytest
import surfaces
from vtk.util.numpy_support import vtk_to_numpy

from common.implicit.roots import BLEND_MM


def column(rows, name, flag="ok"):
    return np.array([float(row[name]) for row in rows if row["flag"] == flag])


CASES = {
    "straight": (surfaces.straight, lambda s: 1.5 + 0 * s, 30, 0.0),
    "arc": (surfaces.arc(0.3), lambda s: 1.5 + 0 * s, 15, 0.3),
    "tapered": (surfaces.arc(0.1), lambda s: 1.8 - 0.02 * s, 30, 0.1),
    "helix": (surfaces.helix(4, 3), lambda s: 1.2 + 0 * s, 40, 4 / 25),
}


@pytest.mark.parametrize("edge", [0.2, 0.4])
@pytest.mark.parametrize("name", CASES)
def test_clean_tube(process, tmp_path, name, edge):
    axis, radius, length, curvature = CASES[name]
    surface = surfaces.write(tmp_path / "tube.stl", *surfaces.tube(axis, radius, length, edge))
    summary, rows = process(surface, tmp_path / "out", "--inlet", ",".join(map(str, axis(np.zeros(1))[0])))
    s = column(rows, "s_mm")
    x = np.column_stack([column(rows, k) for k in ("x_mm", "y_mm", "z_mm")])
    assert np.linalg.norm(x - axis(s), axis=1).mean() < 0.03  # along the axis included
    fine = axis(np.linspace(0, length, 4000))
    off = np.sqrt(((x[:, None] - fine[None]) ** 2).sum(axis=2).min(axis=1))
    assert off.mean() < 0.01
    kappa = column(rows, "curvature_per_mm").mean()
    assert abs(kappa - curvature) < max(0.02 * curvature, 0.003)
    ratio = column(rows, "area_mm2") / (np.pi * radius(s) ** 2)
    assert abs(ratio.mean() - 1) < 0.01 and ratio.std() < 0.01
    assert abs(summary["branches"][0]["length_mm"] - length) < 0.005 * length
    assert summary["mesh"]["min_angle_deg"] > 30
    assert not summary["lesions"]
    assert [one["what"] for one in summary["repairs"]] == (["reference tapers steeply"] if name == "tapered" else [])
    if name == "helix":
        assert column(rows, "torsion_per_mm").mean() == pytest.approx(3 / 25, rel=0.05)


@pytest.mark.parametrize("edge", [0.25, 0.4])
@pytest.mark.parametrize("name", ["arc", "tapered", "helix"])
def test_noisy_tube(process, tmp_path, name, edge):
    axis, radius, length, curvature = CASES[name]
    surface = surfaces.write(tmp_path / "tube.stl", *surfaces.tube(axis, radius, length, edge, noise=0.05))
    summary, rows = process(surface, tmp_path / "out", "--inlet", ",".join(map(str, axis(np.zeros(1))[0])))
    x = np.column_stack([column(rows, k) for k in ("x_mm", "y_mm", "z_mm")])
    fine = axis(np.linspace(0, length, 4000))
    off = np.sqrt(((x[:, None] - fine[None]) ** 2).sum(axis=2).min(axis=1))
    assert off.mean() < 0.05
    assert column(rows, "curvature_per_mm").mean() == pytest.approx(curvature, rel=0.05)
    ratio = column(rows, "area_mm2") / (np.pi * radius(column(rows, "s_mm")) ** 2)
    assert abs(ratio.mean() - 1) < 0.01 and ratio.std() < 0.01
    if name == "helix":
        assert column(rows, "torsion_per_mm").mean() == pytest.approx(3 / 25, rel=0.1)
        # the length is measured from cap to cap, the chord between their centres
        chord = np.linalg.norm(axis(np.array([length])) - axis(np.array([0.0])))
        assert summary["branches"][0]["tortuosity"] == pytest.approx(length / chord, rel=0.01)


def test_angles_of_a_wall_that_widening_would_fold(process, tmp_path):
    """Noise of a quarter of the edge: some of the changes that widen angles make the wall cross itself."""
    axis, radius, length, _ = CASES["helix"]
    surface = surfaces.write(tmp_path / "tube.stl", *surfaces.tube(axis, radius, length, 0.2, noise=0.05))
    summary, _ = process(surface, tmp_path / "out")
    assert summary["mesh"]["min_angle_deg"] >= 30


def wave(t):
    """Points of a curve whose curvature changes sign and whose plane turns."""
    return np.column_stack([t, 1.5 * np.sin(0.5 * t), 0.8 * np.sin(0.25 * t)])


@pytest.fixture
def tortuous(process, tmp_path):
    axis, length = surfaces.by_arc_length(wave, 30.0)
    surface = surfaces.write(tmp_path / "tube.stl", *surfaces.tube(axis, lambda s: 1.4 + 0 * s, length, 0.2))
    summary, rows = process(surface, tmp_path / "out", "--inlet", "0,0,0")
    return axis, length, summary, rows


def test_tortuous_tube(tortuous):
    """Mean curvature, section areas, tortuosity."""
    axis, length, summary, rows = tortuous
    s, kappa = column(rows, "s_mm"), column(rows, "curvature_per_mm")
    step = 1e-3
    second = (axis(s + step) - 2 * axis(s) + axis(s - step)) / step**2
    assert kappa.mean() == pytest.approx(np.linalg.norm(second, axis=1).mean(), rel=0.02)
    area = column(rows, "area_mm2") / (np.pi * 1.4**2)
    assert abs(area.mean() - 1) < 0.01 and area.std() < 0.01
    chord = np.linalg.norm(axis(np.array([length])) - axis(np.array([0.0])))
    assert summary["branches"][0]["tortuosity"] == pytest.approx(length / chord, rel=0.005)


def test_tortuous_axis(tortuous):
    axis, length, _, rows = tortuous
    x = np.column_stack([column(rows, k) for k in ("x_mm", "y_mm", "z_mm")])
    fine = axis(np.linspace(0, length, 4000))
    assert np.sqrt(((x[:, None] - fine[None]) ** 2).sum(axis=2).min(axis=1)).mean() < 0.01


def test_minimal_lumen_area_of_a_long_lesion(process, tmp_path):
    """Two throats in a tapering vessel: of 60 % and, narrower all the same, of 59 % further on."""

    def healthy(s):
        return 1.9 - 0.015 * s

    def radius(s):
        plateau = 0.3 * np.clip(np.minimum(s - 11, 34 - s), 0, 1)
        throats = [(depth - 0.3) * np.exp(-(((s - at) / 1.8) ** 2)) for depth, at in ((0.6, 17), (0.59, 28))]
        return healthy(s) * (1 - plateau - sum(throats))

    surface = surfaces.write(tmp_path / "tube.stl", *surfaces.tube(surfaces.arc(0.05), radius, 50, 0.15))
    summary, _ = process(surface, tmp_path / "out", "--inlet", "0,0,0")
    (lesion,) = summary["lesions"]
    s = np.linspace(12, 33, 2000)
    least = radius(s).min()
    assert lesion["s_mla_mm"] == pytest.approx(s[radius(s).argmin()], abs=0.3)
    assert lesion["mla_mm2"] == pytest.approx(np.pi * least**2, rel=0.02)
    assert lesion["mld_mm"] == pytest.approx(2 * least, rel=0.01)
    assert lesion["diameter_stenosis_percent"] == pytest.approx(59, abs=0.7)  # there, as its reference


def trapezium(s, a, b):
    """0 outside a to b, 1 inside, with flanks of 2 mm."""
    return np.clip(np.minimum(s - a, b - s) / 2, 0, 1)


def lesions_of(process, tmp_path, radius, length):
    surface = surfaces.write(tmp_path / "tube.stl", *surfaces.tube(surfaces.arc(0.03), radius, length, 0.3))
    summary, _ = process(surface, tmp_path / "out", "--inlet", "0,0,0")
    return summary["lesions"], {one["what"]: one["detail"] for one in summary["repairs"] if one["warning"]}


def test_worst_stenosis_is_not_hidden_by_a_thinner_lumen(process, tmp_path):
    """58 % in a tapering vessel, and behind it, without recovery, 46 %, where the lumen is less."""

    def radius(s):
        return (2.3 - 0.02 * s) * (1 - np.interp(s, [10, 12, 15, 17, 38, 40, 42], [0, 0.58, 0.58, 0.44, 0.44, 0.46, 0]))

    assert radius(40) < radius(15) - 0.02
    (lesion,), warnings = lesions_of(process, tmp_path, radius, 60)
    assert lesion["diameter_stenosis_percent"] == pytest.approx(58, abs=1)
    assert 11.8 < lesion["s_mla_mm"] < 15.2
    assert lesion["reference_diameter_mm"] == pytest.approx(4.0, rel=0.02)
    assert not warnings


def test_lesion_near_the_outlet_of_a_short_wide_vessel(process, tmp_path):
    """Its shoulder is no healthy taper, though most of the few sections lie on it."""

    def radius(s):
        return 2.5 * (1 - 0.6 * np.exp(-(((s - 10) / 2.2) ** 2)))

    points, triangles = surfaces.tube(surfaces.straight, radius, 14, 0.3)
    summary, sections = process(surfaces.write(tmp_path / "s.vtp", points, triangles), tmp_path / "out")
    assert summary["lesions"][0]["diameter_stenosis_percent"] == pytest.approx(60, abs=4)
    assert min(float(row["reference_diameter_mm"]) for row in sections) > 4.2


def test_narrowing_of_nearly_the_whole_vessel(process, tmp_path):
    """Healthy over 5 mm at either end: the narrow part is no reference, and the warning gives that reading as well."""
    (lesion,), warnings = lesions_of(process, tmp_path, lambda s: 1.7 * (1 - 0.55 * trapezium(s, 5, 41)), 46)
    assert lesion["diameter_stenosis_percent"] == pytest.approx(55, abs=1)
    assert lesion["s_start_mm"] == pytest.approx(5, abs=0.5) and lesion["s_end_mm"] == pytest.approx(41, abs=0.5)
    assert "1.53 mm" in warnings["reference by a short healthy part"]


def test_narrowing_up_to_the_outlet(process, tmp_path):
    """Half as wide from 18 mm on: one lesion, measured against the vessel before it."""
    (lesion,), _ = lesions_of(process, tmp_path, lambda s: 1.7 * (1 - 0.5 * trapezium(s, 18, 80)), 45)
    assert lesion["diameter_stenosis_percent"] == pytest.approx(50, abs=1)
    assert lesion["s_start_mm"] == pytest.approx(18, abs=0.5)
    assert lesion["reference_diameter_mm"] == pytest.approx(3.4, rel=0.01)


TREE = [
    ((0, 0, 0), (40, 0, 0), 1.7, 1.4),
    ((14, 0, 0), (14 + 10 * np.cos(0.9), 10 * np.sin(0.9), 0), 1.0, 0.9),
    ((27, 0, 0), (27 + 8 * np.cos(1.0), 0, -8 * np.sin(1.0)), 0.8, 0.7),
]


def test_tree(process, tmp_path):
    surface = surfaces.write(tmp_path / "tree.vtp", *surfaces.tree(TREE))
    summary, rows = process(surface, tmp_path / "out", "--edge", "0.35")
    assert [b["name"] for b in summary["branches"]] == ["main", "side1", "side2"]
    assert [e["name"] for e in summary["ends"]] == ["inlet", "outlet1", "outlet2", "outlet3"]
    assert [e["region_id"] for e in summary["ends"]] == [1, 2, 3, 4]
    for entry, (a, b, _, r1) in zip(summary["ends"][1:], TREE):
        assert np.linalg.norm(np.array(entry["centre_mm"]) - b) < 0.1
        assert entry["diameter_mm"] == pytest.approx(2 * r1, rel=0.03)
    for branch, s_on_parent, length in zip(summary["branches"][1:], (14, 27), (10, 8)):
        assert branch["parent"] == "main"
        assert branch["s_on_parent_mm"] == pytest.approx(s_on_parent, abs=0.5)
        assert branch["length_mm"] == pytest.approx(length, abs=0.3)
    main = [row for row in rows if row["branch"] == "main"]
    truth = lambda s: np.pi * (1.7 - 0.3 * s / 40) ** 2  # noqa: E731
    away = column(main, "area_mm2") / truth(column(main, "s_mm"))
    ostia = column(main, "area_mm2", "ostium") / truth(column(main, "s_mm", "ostium"))
    assert len(ostia) > 6 and abs(ostia.mean() - 1) < 0.05
    assert abs(away.mean() - 1) < 0.01 and away.std() < 0.01
    assert np.hypot(column(main, "y_mm"), column(main, "z_mm")).mean() < 0.02
    # the arrays of lumen.vtp: cap tags at the caps, branch of each triangle
    lumen = surfaces.read(tmp_path / "out" / "lumen.vtp")
    points, triangles = surfaces.arrays(lumen)
    centres = points[triangles].mean(axis=1)
    region = vtk_to_numpy(lumen.GetCellData().GetArray("region_id"))
    branch = vtk_to_numpy(lumen.GetCellData().GetArray("branch_id"))
    assert set(region) == {0, 1, 2, 3, 4}
    assert np.abs(centres[region == 2][:, 0] - 40).max() < 0.05
    assert (branch[centres[:, 1] > 3] == 1).all() and (branch[centres[:, 2] < -3] == 2).all()
    # caps are no wall: nothing lies between their points and the healthy radius
    inner = np.setdiff1d(triangles[region != 0], triangles[region == 0])
    plaque = vtk_to_numpy(lumen.GetPointData().GetArray("plaque_thickness_mm"))
    assert len(inner) > 20 and not plaque[inner].any()


@pytest.mark.parametrize("axis", (1, 2))
def test_an_oval_vessel_at_its_mouths(process, tmp_path, axis):
    """Half as wide again along y or z: the side branches leave from the long and from the short side."""
    points, triangles = surfaces.tree(TREE)
    points[:, axis] *= 1.5
    surface = surfaces.write(tmp_path / "tree.vtp", points, triangles)
    _, rows = process(surface, tmp_path / "out", "--inlet", "0,0,0")
    main = [row for row in rows if row["branch"] == "main"]
    truth = 1.5 * np.pi * (1.7 - 0.3 * column(main, "s_mm", "ostium") / 40) ** 2
    ratio = column(main, "area_mm2", "ostium") / truth
    assert len(ratio) > 6 and abs(ratio.mean() - 1) < 0.02 and np.abs(ratio - 1).max() < 0.05


def test_rounded_mouths_of_side_branches(process, run_module, tmp_path):
    """Their wall flares towards the parent. The flare must hardly widen the ellipse that closes the section.

    The smooth union of two branches flares by up to a quarter of the blend's width, 0.125 mm.
    """
    generated = run_module("data_synthetic", "generate", "config/cases/lad01.yaml", "--out", tmp_path)
    assert generated.returncode == 0, generated.stderr
    _, rows = process(tmp_path / "lumen.vtp", tmp_path / "out", "--units", "mm")
    widening_mm = []
    for branch in json.loads((tmp_path / "truth.json").read_text())["branches"][1:]:
        mouth = [row for row in rows if row["branch"] == branch["name"] and row["flag"] == "ostium"]
        centres = np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in mouth]).reshape(-1, 3)
        away = np.linalg.norm(centres[:, None] - np.array(branch["points_mm"]), axis=2)
        radius = np.array(branch["radius_mm"])[away.argmin(axis=1)]
        widening_mm.extend(np.sqrt(column(mouth, "area_mm2", "ostium") / np.pi) - radius)
    assert len(widening_mm) > 6 and abs(np.mean(widening_mm)) < 0.02
    assert min(widening_mm) > -0.01 and max(widening_mm) < 0.25 * BLEND_MM / 2


def test_earlier_names_are_kept(process, tmp_path):
    surface = surfaces.write(tmp_path / "tree.vtp", *surfaces.tree(TREE))
    summary, _ = process(surface, tmp_path / "pre", "--inlet", "40,0,0")
    points, triangles = surfaces.arrays(surfaces.read(tmp_path / "pre" / "lumen.vtp"))
    moved = surfaces.read(tmp_path / "pre" / "lumen.vtp")
    near = np.exp(-(((points[:, :1] - 20) / 3) ** 2) - (points[:, 1:] ** 2).sum(axis=1, keepdims=True) / 6)
    swollen = points + 0.15 * near * points * [0, 1, 1]
    moved.GetPoints().SetData(surfaces.numpy_to_vtk(swollen, deep=True))
    writer = surfaces.vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(tmp_path / "moved.vtp"))
    writer.SetInputData(moved)
    writer.Write()
    after, _ = process(tmp_path / "moved.vtp", tmp_path / "vci", "--like", tmp_path / "pre" / "anatomy.json")
    for a, b in zip(summary["ends"], after["ends"]):
        assert a["name"] == b["name"] and a["branch"] == b["branch"] and a["region_id"] == b["region_id"]
        assert np.linalg.norm(np.subtract(a["centre_mm"], b["centre_mm"])) < 0.05
    # the plaque of the earlier state travels with the surface
    before = vtk_to_numpy(surfaces.read(tmp_path / "pre" / "lumen.vtp").GetPointData().GetArray("plaque_thickness_mm"))
    carried = surfaces.read(tmp_path / "vci" / "lumen.vtp").GetPointData().GetArray("plaque_thickness_mm")
    assert vtk_to_numpy(carried).max() == pytest.approx(before.max(), abs=0.05)


def test_a_side_branch_in_a_lesion_runs_through_plaque(process, tmp_path):
    """Its wall lies in the plaque of the narrowed vessel as far as that vessel's healthy radius."""
    narrowed = [
        ((0, 0, 0), (14, 0, 0), 1.7, 1.7),
        ((14, 0, 0), (20, 0, 0), 1.7, 0.7),
        ((20, 0, 0), (26, 0, 0), 0.7, 1.7),
    ]
    segments = [*narrowed, ((26, 0, 0), (40, 0, 0), 1.7, 1.7), ((20, 0, 0), (20, 9, 0), 0.6, 0.6)]
    surface = surfaces.write(tmp_path / "tree.vtp", *surfaces.tree(segments, inner=(0, 1, 2)))
    summary, _ = process(surface, tmp_path / "out", "--inlet", "0,0,0")
    assert [b["name"] for b in summary["branches"]] == ["main", "side1"]
    lumen = surfaces.read(tmp_path / "out" / "lumen.vtp")
    points, triangles = surfaces.arrays(lumen)
    branch = vtk_to_numpy(lumen.GetCellData().GetArray("branch_id"))
    plaque = vtk_to_numpy(lumen.GetPointData().GetArray("plaque_thickness_mm"))
    side = np.setdiff1d(triangles[branch == 1], triangles[branch == 0])
    off_axis = np.hypot(points[side, 1], points[side, 2])
    inside, beyond = off_axis < 1.6, off_axis > 1.8
    assert inside.sum() > 20 and beyond.sum() > 100
    assert np.abs(plaque[side][inside] - (1.7 - off_axis[inside])).max() < 0.12
    assert plaque[side][beyond].max() < 0.05


def test_plaque_is_carried_over_from_where_it_is(process, tmp_path):
    """A thickness that is linear in space, so that interpolation at the nearest point is exact."""
    points, triangles = surfaces.tube(surfaces.arc(0.05), lambda s: 1.6 - 0.01 * s, 20, 0.25)
    gradient = np.array([0.02, 0.01, 0.25])
    data = surfaces.polydata(points, triangles)
    for name, values in (("plaque_thickness_mm", 1 + points @ gradient), ("plaque_type", np.ones(len(points)))):
        array = surfaces.numpy_to_vtk(values, deep=True)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    writer = surfaces.vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(tmp_path / "tube.vtp"))
    writer.SetInputData(data)
    writer.Write()
    process(tmp_path / "tube.vtp", tmp_path / "out")
    lumen = surfaces.read(tmp_path / "out" / "lumen.vtp")
    given, cells = surfaces.arrays(lumen)
    wall = np.unique(cells[vtk_to_numpy(lumen.GetCellData().GetArray("region_id")) == 0])
    carried = vtk_to_numpy(lumen.GetPointData().GetArray("plaque_thickness_mm"))
    off = np.abs(carried - 1 - given @ gradient)[wall]
    assert off.max() < 0.012 * np.linalg.norm(gradient)  # the wall moves by up to 0.012 mm where the facets are curved


def test_same_input_same_bits(process, tmp_path):
    surface = surfaces.write(tmp_path / "tree.vtp", *surfaces.tree(TREE))
    for run in ("a", "b"):
        process(surface, tmp_path / run)
    for name in ("lumen.vtp", "centreline.vtp", "sections.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    a, b = (json.loads((tmp_path / run / "anatomy.json").read_text()) for run in ("a", "b"))
    a.pop("timings_s"), b.pop("timings_s")
    assert a == b

"""The wall's stretch outside the edges of stents, on straight tubes of known stretch."""

import numpy as np
import pytest

from common import vtp
from common.errors import InputError
from reports.inputs.case_files import CaseFiles
from reports.measuring.stent_edges import RUPTURE_STRETCH, stent_edges
from reports.page.case_context import edge_readouts, edge_warnings

RADIUS_MM, AROUND, SPACING_MM = 1.5, 24, 0.25
STENT = {"device": "des", "branch": "main"}


def tube(path_mm):
    """Points and triangles of an open tube about a line of points (n, 3), and the number of each point's ring."""
    tangents = np.gradient(path_mm, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    across = np.cross(tangents, [0.0, 0.0, 1.0])
    theta = 2 * np.pi * np.arange(AROUND) / AROUND
    spokes = across[:, None] * np.cos(theta)[:, None] + np.array([0.0, 0.0, 1.0]) * np.sin(theta)[:, None]
    a = (np.arange(len(path_mm) - 1)[:, None] * AROUND + np.arange(AROUND)).ravel()
    b = np.where((a + 1) % AROUND == 0, a + 1 - AROUND, a + 1)
    triangles = np.vstack([np.column_stack([a, b, a + AROUND]), np.column_stack([b, b + AROUND, a + AROUND])])
    return (path_mm[:, None] + RADIUS_MM * spokes).reshape(-1, 3), triangles, np.repeat(np.arange(len(path_mm)), AROUND)


def along(axis, first, last, start=(0.0, 0.0, 0.0)):
    """Points every SPACING_MM on a straight line from `start` along a coordinate axis, from first to last (mm)."""
    s = np.arange(first, last + 1e-9, SPACING_MM)
    return np.array(start) + s[:, None] * np.eye(3)[axis]


def write_centreline(path, lines):
    poly, cells, names = (
        vtp.surface(np.vstack(list(lines.values())), []),
        vtp.vtk.vtkCellArray(),
        vtp.vtk.vtkStringArray(),
    )
    names.SetName("branch_name")
    first = 0
    for name, points in lines.items():
        cells.InsertNextCell(len(points), range(first, first + len(points)))
        names.InsertNextValue(name)
        first += len(points)
    poly.SetLines(cells)
    s_mm = np.concatenate([SPACING_MM * np.arange(len(points)) for points in lines.values()])
    vtp.add_array(poly.GetPointData(), "s_mm", s_mm)
    vtp.add_array(poly.GetPointData(), "curvature_per_mm", 0.0 * s_mm)
    poly.GetCellData().AddArray(names)
    vtp.write(path, poly)


@pytest.fixture
def case(tmp_path):
    """case(stretch, stents, side) -> CaseFiles: a tube along x of 40 mm, with side branch along y from x = 20 mm.

    stretch: function of (branch, s in mm). stents: the lines of the stents' axes.
    """

    def make(stretch, stents, side=False):
        lines = {"main": along(0, 0.0, 40.0)} | ({"side1": along(1, 0.0, 20.0, (20.0, 0.0, 0.0))} if side else {})
        for folder in ("vci/anatomy", "vci/devices"):
            (tmp_path / folder).mkdir(parents=True)
        write_centreline(tmp_path / "vci" / "anatomy" / "centreline.vtp", lines)
        walls = {name: tube(line if name == "main" else line[8:]) for name, line in lines.items()}  # 2 mm of ostium
        start = {"main": 0.0, "side1": 2.0}
        values = [stretch(name, start[name] + SPACING_MM * row) for name, (_, _, ring) in walls.items() for row in ring]
        points = np.vstack([wall[0] for wall in walls.values()])
        lumen = vtp.surface(points, walls["main"][1])
        vtp.add_array(lumen.GetPointData(), "wall_stretch", np.array(values))
        vtp.write(tmp_path / "vci" / "lumen.vtp", lumen)
        for number, axis in enumerate(stents, 1):
            vtp.write(tmp_path / "vci" / "devices" / f"stent{number}.vtp", vtp.surface(*tube(axis)[:2]))
        return CaseFiles("tube", tmp_path)

    return make


def test_the_largest_stretch_within_5_mm_outside_each_edge(case):
    files = case(lambda _, s: 1.0 + 0.02 * s, [along(0, 12.0, 30.0)])
    rows = stent_edges(files, [STENT])
    assert [(row["stent"], row["branch"], row["end"]) for row in rows] == [
        (1, "main", "proximal"),
        (1, "main", "distal"),
    ]
    assert rows[0]["largest_stretch"] == pytest.approx(1.24, abs=0.006) and not rows[0]["beyond_limit"]
    assert rows[1]["largest_stretch"] == pytest.approx(1.70, abs=0.006) and rows[1]["beyond_limit"]
    assert rows[0]["largest_stretch"] < RUPTURE_STRETCH < rows[1]["largest_stretch"]


def test_stretch_within_the_stent_or_far_from_it_is_no_hint(case):
    files = case(lambda _, s: 4.0 if 12.5 < s < 29.5 or s < 6.5 or s > 35.5 else 1.1, [along(0, 12.0, 30.0)])
    assert [row["largest_stretch"] for row in stent_edges(files, [STENT])] == pytest.approx([1.1, 1.1])


def test_an_edge_in_another_stent_is_left_out(case):
    files = case(lambda _, s: 1.0 + 0.02 * s, [along(0, 12.0, 22.0), along(0, 16.0, 30.0)])
    rows = stent_edges(files, [STENT, STENT])
    assert [(row["stent"], row["end"]) for row in rows] == [(1, "proximal"), (2, "distal")]


def test_what_lies_under_a_neighbouring_stent_is_not_outside_an_edge(case):
    files = case(
        lambda _, s: 4.0 if 12.5 < s < 19.5 or 22.5 < s < 29.5 else 1.1, [along(0, 12.0, 20.0), along(0, 22.0, 30.0)]
    )
    assert [row["largest_stretch"] for row in stent_edges(files, [STENT, STENT])] == pytest.approx([1.1] * 4)


def test_edges_in_words_with_a_hint_where_the_wall_is_stretched_too_far(case):
    rows = stent_edges(case(lambda _, s: 1.0 + 0.02 * s, [along(0, 12.0, 30.0)]), [STENT])
    assert edge_readouts(rows) == [
        "largest wall stretch within 5 mm of the edges of stent 1: 1.24 proximal, 1.70 distal"
    ]
    hints = edge_warnings(rows)
    assert len(hints) == 1 and hints[0].startswith(
        "stent 1, distal edge in main: next to it the wall is stretched to 1.70"
    )


def test_a_stent_from_the_parent_into_a_side_branch(case):
    path = np.vstack([along(0, 16.0, 20.0), along(1, SPACING_MM, 9.0, (20.0, 0.0, 0.0))])
    stretch = {"main": lambda s: 1.7 if 10.9 < s < 16.1 else 3.0, "side1": lambda s: 1.3 if 8.9 < s < 14.1 else 3.0}
    rows = stent_edges(case(lambda name, s: stretch[name](s), [path], side=True), [STENT | {"branch": "side1"}])
    assert [(row["end"], row["branch"]) for row in rows] == [("proximal", "main"), ("distal", "side1")]
    assert [row["largest_stretch"] for row in rows] == pytest.approx([1.7, 1.3])


def test_a_procedure_without_a_stent_has_no_edges(case):
    assert stent_edges(case(lambda _, s: 2.0, []), []) == []


def test_a_missing_stent_and_one_without_two_ends_are_refused(case):
    files = case(lambda _, s: 1.0, [along(0, 12.0, 30.0)])
    with pytest.raises(InputError, match=r"do not match deployment.json(.|\n)*1 files, 2 stents"):
        stent_edges(files, [STENT, STENT])
    points, triangles, _ = tube(along(0, 12.0, 30.0))
    vtp.write(files.stent_files()[0], vtp.surface(points, np.delete(triangles, 900, axis=0)))
    with pytest.raises(InputError, match=r"two open ends(.|\n)*3 ends"):
        stent_edges(files, [STENT])

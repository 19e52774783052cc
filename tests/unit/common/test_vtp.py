"""Surfaces and lines in VTK files: what is written comes back; what is not one is refused."""

import numpy as np
import pytest
import vtk

from common import vtp
from common.errors import InputError

POINTS = np.array([[0.1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1 / 3]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def lines_of(cells):
    poly, vtk_points, array = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    for point in POINTS:
        vtk_points.InsertNextPoint(*point)
    for cell in cells:
        array.InsertNextCell(len(cell), cell)
    poly.SetPoints(vtk_points)
    poly.SetLines(array)
    return poly


def test_a_surface_and_its_arrays_come_back_exactly(tmp_path):
    poly = vtp.surface(POINTS, TRIANGLES)
    vtp.add_array(poly.GetPointData(), "radius_mm", np.array([1.5, 2.5, 3.5, 1 / 7]))
    vtp.add_array(poly.GetCellData(), "region_id", np.array([0, 1, 2, 3], np.int32))
    vtp.write(tmp_path / "new" / "lumen.vtp", poly)
    found = vtp.read_triangles(tmp_path / "new" / "lumen.vtp", "make it")
    points, triangles = vtp.points_and_triangles(found)
    assert np.array_equal(points, POINTS) and np.array_equal(triangles, TRIANGLES)
    assert found.GetPointData().GetArray("radius_mm").GetValue(3) == 1 / 7
    assert found.GetCellData().GetArray("region_id").GetValue(2) == 2
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["lumen.vtp"]


def test_stl_is_binary_and_holds_every_triangle(tmp_path):
    vtp.write(tmp_path / "lumen.stl", vtp.surface(POINTS, TRIANGLES))
    data = (tmp_path / "lumen.stl").read_bytes()
    assert len(data) == 84 + 50 * len(TRIANGLES) and int.from_bytes(data[80:84], "little") == len(TRIANGLES)


def test_lines_come_back_one_by_one(tmp_path):
    vtp.write(tmp_path / "lines.vtp", lines_of([[0, 1, 2], [3, 0]]))
    found = vtp.lines(vtp.read(tmp_path / "lines.vtp", ""))
    assert [line.tolist() for line in found] == [[0, 1, 2], [3, 0]]
    assert vtp.lines(vtp.surface(POINTS, TRIANGLES)) == []


def test_what_is_no_surface_is_refused_with_the_remedy(tmp_path):
    (tmp_path / "text.vtp").write_text("solid")
    vtp.write(tmp_path / "lines.vtp", lines_of([[0, 1]]))
    for name, words in (("none.vtp", "missing"), ("text.vtp", "not a VTK file")):
        with pytest.raises(InputError, match=words) as error:
            vtp.read(tmp_path / name, "make it again")
        assert "make it again" in str(error.value)
    with pytest.raises(InputError, match="not a triangle surface"):
        vtp.read_triangles(tmp_path / "lines.vtp", "")
    with pytest.raises(InputError, match="no points"):
        vtp.write(tmp_path / "empty.vtp", vtk.vtkPolyData())
        vtp.read(tmp_path / "empty.vtp", "")

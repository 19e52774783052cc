"""Inputs that a user may give besides the image: a centreline, stent struts, the methods of a study."""

import numpy as np
import pytest
import vtk

from anatomy.ct import segment
from common import vtp
from common.errors import InputError
from data_synthetic.ct import phantom, struts, study, vessel


def write_lines(path, lines, names=None):
    points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetDataTypeToDouble()
    for line in lines:
        cells.InsertNextCell(len(line))
        for point in line:
            cells.InsertCellPoint(points.InsertNextPoint(*point))
    poly = vtk.vtkPolyData()
    poly.SetPoints(points)
    poly.SetLines(cells)
    if names:
        array = vtk.vtkStringArray()
        array.SetName("branch_name")
        for name in names:
            array.InsertNextValue(name)
        poly.GetCellData().AddArray(array)
    vtp.write(path, poly)
    return path


def test_struts_of_a_file_have_their_lengths(tmp_path):
    path = write_lines(tmp_path / "struts.vtp", [[(0, 0, 0), (3, 4, 0)], [(1, 0, 0), (1, 0, 1), (1, 0, 1.5)]])
    points, lengths = struts.read_struts(path)
    assert lengths.sum() == pytest.approx(6.5) and lengths.max() < 1.01 * struts.PIECE_LENGTH_MM
    assert np.average(points, axis=0, weights=lengths) == pytest.approx(
        (5 * np.array([1.5, 2, 0]) + 1.5 * np.array([1, 0, 0.75])) / 6.5
    )


def test_files_without_struts_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        struts.read_struts(tmp_path / "none.vtp")
    with pytest.raises(InputError, match="nothing in the file"):
        struts.read_struts(write_lines(tmp_path / "empty.vtp", []))


def test_a_given_centreline_is_centred(ct_tubes, tmp_path):
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 1.5))
    settings = ct_tubes.settings()
    volume = phantom.render(vessel.from_surface(poly, "tube"), settings["phantom"])
    ends = [("inlet", 0 * direction), ("outlet1", 14 * direction)]
    # A user's line says which vessel is meant; it may be some tenths of a millimetre off the middle.
    across = np.cross(direction, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    line = np.linspace(0, 14, 57)[:, None] * direction + 0.2 * across
    given = vtp.read_named_lines(write_lines(tmp_path / "centreline.vtp", [line], ["main"]), "")
    found = segment.segment(volume, ends, settings["segmentation"], given)
    tube = found["tubes"][0]
    away = tube.axis.points_mm - (tube.axis.points_mm @ direction)[:, None] * direction
    assert np.allclose(away, 0.0, atol=0.03)
    middle = tube.radii_mm[10:-10].mean(axis=0)
    assert middle.max() - middle.min() < 0.05
    with pytest.raises(InputError, match="away from every end point"):
        segment.segment(volume, ends, settings["segmentation"], {"main": line[:30]})


def test_a_centreline_without_names_is_refused(tmp_path):
    path = write_lines(tmp_path / "line.vtp", [[(0, 0, 0), (1, 0, 0)]])
    with pytest.raises(InputError, match="not a centreline"):
        vtp.read_named_lines(path, "")


def test_a_method_that_the_study_does_not_know_is_named(tmp_path):
    with pytest.raises(InputError, match="sharp"):
        study.run([], [0.35], 1, tmp_path / "table.csv", methods=["psf_edge", "sharp"])
    study.run([], [0.35], 1, tmp_path / "table.csv", methods=["half_maximum"])
    assert (tmp_path / "table.csv").read_text().startswith("case,state")

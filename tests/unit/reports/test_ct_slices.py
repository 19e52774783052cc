"""Slices of the CT: the volume in the lumen's frame, outlines and plaque in their places."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import vtk

from common.volume import Image, write
from reports.figures.ct_slices import draw_outline, cross_section_plane, read_volume, draw_slice
from reports.inputs.polyline import Polyline
from tests.unit.reports.conftest import Tube, add_array, tube_surface, write_vtp

ORIGIN, SPACING = np.array([-8.0, -6.0, -7.0]), np.array([0.5, 0.4, 0.6])


@pytest.fixture
def volume(tmp_path):
    """HU = 10 x + 20 y + 30 z, which interpolation gives back exactly; and its file."""
    index = np.stack(np.meshgrid(*(np.arange(n) for n in (50, 40, 30)), indexing="ij"), -1)
    values = (ORIGIN + SPACING * index) @ [10.0, 20.0, 30.0]
    write(Image(values, ORIGIN, SPACING), tmp_path / "ct.nii.gz", "test")
    return tmp_path / "ct.nii.gz"


def test_a_slice_lies_where_the_line_is(volume):
    values, origin, spacing = read_volume(volume)
    assert origin == pytest.approx(ORIGIN) and spacing == pytest.approx(SPACING)
    line = Polyline(np.array([[2.0, 0.0, z] for z in np.arange(-5.0, 6.0)]), np.arange(11.0), "test")
    centre, across = cross_section_plane(line, 4.5)
    assert centre == pytest.approx([2.0, 0.0, -0.5]) and across @ [0.0, 0.0, 1.0] == pytest.approx([0.0, 0.0])
    _, axes = plt.subplots()
    draw_slice(axes, values, origin, spacing, centre, across)
    grey = axes.images[0].get_array()
    assert grey[100, 100] == pytest.approx(10 * 2.0 - 30 * 0.5, abs=1.0)
    corner = centre - 5.0 * across.sum(0)
    assert grey[0, 0] == pytest.approx(corner @ [10.0, 20.0, 30.0], abs=1.0)
    plt.close()


@pytest.mark.parametrize("state, lines", [("pre", 2), ("reference", 1), ("ct_pre", 1)])
def test_outlines_of_lumen_and_plaque(tmp_path, state, lines):
    tube, place = Tube(0.0), 20.0
    surface = tube_surface(tube, around=60)
    add_array(surface.GetPointData(), "plaque_thickness_mm", np.full(surface.GetNumberOfPoints(), 0.7))
    write_vtp(tmp_path / "lumen.vtp", surface)
    line = Polyline(tube.frame(tube.s())[0], tube.s(), "test")
    _, axes = plt.subplots()
    draw_outline(axes, tmp_path / "lumen.vtp", *cross_section_plane(line, place), state)
    assert len(axes.lines) == lines, "plaque belongs to the lumen before the procedure"
    for drawn, radius in zip(axes.lines, (1.6, 2.3)):
        assert np.hypot(*drawn.get_data()) == pytest.approx(radius, abs=0.02)
    plt.close()


def test_panels_keep_their_scale_where_an_outline_leaves_them(tmp_path, volume):
    """A tube of radius 6 mm is wider than the square of 10 mm that is drawn."""
    tube = Tube(0.0, curvature=0.01, radius=6.0)
    write_vtp(tmp_path / "lumen.vtp", tube_surface(tube, around=60))
    line = Polyline(tube.frame(tube.s())[0], tube.s(), "test")
    _, axes = plt.subplots()
    plane = cross_section_plane(line, 20.0)
    draw_slice(axes, *read_volume(volume), *plane)
    draw_outline(axes, tmp_path / "lumen.vtp", *plane, "reference")
    assert np.abs(axes.lines[0].get_data()).max() > 5.5
    assert axes.get_xlim() == axes.get_ylim() == (-5.0, 5.0)
    plt.close()


def test_an_outline_that_turns_back_is_drawn_in_its_order(tmp_path):
    """The outline of an L-shaped prism, seen from its middle, is not in the order of the angle."""
    corners = np.array([[0, 0], [6, 0], [6, 1], [1, 1], [1, 6], [0, 6]], float)
    shape = vtk.vtkLinearExtrusionFilter()
    shape.SetInputData(_polygon(corners))
    shape.SetVector(0, 0, 4)
    shape.Update()
    write_vtp(tmp_path / "lumen.vtp", shape.GetOutput())
    _, axes = plt.subplots()
    draw_outline(axes, tmp_path / "lumen.vtp", np.array([0.5, 0.5, 2.0]), np.eye(3)[:2], "reference")
    drawn = np.stack(axes.lines[0].get_data(), 1)
    assert np.linalg.norm(np.diff(drawn, axis=0), axis=1).sum() == pytest.approx(24.0)  # the perimeter, closed
    plt.close()


def _polygon(corners):
    """A vtkPolyData of the closed line through corners (n, 2) at z = 0."""
    points, lines = vtk.vtkPoints(), vtk.vtkCellArray()
    for corner in corners:
        points.InsertNextPoint(*corner, 0.0)
    lines.InsertNextCell(len(corners) + 1, [*range(len(corners)), 0])
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetLines(lines)
    return data

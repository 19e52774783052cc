"""Warnings of pull-backs with probably wrong units, the wrong direction or mixed phases. Sound ones get no warning."""

import numpy as np
import pytest
from contour_tables import sector, tube

from anatomy.contours import line, run


def warnings_of(table, folder, frames, **options):
    return run.run({"lumen": table(frames)}, folder, **options)["warnings"]


def said(warnings, words):
    return any(words in warning for warning in warnings)


@pytest.mark.parametrize("radius, told", [(1.5, False), (2.9, False), (4.5, True), (0.5, True)])
def test_a_lumen_too_wide_or_too_narrow_for_its_units(table, tmp_path, radius, told):
    assert said(warnings_of(table, tmp_path / "out", tube([radius] * 6)), "check units") == told


@pytest.mark.parametrize("turned, told", [(False, False), (True, True)])
def test_a_vessel_that_widens_towards_its_distal_end(table, tmp_path, turned, told):
    """z rises from the distal end. A lesion in the proximal third must not make this third count as narrow."""
    radii = np.linspace(1.2, 1.8, 13)
    radii[10] = 0.9
    found = warnings_of(table, tmp_path / "out", tube(radii[::-1] if turned else radii))
    assert said(found, "z_from: proximal") == told


def numbered(spacing, count=20):
    """Frames 0 to 19, `spacing` mm apart."""
    frames = tube([1.5] * count, spacing=spacing).values()
    return {k: (k * spacing, outline) for k, (_, outline) in enumerate(frames)}


@pytest.mark.parametrize("spacing, told", [(1.0, True), (0.5, False)])
def test_z_that_counts_frames(table, tmp_path, spacing, told):
    """If frame numbers are taken for z in mm, vessel and lesion become twice as long."""
    assert said(warnings_of(table, tmp_path / "out", numbered(spacing)), "z is the frame's number") == told


def test_the_columns_of_frame_and_z_exchanged(table, tmp_path):
    """The column names are not known, so the first column is taken for the frame."""
    frames = {0.5 * k: (float(k), outline) for k, (_, outline) in numbered(1.0).items()}
    assert said(warnings_of(table, tmp_path / "out", frames), "are the two columns exchanged")


@pytest.mark.parametrize("spacing, told", [(0.2, True), (0.5, False)])
def test_a_pull_back_shorter_than_two_diameters(table, tmp_path, spacing, told):
    frames = tube([1.5] * 20, spacing=spacing)
    assert said(warnings_of(table, tmp_path / "out", frames), "are z, x and y in the same") == told


@pytest.mark.parametrize("systole, told", [(0.9, True), (0.99, False)])
def test_frames_of_two_phases(table, tmp_path, systole, told):
    radii = 1.5 * np.where(np.arange(20) % 2, systole, 1.0)
    assert said(warnings_of(table, tmp_path / "out", tube(radii)), "systole and diastole") == told


def test_a_lesion_between_two_healthy_ends_is_no_mixture_of_phases(table, tmp_path):
    radii = 1.5 - 0.6 * np.exp(-(((np.arange(20) - 9) / 3.0) ** 2))
    found = warnings_of(table, tmp_path / "out", tube(radii))
    assert not said(found, "systole") and not said(found, "z_from") and not said(found, "units")


@pytest.mark.parametrize(
    "radius, spacing, told",
    [(0.45, 0.5, True), (3.0, 0.5, True), (2.2, 0.5, True), (2.05, 0.5, False), (0.45, 1.1, False)],
)
def test_a_frame_that_is_much_wider_or_narrower_than_its_neighbours(table, tmp_path, radius, spacing, told):
    """The neighbours have a radius of 1.5 mm. In four real pull-backs, areas less than 1 mm apart differ by a factor of
    1.97 at most."""
    frames = tube([1.5] * 8 + [radius] + [1.5] * 8, spacing=spacing)
    found = [one for one in warnings_of(table, tmp_path / "out", frames) if "changes by more than a factor" in one]
    assert len(found) == told
    if told:
        assert "frames 73 to 83 (z 3.50 to 4.00 mm" in found[0] and "83 to 93" in found[0] and "drop_frames" in found[0]


def test_frames_in_the_guide_catheter(table, tmp_path):
    """The catheter is 1.8 mm wide, the vessel 3.4 mm. The message gives z as the table has it, from the proximal
    end."""
    frames = tube([0.9] * 6 + [1.7] * 20, spacing=0.5)
    (found,) = [
        one
        for one in warnings_of(table, tmp_path / "out", frames, reading={"z_from": "proximal"})
        if "guide catheter" in one
    ]
    assert "63 to 53 (z 3.00 to 2.50 mm" in found and "z_range_mm" in found


@pytest.mark.parametrize("left, told", [(30, True), (50, True), (52, False)])
@pytest.mark.parametrize("shift", [0, 9])
def test_an_outline_of_which_a_part_is_missing(table, tmp_path, left, told, shift):
    """The outline has 60 points, of which `left` are kept. Formerly half an outline was closed by a chord, and its area
    looked like a lesion. A missing part of 60 degrees has a chord as long as the radius."""
    frames = tube([1.5] * 8, spacing=0.5)
    frames[43] = (frames[43][0], np.roll(frames[43][1][:left], shift, axis=0))
    found = warnings_of(table, tmp_path / "out", frames)
    assert said(found, "in frame 43 (z 2.00 mm, lumen") == told


def test_a_point_of_an_outline_far_off(table, tmp_path):
    frames = tube([1.5] * 8, spacing=0.5)
    frames[43][1][10] += (2.5, 1.0)
    assert said(warnings_of(table, tmp_path / "out", frames), "a point far off")
    frames = tube([1.5] * 8, spacing=0.5, count=8)  # drawn by few points, so all steps are long
    assert not said(warnings_of(table, tmp_path / "few", frames), "a point far off")


def test_the_record_has_the_area_of_the_lumen_that_is_built(table, tmp_path):
    """The octagon through eight points encloses 10 % less than their circle. The surface follows the circle."""
    document = run.run({"lumen": table(tube([1.5] * 5, count=8))}, tmp_path / "out")
    assert document["frames"][2]["lumen_area_mm2"] == pytest.approx(np.pi * 1.5**2, rel=0.005)


def test_a_sheet_of_calcium_round_nearly_the_whole_vessel_is_one_deposit(table, tmp_path):
    ring = {23: (2.0, sector(1.6, 1.8, 0, 358))}
    files = {"lumen": table(tube([1.5] * 5)), "outer_wall": table(tube([1.9] * 5), "wall.csv")}
    document = run.run(files | {"calcium": table(ring, "calcium.csv")}, tmp_path / "out")
    assert document["frames"][2]["calcium_arc_deg"] == pytest.approx(359, abs=2)


@pytest.mark.parametrize("turned", [False, True])
def test_a_centreline_that_begins_at_its_distal_end(tmp_path, turned):
    import vtkmodules.all as vtk  # writes a line with radii, as VMTK does

    points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
    radii = vtk.vtkDoubleArray()
    radii.SetName("MaximumInscribedSphereRadius")
    s = np.linspace(0, 40, 81)
    cells.InsertNextCell(len(s))
    for one in s[::-1] if turned else s:
        cells.InsertCellPoint(points.InsertNextPoint(one, 0.02 * one**2, 0))
        radii.InsertNextValue(1.9 - 0.018 * one)
    poly = vtk.vtkPolyData()
    poly.SetPoints(points)
    poly.SetLines(cells)
    poly.GetPointData().AddArray(radii)
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(tmp_path / "line.vtp"))
    writer.SetInputData(poly)
    writer.Write()
    assert said(line.read(tmp_path / "line.vtp", "mm").warnings, "begin at the proximal end") == turned

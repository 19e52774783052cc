"""Plaque from the outlines of lumen and outer wall, which was traced in all frames or in some."""

import numpy as np
import pytest
from contour_tables import sector, tube

from anatomy.contours import loft, plaque, run
from common import vtp
from common.errors import InputError


def test_wall_beyond_the_healthy_one_is_plaque(table, tmp_path):
    """Concentric circles: the healthy end has 0.2 mm of wall, the lesion 0.7 mm, of which 0.5 are plaque."""
    files = {"lumen": table(tube([1.5, 1.5, 1.0, 1.5, 1.5])), "outer_wall": table(tube([1.7] * 5), "wall.csv")}
    document = run.run(files, tmp_path / "out")
    assert document["healthy_wall_mm"] == pytest.approx(0.2, abs=0.002)
    surface = vtp.read_triangles(tmp_path / "out" / "lumen.vtp", "")
    points = vtp.points(surface)
    thickness = np.array(surface.GetPointData().GetArray("plaque_thickness_mm"))
    kind = np.array(surface.GetPointData().GetArray("plaque_type"))
    rim = np.hypot(*points[:, :2].T)
    throat = (np.abs(points[:, 2] - 2) < 1e-6) & (rim > 0.9)
    assert thickness[throat] == pytest.approx(0.5, abs=0.005) and (kind[throat] == plaque.FIBROUS).all()
    assert thickness[(points[:, 2] < 1) & (rim > 1.4)] == pytest.approx(0, abs=0.005)
    assert document["frames"][2]["plaque_burden_percent"] == pytest.approx(100 * (1 - 1 / 1.7**2), abs=0.1)
    given = run.run(files, tmp_path / "given", healthy_wall_mm=0.1)
    assert given["healthy_wall_mm"] == 0.1


def test_a_pull_back_without_a_healthy_frame_takes_the_usual_wall(table, tmp_path):
    files = {"lumen": table(tube([1.0] * 3)), "outer_wall": table(tube([1.6] * 3), "wall.csv")}
    document = run.run(files, tmp_path / "out")
    assert document["healthy_wall_mm"] == plaque.THICKEST_HEALTHY_MM
    assert any("no healthy frame" in warning for warning in document["warnings"])


@pytest.mark.parametrize("wall, told", [(0.0, True), (0.09, True), (0.11, False)])
def test_a_wall_thinner_than_its_media_is_told(table, tmp_path, wall, told):
    """If the lumen's own table is given as the outer wall, a lesion has no plaque. The user must be warned."""
    radii = np.array([1.5, 1.5, 1.0, 1.5])
    files = {"lumen": table(tube(radii)), "outer_wall": table(tube(radii + wall), "wall.csv")}
    found = [one for one in run.run(files, tmp_path / "out")["warnings"] if "the media alone" in one]
    assert len(found) == told and all("in 4 frames" in one and "the table of the lumen" in one for one in found)


def test_outer_wall_that_is_missing_in_a_frame_is_interpolated(table, tmp_path):
    wall = tube([1.7, 1.7, 1.9, 1.7, 1.7])
    del wall[13]
    files = {"lumen": table(tube([1.5] * 5)), "outer_wall": table(wall, "wall.csv")}
    document = run.run(files, tmp_path / "out")
    assert any("no outer wall in frames 13" in warning for warning in document["warnings"])
    assert document["frames"][1]["wall_mean_mm"] is None


def plaque_along(folder):
    """(z (n,), plaque (n,)) in mm at the points of a written lumen that lie on its wall, not within its caps."""
    surface = vtp.read_triangles(folder / "lumen.vtp", "")
    _, triangles = vtp.points_and_triangles(surface)
    wall = np.unique(triangles[np.array(surface.GetCellData().GetArray("region_id")) == loft.WALL])
    return vtp.points(surface)[wall, 2], np.array(surface.GetPointData().GetArray("plaque_thickness_mm"))[wall]


@pytest.mark.parametrize("traced", [(3, 83), (3, 13, 83), (3, 13, 63, 83)])
def test_between_its_frames_the_wall_itself_is_interpolated(table, tmp_path, traced):
    """The wall was traced in healthy frames alone. When its thickness was interpolated instead, the throat got a
    healthy wall."""
    radii = [1.5, 1.5, 1.5, 1.2, 0.9, 1.2, 1.5, 1.5, 1.5]
    wall = {name: value for name, value in tube([1.7] * 9).items() if name in traced}
    files = {"lumen": table(tube(radii)), "outer_wall": table(wall, "wall.csv")}
    document = run.run(files, tmp_path / "out")
    z, thickness = plaque_along(tmp_path / "out")
    assert thickness[np.abs(z - 4) < 1e-6] == pytest.approx(0.6, abs=0.01)
    assert thickness[(z < 2) | (z > 6)] == pytest.approx(0, abs=0.01)
    assert any("it is interpolated between the frames beside them" in said for said in document["warnings"])


def test_beyond_its_frames_the_wall_is_not_known(table, tmp_path):
    """The wall was traced only in a lesion with 0.8 mm of plaque. Formerly this plaque continued through the healthy
    vessel."""
    wall = {name: value for name, value in tube([1.8] * 7).items() if name in (23, 33, 43)}
    calcium = {3: (0.0, sector(1.6, 1.7, 20, 110))}
    files = {"lumen": table(tube([1.5, 1.5, 1.2, 0.9, 1.2, 1.5, 1.5])), "outer_wall": table(wall, "wall.csv")}
    files["calcium"] = table(calcium, "calcium.csv")
    said = " ".join(run.run(files, tmp_path / "out", healthy_wall_mm=0.1)["warnings"])
    z, thickness = plaque_along(tmp_path / "out")
    assert np.isnan(thickness[(z < 1.49) | (z > 4.51)]).all() and np.isfinite(thickness[(z > 1.51) & (z < 4.49)]).all()
    assert thickness[np.abs(z - 3) < 1e-6] == pytest.approx(0.8, abs=0.01)
    for words in ("frames 3, 13, beyond", "not known at z 0.0 to 1.0", "not known at z 5.0 to 6.0", "of frames 3 are"):
        assert words in said


def test_a_lumen_outside_its_outer_wall_is_refused(table, tmp_path):
    files = {"lumen": table(tube([1.5] * 3)), "outer_wall": table(tube([1.7, 1.39, 1.7]), "wall.csv")}
    with pytest.raises(InputError, match="outside the outer wall"):
        run.run(files, tmp_path / "out")
    assert not (tmp_path / "out" / "lumen.vtp").exists()
    files["outer_wall"] = table(tube([1.7, 1.41, 1.7]), "wall.csv")  # crosses by 0.09 mm, as hand-drawn lines may
    run.run(files, tmp_path / "out")


@pytest.mark.parametrize("given, good", [("1", True), ("0", True), ("1.1", False), ("-0.1", False), ("thin", False)])
def test_a_healthy_wall_is_a_thickness(table, tmp_path, run_module, given, good):
    lumen, wall = table(tube([1.5] * 3)), table(tube([1.8] * 3), "wall.csv")
    done = run_module(
        "anatomy", "contours", lumen, "--outer-wall", wall, f"--healthy-wall={given}", "--out", tmp_path / "out"
    )
    assert done.returncode == (0 if good else 2), done.stderr
    assert good or ("0 to 1, or auto" in done.stderr and given in done.stderr)

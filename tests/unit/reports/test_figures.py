"""Figures: what is written, the same bytes twice, and the geometry of the pictures."""

import json
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from common.errors import InputError
from reports.__main__ import main
from reports.inputs.case_files import CaseFiles
from reports.figures import curves as curves_module
from reports.figures import study as study_module
from reports.figures.curves import FIGURE_SIZE, axis_end, legend_below
from reports.figures.lumen import project_triangles, panel_grid, view_axes
from reports.measuring.profiles import read_pullback, read_pullback_error
from reports.inputs.surface import Surface, read_device, read_lumen


@pytest.fixture
def measured_case(make_case):
    """A case with its metrics.json."""

    def make(name, **options):
        folder = make_case(name, **options)
        main(["metrics", "--case", name, "--case-dir", str(folder), "--out", str(folder / "metrics.json")])
        return folder

    return make


@pytest.mark.slow
def test_the_same_bytes_twice_and_no_dates(measured_case, tmp_path):
    folder = measured_case("tube")
    for out in ("a", "b"):
        arguments = ["--case-dir", str(folder), "--metrics", str(folder / "metrics.json")]
        main(["figures", *arguments, "--out-dir", str(tmp_path / out)])
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    stems = [
        "agreement",
        "differences",
        "ffr_before_after",
        "tube_area",
        "tube_curvature",
        "tube_lumen",
        "tube_pullback",
        "tube_stations",
    ]
    assert names == sorted(f"{stem}.{kind}" for stem in stems for kind in ("svg", "png"))
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    assert "<dc:date>" not in (tmp_path / "a" / "tube_area.svg").read_text()
    for name in ("agreement", "tube_area"):  # matplotlib makes ids of clip paths from memory addresses
        text = (tmp_path / "a" / f"{name}.svg").read_text()
        ids = re.findall(r'<clipPath id="([^"]+)"', text)
        assert ids == [f"{name}_clip{k}" for k in range(len(ids))] != []
        assert set(re.findall(r'clip-path="url\(#([^)]+)\)"', text)) <= set(ids)


def test_a_study_without_reference_has_no_agreement_plot(measured_case, tmp_path):
    folder = measured_case("own", states=("pre", "vci"))
    main(["figures", "--metrics", str(folder / "metrics.json"), "--out-dir", str(tmp_path / "figures")])
    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == [
        "ffr_before_after.png",
        "ffr_before_after.svg",
    ]


def test_the_pull_back_has_the_band_of_its_error(measured_case, tmp_path, monkeypatch):
    """A pull-back has a band if its error is known. Pull-backs of reduced models have no error."""
    folder = measured_case("tube")
    drawn = []
    monkeypatch.setattr(curves_module, "save_figure", lambda figure, *_: drawn.append(figure))
    path = folder / "flow" / "vci" / "pullback.csv"
    errors = [repr(0.002 + 1e-5 * k) for k in range(len(path.read_text().splitlines()) - 1)]
    write_pullback_errors(path, errors)
    metrics = json.loads((folder / "metrics.json").read_text())
    curves_module.pullback_figure(CaseFiles("tube", folder), metrics, tmp_path)
    (band,) = [one for one in drawn[0].axes[0].collections if isinstance(one, PolyCollection)]
    inside = band.get_paths()[0].vertices
    half = [np.ptp(inside[inside[:, 0] == s][:, 1]) / 2 for s in (inside[:, 0].min(), inside[:, 0].max())]
    assert half == pytest.approx([0.002, float(errors[-1])], rel=1e-6)
    plt.close(drawn[0])


def write_pullback_errors(path, errors):
    """Fills the last column of the pull-back with errors. `make_case` leaves it empty."""
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], *map("".join, zip(lines[1:], errors))]) + "\n")


@pytest.mark.parametrize(("error", "lower"), [(0.01, 0.75), (0.3, 0.5), (2.0, 0.0)])
def test_a_wide_band_lies_within_the_axes(measured_case, tmp_path, monkeypatch, error, lower):
    """A band that is cut off would look too narrow. The axis still ends at 0, because no FFR is below 0."""
    folder, drawn = measured_case("tube"), []
    monkeypatch.setattr(curves_module, "save_figure", lambda figure, *_: drawn.append(figure))
    path = folder / "flow" / "vci" / "pullback.csv"
    write_pullback_errors(path, [repr(error)] * (len(path.read_text().splitlines()) - 1))
    metrics = json.loads((folder / "metrics.json").read_text())
    curves_module.pullback_figure(CaseFiles("tube", folder), metrics, tmp_path)
    (axes,) = drawn[0].axes
    lowest = read_pullback(path, metrics["segment"]["branch"])[1].min() - error
    assert axes.get_ylim()[0] == lower <= max(0.0, lowest)
    plt.close(drawn[0])


@pytest.mark.parametrize(
    ("largest", "ends", "end"),
    [(7.0, (10, 25), 10), (10.0, (10, 25), 10), (10.1, (10, 25), 25), (25.1, (10, 25), 50), (0.31, (0.15, 0.35), 0.35)],
)
def test_an_axis_ends_at_a_fixed_value_and_widens_only_for_a_larger_one(largest, ends, end):
    assert axis_end(largest, ends) == end


def test_profiles_of_two_patients_have_the_same_axes(measured_case, tmp_path, monkeypatch):
    """The axes must agree although each figure is drawn from one case alone."""
    drawn = []
    monkeypatch.setattr(curves_module, "save_figure", lambda figure, *_: drawn.append(figure.axes[0].get_ylim()))
    metrics = json.loads((measured_case("tube") / "metrics.json").read_text())
    for share in (1.0, 0.8):
        for entry in metrics["states"].values():
            entry["area"]["profile_mm2"] = [share * value for value in entry["area"]["profile_mm2"]]
            entry["curvature"]["profile_per_mm"] = [share * value for value in entry["curvature"]["profile_per_mm"]]
        curves_module.area_figure(metrics, tmp_path)
        curves_module.curvature_figure(metrics, tmp_path)
    assert drawn[:2] == drawn[2:] and drawn[0] != drawn[1]
    metrics["states"]["vci"]["area"]["profile_mm2"][0] = 26.0
    curves_module.area_figure(metrics, tmp_path)
    assert drawn[-1][1] == pytest.approx(50.0 * (1.0 + curves_module.HEADROOM)), "nothing is cut off"
    plt.close("all")


def test_rows_of_the_agreement_share_the_axis_of_a_quantity(measured_case, tmp_path, monkeypatch):
    """The errors in a column can be compared. Published limits stand in the labels and do not widen the axis."""
    drawn = []
    monkeypatch.setattr(study_module, "save_figure", lambda figure, *_: drawn.append(figure))
    states = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
    folders = [measured_case(name, states=states, change=change) for name, change in (("a", 0.0), ("b", 0.02))]
    study_module.agreement_figure([json.loads((one / "metrics.json").read_text()) for one in folders], tmp_path)
    grid = np.reshape(drawn[0].axes, (4, 4))
    for column in grid.T:
        assert len({axes.get_ylim() for axes in column}) == 1 and len({axes.get_xlim() for axes in column}) == 1
        low, high = column[0].get_ylim()
        points = [y for axes in column for line in axes.lines if line.get_marker() != "None" for y in line.get_ydata()]
        assert len(points) == 14 and low < min(points) and high > max(points)
    low, high = grid[3, 1].get_ylim()
    assert high - low < 2.12 + 5.22, "narrower than the published limits of the mean area"
    labels = [axes.get_xlabel() for axes in grid.ravel()]
    assert "published: −1.55 (−5.22 to 2.12)" in labels[13] and sum("published" in label for label in labels) == 3
    plt.close(drawn[0])


@pytest.mark.parametrize("bad", ["nan", "-0.001", "inf", "wide"])
def test_an_error_of_the_pull_back_that_is_none_is_refused(measured_case, bad):
    folder = measured_case("tube")
    path, branch = folder / "flow" / "vci" / "pullback.csv", "main"
    count = len(path.read_text().splitlines()) - 1
    write_pullback_errors(path, ["", "0.0", "0.002", *[""] * (count - 4), bad])
    with pytest.raises(InputError, match="ffr_error_estimate") as refusal:
        read_pullback_error(path, branch)
    assert bad in str(refusal.value)
    path.write_text(path.read_text()[: -len(bad) - 1] + "0.5\n")
    found = read_pullback_error(path, branch)
    assert np.isnan(found[0]) and found[[1, 2, -1]].tolist() == [0.0, 0.002, 0.5]


@pytest.mark.parametrize("curves", [1, 2, 5])
def test_the_legend_lies_under_the_axis_label(curves):
    figure, axes = plt.subplots(figsize=FIGURE_SIZE)
    for k in range(curves):
        axes.plot([0, 1], [0, k], label=f"Reference (finite elements) {k}: mean 12.61 mm²")
    axes.set_xlabel("distance (mm)")
    legend_below(figure)
    figure.canvas.draw()
    legend, label = figure.legends[0].get_window_extent(), axes.xaxis.label.get_window_extent()
    assert legend.y1 <= label.y0 and legend.y0 >= 0
    assert axes.get_window_extent().height > 150
    plt.close(figure)


def test_view_looks_along_the_least_extent():
    rng = np.random.default_rng(1)
    points = rng.normal(size=(500, 3)) * [1.0, 9.0, 4.0]
    axes = view_axes(points)
    assert np.abs(axes @ np.eye(3)).round(0).tolist() == [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert view_axes(points[::-1]) == pytest.approx(axes)


def test_near_triangles_face_the_viewer():
    surface = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 1]]))
    assert project_triangles(surface, np.eye(3))["near"].tolist() == [True, False]


@pytest.mark.parametrize(
    "count, aspect, grid", [(4, 2.0, (2, 2)), (2, 5.0, (2, 1)), (2, 0.8, (1, 2)), (1, 1.0, (1, 1))]
)
def test_panels(count, aspect, grid):
    assert panel_grid(count, aspect)[:2] == grid


def test_lumen_is_thinned_and_keeps_its_volume(make_case):
    path = make_case() / "anatomy" / "lumen.vtp"
    volumes = []
    for most in (10**6, 1500):
        surface = read_lumen(path, most)
        assert len(surface.triangles) <= most
        corners = surface.points[surface.triangles]
        volumes.append(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0)
    assert volumes[0] > 0 and volumes[1] == pytest.approx(volumes[0], rel=0.01)


def test_struts_are_read_without_their_axes(make_case):
    folder = make_case()
    stent = read_device(folder / "vci" / "devices" / "stent1_struts.vtp")
    assert len(stent.triangles) > 1000 and stent.triangles.max() < len(stent.points)
    assert read_device(next(folder.rglob("centreline.vtp"))) is None  # lines without a surface


def test_nothing_to_draw_is_refused(tmp_path):
    with pytest.raises(SystemExit):
        main(["figures", "--out-dir", str(tmp_path)])


def test_not_a_vtp_is_refused(tmp_path):
    (tmp_path / "lumen.vtp").write_text("solid")
    with pytest.raises(InputError):
        read_lumen(tmp_path / "lumen.vtp", 10)

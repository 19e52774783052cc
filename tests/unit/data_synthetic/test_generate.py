import json
import pathlib

import numpy as np
import pytest
import yaml
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import InputError
from common.patient.plaque_types import CALCIFIED, FIBROUS, LIPID, NONE
from data_synthetic import __main__ as command
from common.implicit import field, surface
from data_synthetic import disease, generate, tree, truth
from tests.unit.data_synthetic import vessels

ROOT = pathlib.Path(__file__).resolve().parents[3]
CASE = ROOT / "config/cases/quick_branch.yaml"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("source")
    generate.run(CASE, out)
    return out


def test_same_case_same_bits(made, tmp_path):
    generate.run(CASE, tmp_path)
    for name in ("lumen.vtp", "truth.json"):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()


def test_plaque_lies_in_the_lesion_only(made):
    poly = vtp.read(made / "lumen.vtp", "")
    data = poly.GetPointData()
    thickness, kind = (vtk_to_numpy(data.GetArray(n)) for n in ("plaque_thickness_mm", "plaque_type"))
    points = vtp.points(poly)
    branches, _ = truth.load(made / "truth.json")
    main, lesion = branches[0], branches[0].lesions[0]
    s = main.axis.nearest(points)
    start, end = disease.lesion_extent(lesion)
    assert thickness.max() > 1 and np.all(thickness[(s < start - 0.2) | (s > end + 0.2)] == 0)
    assert set(np.unique(kind)) == {NONE, FIBROUS, CALCIFIED}
    assert np.array_equal(kind > 0, thickness > 0)


def test_a_side_branch_in_a_lesion_runs_through_plaque():
    """Inside the parent's healthy wall, the plaque behind the side branch's wall reaches as far as the healthy wall."""
    changes = {
        "centre_s_mm": 15,
        "length_mm": 10,
        "diameter_stenosis_percent": 70,
        "eccentricity": 0,
        "plaque": "lipid",
    }
    side_branch = {"s_mm": 15, "diameter_mm": 1.6, "length_mm": 7.5, "azimuth_deg": 40, "angle_deg": 80}
    main, side = tree.grow(vessels.vessel(side_branches=[side_branch], lesions=[changes]), "")
    s = np.linspace(0.3, 4, 60)
    _, normal, binormal = side.axis.frame(s)
    turn = np.linspace(0, 8 * np.pi, 60)[:, None]
    lumen = field.LumenField([main, side])
    radius = lumen.axis_radius(1, s)[:, None]
    points = side.axis.point(s) + radius * (np.cos(turn) * normal + np.sin(turn) * binormal)
    thickness, kind = generate.plaque_at(lumen, points)
    at = main.axis.nearest(points)
    off_axis = np.linalg.norm(points - main.axis.point(at), axis=1)
    depth = main.healthy_radius(at) - off_axis
    inside, beyond = (depth > 0.05) & (off_axis > main.radius(at)), depth < -0.05
    assert inside.sum() > 5 and beyond.sum() > 20
    assert thickness[inside] == pytest.approx(depth[inside], abs=1e-6) and set(kind[inside]) == {LIPID}
    assert not thickness[beyond].any()


def test_truth_states_what_was_asked(made):
    document = json.loads((made / "truth.json").read_text())
    asked = yaml.safe_load(CASE.read_text())["vessel"]["lesions"][0]
    lesion = document["branches"][0]["lesions"][0]
    assert lesion["true_diameter_stenosis_percent"] == pytest.approx(asked["diameter_stenosis_percent"], abs=0.1)
    assert document["surface"]["wall_error_rms_mm"] < 0.001
    assert [b["name"] for b in document["branches"]] == ["main", "side1", "side2"]
    m, forks = document["murray_exponent"], document["bifurcations"]
    assert len(forks) == 2
    for fork in forks:
        assert fork["before_mm"] ** m == pytest.approx(fork["after_mm"] ** m + fork["side_mm"] ** m, rel=1e-9)


def test_truth_read_back_gives_the_same_radii(made):
    branches, wall = truth.load(made / "truth.json")
    document = json.loads((made / "truth.json").read_text())
    assert wall == 0.7
    for branch, entry in zip(branches, document["branches"]):
        assert np.abs(branch.radius(np.array(entry["s_mm"])) - entry["radius_mm"]).max() < 1e-5


def test_truth_of_another_kind_is_refused(tmp_path):
    (tmp_path / "truth.json").write_text('{"schema": "other"}')
    with pytest.raises(InputError, match="not a truth file"):
        truth.load(tmp_path / "truth.json")
    none = '{"schema": "vci-truth-1"}'
    for text, message in (("[]", "not a group of keys"), ("{", "not a JSON"), (none, "truth file: key is missing")):
        (tmp_path / "truth.json").write_text(text)
        with pytest.raises(InputError, match=message):
            truth.load(tmp_path / "truth.json")
    with pytest.raises(InputError, match="no such file"):
        truth.load(tmp_path / "none.json")


@pytest.mark.parametrize(
    "change, key",
    [
        (lambda d: d.update(wall_thickness_mm=-0.7), "wall_thickness_mm"),
        (lambda d: d.update(wall_thickness_mm="0.7"), "wall_thickness_mm"),
        (lambda d: d.update(branches=[]), "branches"),
        (lambda d: d["branches"][1].pop("shift_mm"), "branches[2]: key shift_mm is missing"),
        (lambda d: d["branches"][0].update(radius_mm=d["branches"][0]["radius_mm"][:50]), "branches[1].radius_mm"),
        (lambda d: d["branches"][0]["radius_mm"].__setitem__(3, -0.5), "branches[1].radius_mm[4]"),
        (lambda d: d["branches"][0]["radius_mm"].__setitem__(3, float("nan")), "branches[1].radius_mm[4]"),
        (lambda d: d["branches"][0]["points_mm"].__setitem__(3, [0, "x", 0]), "branches[1].points_mm[4][2]"),
        (lambda d: d["branches"][0]["points_mm"].__setitem__(3, [0, 0]), "branches[1].points_mm[4]"),
        (lambda d: d["branches"][0]["s_mm"].reverse(), "branches[1].s_mm"),
    ],
)
def test_a_truth_that_cannot_be_of_a_vessel_is_refused_by_its_key(made, tmp_path, change, key):
    document = json.loads((made / "truth.json").read_text())
    change(document)
    (tmp_path / "truth.json").write_text(json.dumps(document))
    with pytest.raises(InputError) as caught:
        truth.load(tmp_path / "truth.json")
    assert caught.value.where == f"{tmp_path / 'truth.json'}, key {key}"


def test_a_bad_case_ends_with_code_2_and_writes_nothing(tmp_path, capsys):
    bad = tmp_path / "bad.yaml"
    bad.write_text(CASE.read_text().replace("centre_s_mm: 19.5", "centre_s_mm: 38"))
    with pytest.raises(SystemExit) as caught:
        command.main(["generate", str(bad), "--out", str(tmp_path / "out")])
    assert caught.value.code == 2
    assert "vessel.lesions[1].centre_s_mm" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("eccentricity", [0.0, 0.6])
def test_plaque_volume_is_that_of_the_asked_lesion_and_of_the_surface(vessel, eccentricity):
    """Cosine dip of depth D over the length L of a straight tube R: pi R^2 L (D - 3/8 D^2), wherever the lumen lies."""
    lesion = {"centre_s_mm": 11, "length_mm": 8, "diameter_stenosis_percent": 60, "eccentricity": eccentricity}
    straight = {"length_mm": 22, "ostial_diameter_mm": 3.4, "taper_percent_per_cm": 0, "mean_curvature_per_mm": 0}

    def grown(lesions):
        data = vessel(side_branches=[], lesions=lesions, main=straight | {"max_curvature_per_mm": 0.2})
        return data, tree.grow(data)

    data, branches = grown([lesion])
    exact = np.pi * 1.7**2 * 8 * (0.6 - 0.375 * 0.36)
    stated = truth.document(data, branches, 0, 0, 0)["branches"][0]["lesions"][0]["true_plaque_volume_mm3"]
    # The axis of an eccentric lumen is longer than the vessel's. The truth adds up areas across it along its length.
    assert stated == pytest.approx(exact, rel=0.005 if eccentricity == 0 else 0.04)

    def volume(found):
        points, triangles, _ = surface.build(field.LumenField(found), 0.25)
        a, b, c = points[triangles].transpose(1, 0, 2)
        return np.sum(a * np.cross(b, c)) / 6

    assert volume(grown([])[1]) - volume(branches) == pytest.approx(exact, rel=0.02 if eccentricity == 0 else 0.05)


def test_a_throat_between_the_grid_points_is_refused(vessel):
    def grown(stenosis):
        lesion = {"branch": "side1", "centre_s_mm": 4.5, "length_mm": 4, "diameter_stenosis_percent": stenosis}
        return field.LumenField(tree.grow(vessel(lesions=[lesion])))

    generate.check_narrowest_radius(grown(75), 0.2, "case")
    with pytest.raises(InputError, match="side1") as caught:
        generate.check_narrowest_radius(grown(80), 0.2, "case")
    assert caught.value.where == "case.lesions"

import json

import numpy as np
import pytest

from anatomy import __main__ as anatomy
from anatomy.ct import paths, segment
from common import volume as image
from common import vtp
from common.errors import ComputationError, InputError
from common.implicit import surface
from data_synthetic import __main__ as command
from data_synthetic.ct import evaluate, phantom, scan, struts, study, vessel

ENDS = {"inlet": 0.0, "outlet1": 14.0}


def throat_radius(smallest_mm, width_mm=5.0):
    """radius_of_z of a tube of radius 1.4 mm that narrows to smallest_mm in the middle."""

    def radius(z):
        x = np.clip(np.abs(z - 7) / width_mm, 0, 1)
        return 1.4 - (1.4 - smallest_mm) * 0.5 * (1 + np.cos(np.pi * x))

    return radius


def scanned_tube(ct_tubes, radius, **changes):
    """(noisy Image, ends, true surface, settings) of a tube; plaque fills the wall of the throat."""
    poly, direction = ct_tubes.tube(radius)
    points, _ = vtp.points_and_triangles(poly)
    thickness = 1.4 - radius(points @ direction)
    for name, values in (("plaque_thickness_mm", thickness), ("plaque_type", (thickness > 0.01).astype(np.int32))):
        vtp.add_array(poly.GetPointData(), name, values)
    settings = ct_tubes.settings(**changes)
    volume = phantom.render(vessel.from_surface(poly, "tube"), settings["phantom"])
    volume = phantom.add_noise(volume, settings["phantom"])
    return volume, [(name, z * direction) for name, z in ENDS.items()], poly, direction, settings["segmentation"]


def tube_sections(direction):
    """Sections every half millimetre, clear of the ends."""
    return [("main", s, s * direction, direction) for s in np.arange(2.5, 11.6, 0.5)]


@pytest.fixture(scope="module")
def open_throat(ct_tubes):
    return scanned_tube(ct_tubes, throat_radius(0.7))


@pytest.mark.parametrize("method, limit", [("psf_edge", 0.3), ("half_maximum", 0.9), ("threshold", 1.1)])
def test_area_and_resistance_of_a_throat(open_throat, method, limit):
    volume, ends, poly, direction, settings = open_throat
    found = segment.segment(volume, ends, dict(settings, method=method))
    points, triangles, _ = surface.build(found["field"], 0.2)
    result = evaluate.compare_areas(vtp.points_and_triangles(poly), (points, triangles), tube_sections(direction))
    assert result["lost_sections"] == 0
    assert max(-result["lower_limit_mm2"], result["upper_limit_mm2"]) < limit
    if method == "psf_edge":
        assert result["resistance_ratio"] == pytest.approx(1, abs=0.12)
        assert [w["code"] for w in found["warnings"]] == []
        assert found["sigma_mm"] == pytest.approx(0.314, rel=0.06)


def test_the_axis_comes_from_the_image(open_throat):
    volume, ends, _, direction, settings = open_throat
    found = segment.segment(volume, ends, settings)
    points = found["tubes"][0].axis.points_mm
    away = np.linalg.norm(points - (points @ direction)[:, None] * direction, axis=1)
    assert away.max() < 0.12
    assert found["tubes"][0].axis.length_mm == pytest.approx(14, abs=0.3)


def test_an_occluded_throat_is_warned_of_at_its_place(ct_tubes):
    volume, ends, _, _, settings = scanned_tube(ct_tubes, throat_radius(0.28))
    found = segment.segment(volume, ends, settings)
    occluded = [w for w in found["warnings"] if w["code"] == "occluded_by_voxels"]
    assert len(occluded) == 1 and occluded[0]["value"] < 0.6
    assert 5.5 < occluded[0]["s_start_mm"] < 7 < occluded[0]["s_end_mm"] < 8.5
    # The throat keeps some contrast. No warning is given if the limit is below it.
    quiet = segment.segment(volume, ends, dict(settings, occluded_below=0.3))
    assert "occluded_by_voxels" not in [w["code"] for w in quiet["warnings"]]


def test_an_interrupted_vessel_is_an_error(ct_tubes):
    volume, ends, _, direction, settings = scanned_tube(ct_tubes, throat_radius(0.7), noise_hu=0)
    centres = np.stack(np.meshgrid(*[volume.centres(k) for k in range(3)], indexing="ij"), axis=-1)
    volume.values[np.abs(centres @ direction - 7) < 1.0] = -80
    with pytest.raises(ComputationError, match="no way through"):
        segment.segment(volume, ends, settings)


def test_end_points_given_the_other_way_round_are_warned_of(ct_tubes):
    """A tapering vessel read from its far end widens, so the swap is noticed."""
    volume, ends, _, _, settings = scanned_tube(ct_tubes, lambda z: 1.7 - 0.04 * z)
    swapped = [(name, place) for (name, _), (_, place) in zip(ends, reversed(ends))]
    codes = [[w["code"] for w in segment.segment(volume, given, settings)["warnings"]] for given in (ends, swapped)]
    assert codes == [[], ["widens_from_the_inlet"]]


def test_end_points_beside_the_vessel_are_refused(open_throat):
    volume, ends, _, _, settings = open_throat
    with pytest.raises(InputError, match="not in a contrast-filled"):
        segment.segment(volume, [ends[0], ("outlet1", ends[1][1] + [3.0, 0, 0])], settings)


def test_a_stent_blooms_and_psf_edge_takes_it_off(ct_tubes):
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 1.6))
    places_mm, lengths = struts.struts_on_wall(poly, np.linspace(0, 14, 141)[:, None] * direction, 3, 11, 8, 2, 0.08)
    settings = ct_tubes.settings()
    found = vessel.from_surface(poly, "tube")
    volume = phantom.add_noise(
        phantom.render(found, settings["phantom"], (places_mm, lengths * 0.0064)), settings["phantom"]
    )
    ends = [(name, z * direction) for name, z in ENDS.items()]
    inside = [("main", s, s * direction, direction) for s in np.arange(4.5, 9.6, 0.5)]
    ends_of_stent = np.concatenate([np.arange(a - 1.5, a + 1.6, 0.25) for a in (3, 11)])
    bias, at_ends = {}, {}
    for method in ("psf_edge", "half_maximum"):
        result = segment.segment(volume, ends, dict(settings["segmentation"], method=method), stented=True)
        points, triangles, _ = surface.build(result["field"], 0.2)
        bias[method] = evaluate.compare_areas(vtp.points_and_triangles(poly), (points, triangles), inside)[
            "mean_difference_mm2"
        ]
        area = [evaluate.section_area(points, triangles, s * direction, direction) for s in ends_of_stent]
        at_ends[method] = np.array(area) - np.pi * 1.6**2
        said = [w["message"] for w in result["warnings"] if w["code"] == "calcium_or_metal"]
        assert any(("its bloom is taken off" if method == "psf_edge" else "area is too large") in text for text in said)
    unsaid = segment.segment(volume, ends, settings["segmentation"])["warnings"]
    assert any("if it is a stent, the area is far too small: say so" in w["message"] for w in unsaid)
    assert bias["half_maximum"] > 2 and abs(bias["psf_edge"]) < 0.6
    # The blur spreads the metal beyond the stent's ends. psf_edge must not count it as lumen there either.
    assert at_ends["half_maximum"].max() > 1 and np.abs(at_ends["psf_edge"]).max() < 0.5


def test_a_vessel_called_stented_that_shows_none_is_warned_of(open_throat):
    volume, ends, _, _, settings = open_throat
    found = segment.segment(volume, ends, settings, stented=True)
    assert [w["code"] for w in found["warnings"]] == ["no_stent_seen"]


def test_noise_is_warned_of_and_then_refused_and_smoothing_is_the_remedy(ct_tubes):
    volume, ends, _, _, settings = scanned_tube(ct_tubes, throat_radius(0.9), noise_hu=55)
    assert [w["code"] for w in segment.segment(volume, ends, settings)["warnings"]] == ["noise"]
    volume, ends, _, _, settings = scanned_tube(ct_tubes, throat_radius(0.9), noise_hu=110)
    with pytest.raises(ComputationError, match="(?s)contrast is too low against the noise.*smoothing_fwhm_mm: 0.7"):
        segment.segment(volume, ends, settings)
    found = segment.segment(volume, ends, dict(settings, smoothing_fwhm_mm=0.7))
    assert [w["code"] for w in found["warnings"] if w["code"] == "noise"] == []
    radius = found["tubes"][0].radius(found["tubes"][0].s_mm)
    assert radius.min() == pytest.approx(0.9, abs=0.1) and radius.max() == pytest.approx(1.4, abs=0.1)
    assert found["sigma_mm"] > 0.38  # the blur of image and smoothing together


def test_faint_blood_is_warned_of(ct_tubes):
    settings = ct_tubes.settings()["phantom"]["hu"] | {"blood": 200.0}
    volume, ends, _, _, segmentation = scanned_tube(ct_tubes, throat_radius(0.9), hu=settings, noise_hu=10)
    assert "faint_blood" in [w["code"] for w in segment.segment(volume, ends, segmentation)["warnings"]]


def test_struts_touch_the_wall_and_have_their_length(ct_tubes):
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 1.6), around=96)
    axis = np.linspace(0, 14, 141)[:, None] * direction
    points, lengths = struts.struts_on_wall(poly, axis, 3, 11, 6, 2, 0.08)
    height = points @ direction
    radius = np.linalg.norm(points - height[:, None] * direction, axis=1)
    assert np.allclose(radius, 1.56, atol=0.01)
    assert height.min() == pytest.approx(3, abs=0.1) and height.max() == pytest.approx(11, abs=0.1)
    theta = np.linspace(0, 2 * np.pi, 20001)
    speed = np.sqrt(1.56**2 + (6 * struts.WAVE_AMPLITUDE_MM * np.cos(6 * theta)) ** 2)
    ring = np.sum(0.5 * (speed[1:] + speed[:-1])) * (theta[1] - theta[0])
    rings = int(round((8 - 2 * struts.WAVE_AMPLITUDE_MM) / struts.RING_PITCH_MM)) + 1
    links = 2 * (8 - 2 * struts.WAVE_AMPLITUDE_MM)  # two in each gap, from the first ring's plane to the last's
    assert lengths.sum() == pytest.approx(rings * ring + links, rel=0.01)


def test_commands_from_a_lumen_to_a_lumen_and_the_same_bits(ct_tubes, tmp_path, capsys):
    poly, direction = ct_tubes.tube(throat_radius(0.9))
    vtp.write(tmp_path / "lumen.vtp", poly)
    ends = [{"name": name, "centre_mm": (z * direction).tolist()} for name, z in ENDS.items()]
    (tmp_path / "ends.json").write_text(json.dumps({"ends": ends}))
    for turn in ("a", "b"):
        out = tmp_path / turn
        command.main(["phantom", str(tmp_path / "lumen.vtp"), "--out", str(out)])
        anatomy.main(["ct", str(out / "ct.nii.gz"), "--ends", str(tmp_path / "ends.json"), "--out", str(out)])
    for name in ("ct.nii.gz", "ct.json", "lumen.vtp", "segmentation.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    document = json.loads((tmp_path / "a" / "segmentation.json").read_text())
    assert document["blood_hu"] == pytest.approx(400, abs=6) and document["warnings"] == []
    triangles = vtp.triangles(vtp.read(tmp_path / "a" / "lumen.vtp", ""))
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    assert np.all(np.unique(edges, axis=0, return_counts=True)[1] == 2)


def test_bad_end_points_are_refused_with_their_key(tmp_path, capsys):
    volume = image.Image(np.zeros((4, 4, 4), np.float32), np.zeros(3), np.ones(3))
    image.write(volume, tmp_path / "ct.nii", "nothing")
    (tmp_path / "one.json").write_text('{"ends": [{"name": "inlet", "centre_mm": [0, 0, 0]}]}')
    first = '{"ends": [{"name": "inlet", "centre_mm": [0, 0, 0]}, '
    wrong = {
        "flat.json": ('{"centre_mm": [0, 1]}]}', "ends[2].centre_mm"),
        "text.json": ('{"centre_mm": "abc"}]}', "ends[2].centre_mm"),
        "nan.json": ('{"centre_mm": [0, NaN, 1]}]}', "ends[2].centre_mm"),
        "same.json": ('{"centre_mm": [0, 0.2, 0]}]}', "two end points at one place"),
        "twice.json": ('{"name": "inlet", "centre_mm": [0, 3, 0]}]}', "ends[2].name"),
        "cut.json": ("", "not a JSON file"),
        "odd.json": ("3]}", "ends"),
    }
    for name, (rest, _) in wrong.items():
        (tmp_path / name).write_text(first + rest)
    (tmp_path / "list.json").write_text("[1, 2]")
    cases = [(name, key) for name, (_, key) in wrong.items()] + [("one.json", "ends"), ("list.json", "ends")]
    for name, key in cases:
        with pytest.raises(SystemExit) as caught:
            arguments = ["ct", tmp_path / "ct.nii", "--ends", tmp_path / name, "--out", tmp_path / "out"]
            anatomy.main([str(a) for a in arguments])
        assert caught.value.code == 2 and key in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


def test_a_scene_needs_the_centreline_and_a_known_branch(ct_tubes, tmp_path):
    poly, direction = ct_tubes.tube(throat_radius(0.9))
    vtp.write(tmp_path / "lumen.vtp", poly)
    device = {"kind": "stent", "length_mm": 8.0, "crowns": 6, "links": 2, "strut_thickness_mm": 0.08}
    use = {"device": "des", "branch": "side9", "centre_s_mm": 7.0}
    scene = {"devices": {"des": device}, "procedure": [{"devices": [use]}]}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    with pytest.raises(InputError, match="centreline"):
        scan.run(tmp_path / "lumen.vtp", tmp_path / "out", scene_path=tmp_path / "scene.json")
    with pytest.raises(InputError, match=r"procedure\[1\].devices\[1\].branch"):
        struts.struts_of_scene(scene, poly, {"main": np.zeros((2, 3))}, "scene.json")


def test_a_stent_has_the_metal_of_its_own_struts(ct_tubes):
    poly, direction = ct_tubes.tube(throat_radius(0.9))
    device = {"kind": "stent", "length_mm": 8.0, "crowns": 6, "links": 2}
    use = {"device": "des", "branch": "main", "centre_s_mm": 7.0}
    line, metal = {"main": np.linspace(0, 14, 80)[:, None] * direction}, {}
    for thickness in (0.06, 0.08):
        scene = {"devices": {"des": device | {"strut_thickness_mm": thickness}}, "procedure": [{"devices": [use]}]}
        metal[thickness] = struts.struts_of_scene(scene, poly, line, "scene.json")[1].sum()
    # thinner struts lie a hundredth of a millimetre further out, on a ring that is 1 % longer
    assert metal[0.06] / metal[0.08] == pytest.approx((0.06 / 0.08) ** 2, rel=0.02)


@pytest.mark.parametrize(
    "change, key",
    [
        (lambda s: s["procedure"][0]["devices"][0].update(device="bms"), "procedure[1].devices[1].device"),
        (lambda s: s["devices"]["des"].pop("crowns"), "devices.des.crowns"),
        (lambda s: s["procedure"][0]["devices"][0].update(centre_s_mm=30.0), "procedure[1].devices[1].centre_s_mm"),
    ],
)
def test_a_stent_that_cannot_be_laid_is_refused_by_its_key(ct_tubes, change, key):
    poly, _ = ct_tubes.tube(throat_radius(0.9))
    device = {"kind": "stent", "length_mm": 8.0, "crowns": 6, "links": 2, "strut_thickness_mm": 0.08}
    use = {"device": "des", "branch": "main", "centre_s_mm": 7.0}
    scene = {"devices": {"des": device}, "procedure": [{"devices": [use]}]}
    change(scene)
    with pytest.raises(InputError) as caught:
        struts.struts_of_scene(scene, poly, {"main": np.linspace([0, 0, 0], [0, 0, 14], 80)}, "scene.json")
    assert caught.value.where == f"scene.json: {key}"


@pytest.mark.parametrize("text", ["{", "[]", '{"procedure": [], "devices": {}}'])
def test_a_file_that_is_no_scene_is_refused_before_rendering(ct_tubes, tmp_path, text):
    vtp.write(tmp_path / "lumen.vtp", ct_tubes.tube(throat_radius(0.9))[0])
    (tmp_path / "scene.json").write_text(text)
    with pytest.raises(InputError, match="scene.json"):
        scan.run(tmp_path / "lumen.vtp", tmp_path, scene_path=tmp_path / "scene.json", centreline_path=tmp_path / "c")


def test_smoothing_goes_through_both_ends():
    z = np.linspace(0, 12, 35)
    rough = np.stack([0.1 * np.sin(9 * z), 0.1 * np.cos(11 * z), z], axis=1)
    curve = paths.smooth_curve(rough)
    assert np.linalg.norm(curve.points_mm[[0, -1]] - rough[[0, -1]], axis=1).max() < 0.06
    assert curve.curvature(curve.s_mm).max() < 0.5


def test_study_refuses_voxels_out_of_range(tmp_path):
    with pytest.raises(InputError, match="--voxels"):
        study.run([], [0.05], 1, tmp_path / "table.csv")
    with pytest.raises(InputError, match="--seeds"):
        study.run([], [0.35], 0, tmp_path / "table.csv")

import copy
import dataclasses
import json

import numpy as np
import pytest

from common.errors import InputError
from data_synthetic.reference import run
from data_synthetic.reference.treatment import devices

BALLOON = {
    "kind": "balloon",
    "length_mm": 12.0,
    "shoulder_mm": 2.0,
    "chart": {"pressure_bar": [2, 8, 14], "diameter_mm": [2.8, 3.0, 3.12]},
}
STENT = {
    "kind": "stent",
    "balloon": "b",
    "length_mm": 15.0,
    "recoil_percent": 4.0,
    "radial_strength_mpa": 0.2,
    "bending_stiffness_n_mm2": 20,
    "nominal_diameter_mm": 3.0,
    "crimped_diameter_mm": 1.0,
}
SCENE = {
    "devices": {"b": BALLOON, "s": STENT},
    "procedure": [
        {
            "name": "stent",
            "action": "stent",
            "devices": [{"device": "s", "branch": "main", "centre_s_mm": 20.0, "pressure_bar": 11}],
        }
    ],
}


def test_radius_and_stiffness_follow_the_chart():
    found = devices.inflated_balloon(BALLOON, "b", 20.0, 11, "scene")
    assert found.radius_mm == pytest.approx(1.53)
    assert found.cap_mpa == pytest.approx(1.1)
    # The diameter grows by 0.12 mm over 6 bar: 0.01 mm of radius for 1 bar, which is 0.1 MPa.
    assert found.stiffness_mpa_per_mm == pytest.approx(10.0)


def test_shoulders_taper_linearly():
    found = devices.inflated_balloon(BALLOON, "b", 20.0, 8, "scene")
    assert found.radius_at(np.array([14.0, 20.0, 26.0, 27.0, 28.0, 40.0])) == pytest.approx([1.5, 1.5, 1.5, 0.75, 0, 0])


@pytest.mark.parametrize("pressure", [1, 15])
def test_pressure_off_the_chart_is_refused(pressure):
    with pytest.raises(InputError, match="pressure off the balloon's chart"):
        devices.inflated_balloon(BALLOON, "b", 20.0, pressure, "scene")


def test_a_stent_step_has_its_balloon_and_hold():
    branch, (step,) = devices.procedure_steps(SCENE, "scene.json")
    assert branch == "main" and step.balloon.name == "b" and step.stent.recoil_share == pytest.approx(0.96)
    assert step.stent.covers(12.5) and step.stent.covers(27.5) and not step.stent.covers(27.6)


def test_a_stent_resists_its_opening():
    _, (step,) = devices.procedure_steps(SCENE, "scene.json")
    stent = step.stent
    assert stent.opening_pressure_mpa(1.5) == pytest.approx(0.2)  # the radial strength at the nominal radius
    assert stent.opening_pressure_mpa(0.5) == pytest.approx(0.44 * 0.2 * 3)
    assert stent.opening_pressure_mpa(0.4) == stent.opening_pressure_mpa(0.5)
    assert step.cap_mpa(1.5, None) == pytest.approx(1.1) and step.cap_mpa(1.5, stent) == pytest.approx(0.9)
    low = dataclasses.replace(step, balloon=dataclasses.replace(step.balloon, cap_mpa=0.25))
    assert low.cap_mpa(0.5, stent) == pytest.approx(0.05), "a pressure that cannot open the stent"


def test_only_a_later_balloon_is_narrower_in_a_stent():
    """The chart of a delivery balloon already includes its stent."""
    _, (step,) = devices.procedure_steps(SCENE, "scene.json")
    later = dataclasses.replace(step, stent=None)
    assert step.free_radius(1.5, step.stent) == later.free_radius(1.5, None) == 1.5
    assert later.free_radius(1.5, step.stent) == pytest.approx(1.5 - 0.2 / 10.0)


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda s: s["devices"]["s"].update(crimped_diameter_mm=3.0), "no wider than crimped"),
        (lambda s: s["procedure"][0]["devices"].append(s["procedure"][0]["devices"][0]), "one device at a time"),
        (lambda s: s["procedure"][0]["devices"][0].update(device="x"), "no such device"),
        (lambda s: s["devices"]["s"].pop("recoil_percent"), "missing key"),
        (
            lambda s: s["procedure"].append(
                {
                    "name": "side",
                    "action": "side_branch_opening",
                    "devices": [{"device": "b", "branch": "side1", "centre_s_mm": 8.0, "pressure_bar": 8}],
                }
            ),
            "one branch",
        ),
    ],
)
def test_what_slices_cannot_answer_is_refused(change, message):
    scene = copy.deepcopy(SCENE)
    change(scene)
    with pytest.raises(InputError, match=message):
        devices.procedure_steps(scene, "scene.json")


@pytest.mark.parametrize(
    "change, key",
    [
        (lambda s: s.pop("procedure"), "procedure"),
        (lambda s: s.update(procedure=[]), "procedure"),
        (lambda s: s.update(schema="vci-truth-1"), "schema"),
        (lambda s: s["devices"]["s"].pop("kind"), "devices.s"),
        (lambda s: s["devices"]["s"].update(recoil_percent=200), "devices.s.recoil_percent"),
        (lambda s: s["devices"]["b"].update(shoulder_mm=0), "devices.b.shoulder_mm"),
        (lambda s: s["procedure"][0].update(devices=[]), "procedure[1].devices"),
        (lambda s: s["procedure"][0]["devices"][0].pop("centre_s_mm"), "procedure[1].devices[1]"),
        (lambda s: s["procedure"][0]["devices"][0].update(centre_s_mm=float("nan")), "centre_s_mm"),
        (lambda s: s["procedure"][0]["devices"][0].update(pressure_bar="10"), "pressure_bar"),
    ],
)
def test_a_scene_that_is_none_is_refused_by_its_key(tmp_path, change, key):
    scene = copy.deepcopy(SCENE) | {"schema": "vci-scene-1"}
    (tmp_path / "good.json").write_text(json.dumps(scene))
    assert run.load_scene(tmp_path / "good.json") == scene
    change(scene)
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    with pytest.raises(InputError) as caught:
        run.load_scene(tmp_path / "scene.json")
    assert key in str(caught.value)


@pytest.mark.parametrize("text", ["{", "[1, 2]", ""])
def test_a_file_that_is_no_scene_is_refused(tmp_path, text):
    (tmp_path / "scene.json").write_text(text)
    with pytest.raises(InputError):
        run.load_scene(tmp_path / "scene.json")


@pytest.mark.parametrize("diameters", [[3.2], [3.0, 3.0, 3.0], [3.2, 3.0, 2.8]])
def test_a_chart_that_does_not_rise_is_refused(diameters):
    chart = dict(BALLOON["chart"], diameter_mm=diameters)
    with pytest.raises(InputError, match="chart"):
        devices.inflated_balloon(dict(BALLOON, chart=chart), "b", 20.0, 11, "scene")


def test_a_stent_without_its_balloon_is_refused():
    scene = copy.deepcopy(SCENE)
    scene["devices"]["s"]["balloon"] = "none"
    with pytest.raises(InputError, match="no such balloon"):
        devices.procedure_steps(scene, "scene.json")

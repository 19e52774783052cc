import copy

import numpy as np
import pytest

from common.errors import InputError
from data_synthetic.reference import devices

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
    found = devices.balloon(BALLOON, "b", 20.0, 11, "scene")
    assert found.radius_mm == pytest.approx(1.53)
    assert found.cap_mpa == pytest.approx(1.1)
    # 0.12 mm of diameter in 6 bar: 0.1 MPa a bar over 0.01 mm of radius a bar.
    assert found.stiffness_mpa_per_mm == pytest.approx(10.0)


def test_shoulders_taper_linearly():
    found = devices.balloon(BALLOON, "b", 20.0, 8, "scene")
    assert found.radius_at(np.array([14.0, 20.0, 26.0, 27.0, 28.0, 40.0])) == pytest.approx([1.5, 1.5, 1.5, 0.75, 0, 0])


@pytest.mark.parametrize("pressure", [1, 15])
def test_pressure_off_the_chart_is_refused(pressure):
    with pytest.raises(InputError, match="pressure off the balloon's chart"):
        devices.balloon(BALLOON, "b", 20.0, pressure, "scene")


def test_a_stent_step_has_its_balloon_and_hold():
    branch, (step,) = devices.steps(SCENE, "scene.json")
    assert branch == "main" and step.balloon.name == "b" and step.stent.recoil_share == pytest.approx(0.96)
    assert step.stent.holds(12.5) and step.stent.holds(27.5) and not step.stent.holds(27.6)


@pytest.mark.parametrize(
    "change, message",
    [
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
        devices.steps(scene, "scene.json")

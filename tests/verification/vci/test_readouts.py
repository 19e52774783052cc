"""The read-outs in deployment.json of stents and of the vessel's axis, compared with the deployed scene."""

import json
import subprocess

import pytest

from vci.benchmarks import scenes

COARSE_NUMERICS = {"device_edge_mm": 0.6}


@pytest.fixture(scope="module")
def deploy(binary, tmp_path_factory):
    """deploy(tube, change, **scene_options) -> deployment.json of a generated scene, changed by `change(document)`."""

    def run(tube, change=lambda document: None, **scene_options):
        scene = scenes.write_scene(
            tmp_path_factory.mktemp("readouts") / "case", tube, **({"numerics": COARSE_NUMERICS} | scene_options)
        )
        document = json.loads(scene.read_text())
        change(document)
        scene.write_text(json.dumps(document))
        command = [str(binary("vci")), "deploy", str(scene), "--out", str(scene.parent / "out")]
        result = subprocess.run(command, text=True, capture_output=True, timeout=300)
        assert result.returncode == 0, result.stderr
        return json.loads((scene.parent / "out" / "deployment.json").read_text())

    return run


def keep_steps(*kept):
    """change(document): keeps only these steps of the procedure."""

    def change(document):
        document["procedure"] = [document["procedure"][k] for k in kept]

    return change


def test_stents_in_series_recoil_as_each_alone(deploy):
    tube = scenes.Tube(length=44, edge=0.8, stenosis=0.4, lesion_length=24)
    shifts = (-7.0, 7.0)
    alone = [deploy(tube, keep_steps(0, 1), shifts=(s,), length=10.0)["stents"][0]["recoil_percent"] for s in shifts]
    result = deploy(tube, keep_steps(0, 1, 2), shifts=shifts, length=10.0)
    series = [s["recoil_percent"] for s in result["stents"]]
    assert min(alone) > 2
    assert series == pytest.approx(alone, rel=0.05)
    for key, worst in (("minimal_stent_area_mm2", min), ("recoil_percent", max), ("foreshortening_percent", max)):
        values = [stent[key] for stent in result["stents"]]
        assert values[0] != values[1] and result[key] == worst(values)


def test_a_balloon_that_does_not_fill_the_stent_leaves_its_recoil(deploy):
    tube = scenes.Tube(edge=0.8)

    def smaller(document):
        post = document["devices"]["post"]
        post["chart"]["diameter_mm"] = [0.7 * d for d in post["chart"]["diameter_mm"]]

    alone = deploy(tube, keep_steps(0, 1))["stents"][0]
    after = deploy(tube, smaller)["stents"][0]
    assert after["recoil_percent"] == pytest.approx(alone["recoil_percent"], rel=0.03)


def test_a_larger_balloon_in_the_stent_counts(deploy):
    tube = scenes.Tube(edge=0.8)

    def larger(document):
        post = document["devices"]["post"]
        post["chart"]["diameter_mm"] = [1.03 * d for d in post["chart"]["diameter_mm"]]

    before, after = deploy(tube, keep_steps(0, 1))["stents"][0], deploy(tube, larger)["stents"][0]
    assert after["inflated_diameter_mm"] > before["inflated_diameter_mm"] + 0.1
    assert after["recoil_percent"] == pytest.approx(before["recoil_percent"], abs=1)


def test_a_straight_vessel_is_not_straightened(deploy):
    """The read-out has 0.6 degrees of noise here, since the recoiled rings of a coarse mesh do not lie exactly on one
    axis."""
    assert abs(deploy(scenes.Tube(stenosis=0.6, edge=0.6))["straightening_deg"]) < 1


def test_a_stent_straightens_a_bend(deploy):
    assert deploy(scenes.Tube(stenosis=0.6, curvature=0.12, edge=0.6))["straightening_deg"] > 2


def test_without_ties_contact_alone_holds_the_stent(deploy):
    """With a tie stiffness of 0 there are no ties, and contact alone must balance the stent.

    Were a constant force in place of the ties, it would press on the wall for ever.
    """
    tube = scenes.Tube(edge=0.8)
    tied, free = (deploy(tube, numerics=COARSE_NUMERICS | {"tie_stiffness_mpa_per_mm": k}) for k in (60, 0))
    assert max(s["residual"] for s in free["stages"]) <= 3e-3
    assert free["minimal_stent_area_mm2"] == pytest.approx(tied["minimal_stent_area_mm2"], rel=0.02)
    assert free["stents"][0]["recoil_percent"] == pytest.approx(tied["stents"][0]["recoil_percent"], rel=0.2)


def test_textbook_integration_ends_at_rest(deploy):
    """The textbook scheme stops when velocities are small, not when forces balance."""
    tube = scenes.Tube(edge=1.2, lesion_length=6)
    textbook = COARSE_NUMERICS | {
        "device_edge_mm": 1.0,
        "integration": "textbook",
        "velocity_stop_mm_per_ms": 0.5,
        "maximal_steps_per_stage": 20000,
    }
    assert deploy(tube, keep_steps(0), length=8.0, numerics=textbook)["status"] == "at rest"
    assert deploy(tube, keep_steps(0), length=8.0)["status"] == "converged"

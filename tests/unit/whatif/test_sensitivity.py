"""Uncertain inputs of flow and deployment: their effect on the boundary values and on the scene."""

import numpy as np
import pytest

from common.errors import ComputationError
from whatif import flow_inputs, sensitivity


PATIENT = {"lvm_g": 150, "sbp_mmhg": 120, "dbp_mmhg": 80}  # as of the vessel in conftest.py
SCENE = {
    "segment": {"branch": "main", "s_start_mm": 10.0, "s_end_mm": 28.0},
    "devices": {
        "balloon": {"kind": "balloon", "chart": {"pressure_bar": [4, 16]}, "rated_burst_pressure_bar": 14},
        "stent": {"kind": "stent", "balloon": "balloon"},
    },
    "procedure": [{"devices": [{"device": "stent", "pressure_bar": 10.0, "centre_s_mm": 19.0}]}],
    "wall": {"youngs_modulus_mpa": 0.8, "plaque": {"fibrous": {"youngs_modulus_mpa": 2.0}}},
}


def flow_at(vessel, values):
    document = flow_inputs.boundary_with_inputs(vessel, PATIENT, None, values)
    return document["q_hyperaemic_m3_per_s"] / vessel.boundary["q_hyperaemic_m3_per_s"], document


@pytest.mark.parametrize(
    "values, factor",
    [
        ({}, 1.0),
        ({"mass": 20.0}, 1.2**0.75),
        ({"hyperaemia": -10.0}, 0.9),
        ({"territory": 50.0, "hyperaemia": 10.0}, 1.65),
    ],
)
def test_inputs_move_the_flow_by_their_law(vessel, values, factor):
    found, document = flow_at(vessel, values)
    assert found == pytest.approx(factor)
    resistance = vessel.boundary["outlets"][0]["resistance_pa_s_per_m3"] / factor
    assert document["outlets"][0]["resistance_pa_s_per_m3"] == pytest.approx(resistance)


def test_blood_pressure_moves_both_pressures(vessel):
    _, document = flow_at(vessel, {"blood_pressure": 10.0})
    assert document["map_pa"] - vessel.boundary["map_pa"] == pytest.approx(1333.22)


def test_the_inputs_of_a_patient(vessel):
    names = {one.name: one for one in flow_inputs.uncertain_inputs(PATIENT, vessel.flow_settings, 2)}
    assert set(names) == {"blood_pressure", "mass", "hyperaemia", "territory", "split_exponent", "outlet_diameter"}
    assert all(one.low < one.planned < one.high for one in names.values())
    # 3.69 mL/min/g in 7 or 5 of the 17 segments of 150 g, divided by 190.2 mL/min of the published law
    assert names["territory"].high == pytest.approx(100 * (3.69 * 150 * 7 / 17 / 190.2 - 1), abs=0.1)
    assert names["territory"].low == pytest.approx(100 * (3.69 * 150 * 5 / 17 / 190.2 - 1), abs=0.1)
    alone = {one.name for one in flow_inputs.uncertain_inputs(PATIENT, vessel.flow_settings, 1)}
    assert alone == {"blood_pressure", "mass", "hyperaemia", "territory"}, "one outlet has nothing to split"


def test_a_measured_flow_leaves_its_own_error_alone(vessel):
    measured = PATIENT | {"hyperaemic_inflow_ml_per_min": 60.0}
    assert [one.name for one in flow_inputs.uncertain_inputs(measured, vessel.flow_settings, 1)] == [
        "blood_pressure",
        "flow",
    ]
    document = flow_inputs.boundary_with_inputs(vessel, measured, None, {"flow": 10.0})
    assert document["q_hyperaemic_m3_per_s"] == pytest.approx(1e-6 * 66 / 60)


def test_a_flow_that_does_not_pass_has_no_answer(vessel, capsys):
    answers = sensitivity.VariedFlow.__new__(sensitivity.VariedFlow)
    answers.case, answers.measured = vessel, None
    answers.patient = PATIENT | {"hyperaemic_inflow_ml_per_min": 3000.0}
    answers.lumens, answers.planned = {"pre": vessel.lumen("pre")}, {"pre": 0.1}
    assert answers.ffr_of_states({"flow": 10.0}) == {}
    assert "does not let the measured flow pass" in capsys.readouterr().out
    with pytest.raises(ComputationError, match="no answer as planned"):
        answers.ffr_of_states({})


@pytest.fixture
def case_file(tmp_path):
    file = tmp_path / "case.yaml"
    file.write_text(
        "kind: surface\ndescription: x\npatient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}\n"
        "lumen: {path: a.stl, units: mm}\nplan: auto\n"
    )
    return file


def test_each_state_has_an_interval_but_only_two_have_bars(vessel, case_file):
    table, intervals = sensitivity.flow_sensitivity(vessel, case_file, ["pre", "vci", "rc"])
    assert set(table["state"]) == {"pre", "vci"}
    assert intervals["planned"].tolist() == [0.70, 0.90, 0.92]
    width = dict(zip(intervals["state"], intervals["upper"] - intervals["lower"]))
    assert all(intervals["lower"] < intervals["planned"]) and all(intervals["planned"] < intervals["upper"])
    assert width["pre"] > width["vci"] > width["rc"] > 0, "the more is lost, the more depends on the inputs"


def test_more_flow_lowers_ffr_before_more_than_after(vessel, case_file):
    answers = sensitivity.VariedFlow(vessel, case_file)
    planned, more = answers.ffr_of_states({}), answers.ffr_of_states({"mass": 20.0})
    assert planned == {("pre", "ffr"): 0.70, ("vci", "ffr"): 0.90}
    drop = {state: planned[state, "ffr"] - more[state, "ffr"] for state in ("pre", "vci")}
    # The loss of a tube is proportional to its flow. A larger loss lowers the flow.
    assert 0.0 < drop["vci"] < 0.1 * 0.15 and drop["vci"] < drop["pre"] < 0.3 * 0.15


def test_a_scene_is_varied_by_each_input():
    other = sensitivity.scene_with_inputs(SCENE, {"placement": 2.0, "wall_stiffness": 0.5, "plaque_stiffness": 2.0})
    assert other["procedure"][0]["devices"][0] == {"device": "stent", "pressure_bar": 10.0, "centre_s_mm": 21.0}
    assert other["segment"] == {"branch": "main", "s_start_mm": 12.0, "s_end_mm": 30.0}
    assert other["wall"] == {"youngs_modulus_mpa": 0.4, "plaque": {"fibrous": {"youngs_modulus_mpa": 4.0}}}
    assert SCENE["wall"]["youngs_modulus_mpa"] == 0.8, "the scene itself is left alone"


@pytest.mark.parametrize("percent, pressure", [(-20.0, 8.0), (20.0, 12.0), (100.0, 16.0)])
def test_pressures_end_with_the_balloons_chart(percent, pressure):
    other = sensitivity.scene_with_inputs(SCENE, {"balloon_pressure": percent})
    assert np.isclose(other["procedure"][0]["devices"][0]["pressure_bar"], pressure)

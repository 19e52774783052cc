"""The flow into the tree by the published law, by a territory's share, or as measured, and other plausible flows."""

import pytest

from common.errors import InputError
from flow.inputs import hyperaemia

ML = 6e7  # mL/min in a m3/s


def flow(**patient):
    return hyperaemia.flow_source({"sbp_mmhg": 120, "dbp_mmhg": 80, **patient}, 0.16)["flow_m3_per_s"] * ML


def test_whole_is_the_published_law():
    assert flow(lvm_g=150) == flow(lvm_g=150, territory="whole") == pytest.approx(0.71 * 150**0.75 / 0.16)


def test_territories_are_the_ventricles_segments():
    by = {name: flow(lvm_g=150, territory=name) for name in ("lad", "lcx", "rca", "left")}
    assert by["lad"] == pytest.approx(3.69 * 150 * 7 / 17)
    assert by["left"] == pytest.approx(by["lad"] + by["lcx"]) and by["lcx"] == by["rca"]
    assert sum(by[name] for name in ("lad", "lcx", "rca")) == pytest.approx(3.69 * 150)
    assert flow(lvm_g=150, territory=7 / 17) == pytest.approx(by["lad"])


def test_territories_are_within_what_was_measured():
    """Continuous thermodilution: 228 +- 71 mL/min in LADs, 582 +- 138 in whole hearts (Fournier et al. 2021)."""
    assert abs(flow(lvm_g=150, territory="lad") - 228) < 71
    assert abs(flow(lvm_g=150, territory=1.0) - 582) < 138
    assert abs(flow(cardiac_output_l_per_min=5.0, territory=1.0) - 582) < 138


def test_a_measured_inflow_is_what_it_is():
    assert flow(hyperaemic_inflow_ml_per_min=140.0, lvm_g=300, territory="left") == pytest.approx(140)


@pytest.mark.parametrize(
    "patient, what",
    [({}, "nothing to tell the flow by"), ({"cardiac_output_l_per_min": 5.0}, "shared out by territory")],
)
def test_refusals(patient, what):
    with pytest.raises(InputError, match=what):
        flow(**patient)


@pytest.mark.parametrize("territory, most", [("whole", 858), ("left", 605), ("lad", 353), (0.5, 429)])
def test_an_inflow_is_doubted_two_deviations_above_its_territory(territory, most):
    for given, doubted in ((most, False), (most + 1, True)):
        patient = {"hyperaemic_inflow_ml_per_min": given, "territory": territory}
        assert bool(hyperaemia.flow_warnings(patient)) == doubted
    assert hyperaemia.flow_warnings({"lvm_g": 500}) == []


def test_values_that_are_not_used_are_said():
    (said,) = hyperaemia.flow_warnings({"lvm_g": 150, "cardiac_output_l_per_min": 5.0, "territory": "lad"})
    assert said.startswith("patient.lvm_g: not used, since patient.cardiac_output_l_per_min, 5,")
    (said,) = hyperaemia.flow_warnings(
        {"lvm_g": 150, "cardiac_output_l_per_min": 5.0, "hyperaemic_inflow_ml_per_min": 140}
    )
    assert "cardiac_output_l_per_min and patient.lvm_g: not used" in said and "140, tells the flow" in said
    assert hyperaemia.flow_warnings({"hyperaemic_inflow_ml_per_min": 140, "lvm_g": None}) == []


@pytest.mark.parametrize(
    "patient, teller",
    [
        ({"lvm_g": 150, "territory": "lad"}, "patient.territory, lad, with 3.69 mL/min/g tells"),
        ({"cardiac_output_l_per_min": 5.0, "territory": 0.3}, "patient.territory, 0.3, with cardiac output tells"),
        ({"hyperaemic_inflow_ml_per_min": 140}, "patient.hyperaemic_inflow_ml_per_min, 140, tells"),
    ],
)
def test_a_fraction_without_the_published_law_is_said(patient, teller):
    (said,) = hyperaemia.flow_warnings(patient, 0.32)
    assert said.startswith("settings.flow.hyperaemia_fraction is 0.32: not used") and teller in said
    assert hyperaemia.flow_warnings(patient, 0.16) == hyperaemia.flow_warnings({"lvm_g": 150}, 0.32) == []


def factors(**patient):
    return {one["what"]: one["factor"] for one in hyperaemia.plausible_flows(patient, 0.16)}


@pytest.mark.parametrize(
    "share, less",
    [(0.02, 0.5), (1 / 17, 0.5), (1.25 / 17, 0.4), (2 / 17, 0.5), (7 / 17, 6 / 7)],
)
def test_a_segment_less_lowers_the_flow_of_any_share(share, less):
    found = factors(lvm_g=150, territory=share)
    assert found["territory -1 of 17 segments"] == pytest.approx(less)
    assert found["territory +1 of 17 segments"] == pytest.approx(1 + 1 / 17 / share)


def test_plausible_flows():
    whole, lad = factors(lvm_g=150), factors(lvm_g=150, territory="lad")
    assert whole["mass +20 %"] == pytest.approx(1.2**0.75) and lad["mass +20 %"] == pytest.approx(1.2)
    assert whole["territory left"] * flow(lvm_g=150) == pytest.approx(flow(lvm_g=150, territory="left"))
    assert lad["territory -1 of 17 segments"] == pytest.approx(6 / 7)
    assert "mass +20 %" not in factors(cardiac_output_l_per_min=5.0, territory="rca")
    assert factors(hyperaemic_inflow_ml_per_min=140.0) == {}

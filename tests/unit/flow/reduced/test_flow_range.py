"""FFR over plausible flows, and resistances for a measured inflow, compared with the network at the same flows."""

import numpy as np
import pandas as pd
import pytest

from common.errors import InputError
from flow.physics.units import PA_PER_MMHG
from flow.reduced import flow_range, network as network_model

PROBE = ("main", 35.0)
MAP, VENOUS, FLOW = 12000.0, 600.0, 3e-6


def document(factors=(0.8, 1.3)):
    outlet = {"name": "outlet1", "branch": "main", "region_id": 2, "diameter_mm": 2.5, "flow_m3_per_s": FLOW}
    return {
        "map_pa": MAP,
        "venous_pressure_pa": VENOUS,
        "density_kg_per_m3": 1060.0,
        "viscosity_pa_s": 0.004,
        "q_hyperaemic_m3_per_s": FLOW,
        "outlets": [outlet | {"resistance_pa_s_per_m3": (MAP - VENOUS) / FLOW}],
        "plausible_flows": [{"what": f"x{factor}", "factor": factor} for factor in factors],
    }


def network_at(values, throat=0.55):
    s = np.linspace(0, 40, 161)
    radius = 1.5 - (1.5 - throat) * 0.5 * (1 + np.cos(np.pi * np.clip((s - 15) / 5, -1, 1)))
    sections = pd.DataFrame({"branch": "main", "s_mm": s, "area_mm2": np.pi * radius**2})
    anatomy = {"branches": [{"name": "main", "parent": None, "s_on_parent_mm": None}]}
    return network_model.Network(anatomy, sections, values, 1.14)


def network_ffr(values):
    network = network_at(values)
    s, pressure = network.pressures(network.solve())["main"]
    return float(np.interp(PROBE[1] * 1e-3, s, pressure)) / MAP


def test_the_networks_own_answer_gives_the_networks_range():
    own = network_ffr(document())
    found = flow_range.ffr_range(own, document(), network_at, PROBE)
    for one in found["at"]:
        assert one["ffr"] == pytest.approx(network_ffr(flow_range.scale_flow(document(), one["factor"])), abs=1e-9)
    assert found["low"] == found["at"][1]["ffr"] < own < found["high"] == found["at"][0]["ffr"]


def test_another_answers_loss_is_scaled():
    own = network_ffr(document())
    shown = 1 - 1.2 * (1 - own)
    found = flow_range.ffr_range(shown, document([1.0, 1.3]), network_at, PROBE)["at"]
    assert found[0]["ffr"] == pytest.approx(shown)
    assert 1 - found[1]["ffr"] == pytest.approx(1.2 * (1 - network_ffr(flow_range.scale_flow(document(), 1.3))))


def test_no_range_without_other_flows():
    assert flow_range.ffr_range(0.8, document(()), network_at, PROBE) is None


def test_a_measured_inflow_passes_the_narrowed_vessel():
    """With the planned resistances less than the measured flow passes. The fitted resistances are lower and let it
    pass."""
    planned = document()
    assert network_at(planned).solve().sum() < 0.95 * FLOW
    found = flow_range.fit_resistances(planned, network_at)
    assert network_at(found).solve().sum() == pytest.approx(FLOW, rel=1e-5)
    assert found["outlets"][0]["resistance_pa_s_per_m3"] < planned["outlets"][0]["resistance_pa_s_per_m3"]
    assert found["q_hyperaemic_m3_per_s"] == found["outlets"][0]["flow_m3_per_s"] == FLOW


def test_more_than_the_narrowing_lets_pass_is_refused():
    with pytest.raises(InputError, match="does not let the measured flow pass(.|\n)*at most"):
        flow_range.fit_resistances(document(), lambda values: network_at(values, throat=0.35))


def test_a_measured_inflow_has_a_range_of_its_own():
    """The range has FFR at the flow +-10 %, and at the same flow with a pressure 10 mmHg off. Both equal new solutions
    of the network."""
    base = flow_range.fit_resistances(document(), network_at)
    base["plausible_flows"] = flow_range.plausible_around_inflow(document(), network_at, 2.55)
    assert [one["what"] for one in base["plausible_flows"]] == [what for what, *_ in flow_range.INFLOW_VARIATIONS[:4]]
    own = network_ffr(base)
    found = {one["what"]: one["ffr"] for one in flow_range.ffr_range(own, base, network_at, PROBE)["at"]}
    faster = flow_range.fit_resistances(flow_range.scale_flow(document(), 1.1), network_at)
    assert network_at(faster).solve().sum() == pytest.approx(1.1 * FLOW, rel=1e-5)
    assert found["measured flow +10 %"] == pytest.approx(network_ffr(faster), abs=1e-5)
    assert found["measured flow +10 %"] < own < found["measured flow -10 %"]
    lost = (1 - own) * MAP / (MAP + 10 * PA_PER_MMHG)  # the same flow loses the same pressure
    assert 1 - found["pressure +10 mmHg"] == pytest.approx(lost, rel=1e-4)


def test_the_split_counts_where_there_are_two_outlets():
    two = document()
    first = two["outlets"][0] | {"diameter_mm": 2.0, "flow_m3_per_s": FLOW / 2}
    first["resistance_pa_s_per_m3"] *= 2
    two["outlets"] = [first, first | {"name": "outlet2", "region_id": 3, "diameter_mm": 1.0}]
    found = {one["what"]: one for one in flow_range.plausible_around_inflow(two, network_at, 2.0)}
    assert "split by diameter^2" not in found, "which is the exponent there is"
    near, far = found["split by diameter^3"]["resistances_pa_s_per_m3"]
    assert far / near == pytest.approx(8)
    assert "split by diameter^2" in {one["what"] for one in flow_range.plausible_around_inflow(two, network_at, 2.55)}


def test_a_flow_that_does_not_pass_is_left_out():
    def throat(radius):
        return lambda values: network_at(values, throat=radius)

    radius = 0.55
    while True:  # find the narrowest throat, in steps of .01 mm, that lets the flow pass
        try:
            flow_range.fit_resistances(document(), throat(radius - 0.01))
        except InputError:
            break
        radius -= 0.01
    assert "measured flow +10 %" not in {
        one["what"] for one in flow_range.plausible_around_inflow(document(), throat(radius), 2.55)
    }

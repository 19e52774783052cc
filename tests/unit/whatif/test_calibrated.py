"""The calibrated network: Poiseuille's loss, the FFR of the states it is calibrated on, its error on the others."""

import numpy as np
import pytest

from common.errors import InputError
from whatif import calibrated


def test_the_networks_loss_of_a_tube_is_poiseuilles(vessel):
    document = vessel.boundary
    probe = document["probes"][0]
    per_metre = 8 * document["viscosity_pa_s"] / (np.pi * 1e-3**4)
    pressure = document["map_pa"] - document["venous_pressure_pa"]
    # 39 mm long, because the sections leave half a millimetre at each end
    flow = pressure / (per_metre * 39.0e-3 + document["outlets"][0]["resistance_pa_s_per_m3"])
    expected = per_metre * flow * (probe["s_mm"] - 0.5) * 1e-3 / document["map_pa"]
    assert 0 < probe["s_mm"] < 40
    found = calibrated.network_loss(vessel.lumen("pre"), document, 1.14)
    assert found == pytest.approx(expected, rel=1e-6)


def test_the_probe_is_found_where_the_axis_has_moved(vessel):
    """If the axis of a lumen is stretched by a tenth, the arc length of its sections at the probe grows by a tenth."""
    anatomy, sections = vessel.lumen("pre")
    probe = vessel.boundary["probes"][0]
    point = np.array(probe["point_mm"])
    assert calibrated.branch_axis(sections, "main").project(point)[0] == pytest.approx(probe["s_mm"])
    stretched = sections.assign(s_mm=1.1 * sections["s_mm"])
    assert calibrated.branch_axis(stretched, "main").project(point)[0] == pytest.approx(1.1 * probe["s_mm"])


def test_answers_are_given_back_and_the_third_tells_the_error(vessel):
    found = calibrated.calibrate(vessel, ["pre", "vci", "rc"])
    loss = {state: calibrated.network_loss(vessel.lumen(state), vessel.boundary, 1.14) for state in vessel.radii}
    assert found.ffr(loss["pre"]) == pytest.approx(0.70) and found.ffr(loss["vci"]) == pytest.approx(0.90)
    assert found.ffr(0.0) == 1.0 and found.states == ("rc",)
    assert found.error == pytest.approx(abs(1 - 0.1 * loss["rc"] / loss["vci"] - 0.92))
    assert found.error > 1e-3, "the made-up answer of rc is none of the network's"


def test_an_estimate_larger_than_what_was_missed_is_the_error(vessel):
    vessel.flow_results["pre"]["error_estimate"] = {"ffr": 0.2}
    assert calibrated.calibrate(vessel, ["rc"]).error == 0.2


def test_between_and_beyond_both_answers_losses_grow():
    found = calibrated.Calibration(np.array([0.0, 0.02, 0.1]), np.array([0.0, 0.03, 0.12]), 0.0, ())
    assert found.ffr(0.06) == pytest.approx(1 - 0.075)
    assert found.ffr(0.2) == pytest.approx(1 - 0.24)
    assert found.ffr(5.0) == 0.0


def test_a_lesion_without_any_loss_is_refused(vessel):
    vessel.flow_results = {"pre": {"ffr": 1.0}, "vci": {"ffr": 1.0}}
    with pytest.raises(InputError, match="no loss of pressure"):
        calibrated.calibrate(vessel, [])

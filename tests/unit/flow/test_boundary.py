"""Boundary values against the method's formulas, worked out by hand."""

import pathlib

import numpy as np
import pytest

import tubes
from common.errors import InputError
from flow import boundary, centreline
from flow import settings as settings_module


def test_mean_arterial_pressure():
    assert boundary.mean_arterial_pressure_mmhg(120, 80) == pytest.approx(96.0)


@pytest.mark.parametrize("sbp, dbp", [(80, 120), (80, 80), (120, 0)])
def test_pressures_out_of_order_are_refused(sbp, dbp):
    with pytest.raises(InputError, match="diastolic"):
        boundary.mean_arterial_pressure_mmhg(sbp, dbp)


def test_hyperaemic_flow():
    # 0.71 * 150^0.75 = 30.4322 mL/min at rest
    expected = 0.71 * np.exp(0.75 * np.log(150)) / 0.16
    assert boundary.hyperaemic_flow_m3_per_s(150, 0.16) * 6e7 == pytest.approx(expected, rel=1e-12)
    assert expected == pytest.approx(190.2, abs=0.2)


def test_implausible_mass_is_refused():
    with pytest.raises(InputError, match="grams"):
        boundary.hyperaemic_flow_m3_per_s(0.15, 0.16)


@pytest.mark.parametrize("anatomy", [{}, [], {"ends": []}, {"ends": [{"kind": "outlet"}]}])
def test_a_foreign_document_is_refused(anatomy):
    patient = {"lvm_g": 150, "sbp_mmhg": 120, "dbp_mmhg": 80}
    with pytest.raises(InputError, match="anatomy step"):
        boundary.make(anatomy, None, patient, settings_module.make())


@pytest.mark.parametrize("values", [{"rings": 2}, {"coarse_rings": 4}, {"coarse_cells_per_radius": 2.5}])
def test_a_coarse_mesh_that_is_not_coarser_is_refused(values):
    with pytest.raises(InputError, match="not coarser"):
        settings_module.check_meshes(vars(settings_module.make(**values)), "flow settings")


def test_split_is_exact():
    diameters = [3.0, 2.0, 1.1]
    fractions = boundary.split_by_diameter(diameters, 2.55)
    assert sum(fractions) == pytest.approx(1.0, abs=1e-15)
    assert fractions[0] / fractions[1] == pytest.approx(1.5**2.55, rel=1e-14)
    assert fractions[1] / fractions[2] == pytest.approx((2 / 1.1) ** 2.55, rel=1e-14)


def _anatomy(lesions=()):
    ends = [
        {"name": "inlet", "region_id": 1, "kind": "inlet", "branch": "main", "diameter_mm": 3.5},
        {"name": "outlet1", "region_id": 2, "kind": "outlet", "branch": "main", "diameter_mm": 2.5},
        {"name": "outlet2", "region_id": 3, "kind": "outlet", "branch": "side1", "diameter_mm": 1.5},
    ]
    return {"ends": ends, "lesions": list(lesions)}


def _tree():
    main = tubes.line(60, lambda s: 1.5)
    side = tubes.line(20, lambda s: 0.75, name="side1", branch_id=1)
    return centreline.Tree([side, main])


PATIENT = {"lvm_g": 150, "sbp_mmhg": 120, "dbp_mmhg": 80}


def test_resistances_draw_the_planned_flow_at_map(settings):
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    assert document["map_pa"] == pytest.approx(96 * 133.322)
    for outlet in document["outlets"]:
        drop = document["map_pa"] - document["venous_pressure_pa"]
        assert drop / outlet["resistance_pa_s_per_m3"] == pytest.approx(outlet["flow_m3_per_s"], rel=1e-14)
    total = sum(outlet["flow_m3_per_s"] for outlet in document["outlets"])
    assert total == pytest.approx(document["q_hyperaemic_m3_per_s"], rel=1e-14)
    boundary.check(document)


def test_probe_lies_past_the_most_severe_lesion(settings):
    lesion = {"branch": "main", "s_end_mm": 30.0}
    probe = boundary.make(_anatomy([lesion]), _tree(), PATIENT, settings)["probes"][0]
    assert (probe["name"], probe["branch"]) == ("distal", "main")
    assert probe["s_mm"] == pytest.approx(40.0)
    assert probe["point_mm"] == pytest.approx([40.0, 0, 0])


def test_probe_stays_inside_the_branch(settings):
    lesion = {"branch": "main", "s_end_mm": 57.0}
    probe = boundary.make(_anatomy([lesion]), _tree(), PATIENT, settings)["probes"][0]
    assert probe["s_mm"] == pytest.approx(60 - 3 * 1.5)


def test_negative_resistance_is_refused(settings):
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    document["outlets"][1]["resistance_pa_s_per_m3"] *= -1
    with pytest.raises(InputError, match="outlet2"):
        boundary.check(document, pathlib.Path("boundary.json"))


def test_pressure_in_mmhg_is_refused(settings):
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    document["map_pa"] = 96.0
    with pytest.raises(InputError, match="map_pa"):
        boundary.check(document)


def test_given_inflow_and_outlet_pressures():
    given = {"inlet_condition": "flow", "inlet_flow_ml_per_min": 150, "outlet_condition": "pressure"}
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings_module.make(**given, outlet_pressure_mmhg=80))
    boundary.check(document)
    assert document["inlet_flow_m3_per_s"] == pytest.approx(2.5e-6)
    assert [outlet["pressure_pa"] for outlet in document["outlets"]] == pytest.approx([80 * 133.322] * 2)
    assert [outlet["resistance_pa_s_per_m3"] for outlet in document["outlets"]] == [0, 0]
    del document["outlets"][1]["pressure_pa"]
    with pytest.raises(InputError, match="outlet2"):
        boundary.check(document)


def test_inflow_that_does_not_enter_is_refused():
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings_module.make())
    document["inlet_flow_m3_per_s"] = -1e-6
    with pytest.raises(InputError, match="inflow"):
        boundary.check(document)

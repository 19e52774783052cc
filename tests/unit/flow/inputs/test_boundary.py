"""Boundary values equal the formulas of the method, evaluated by hand. Bad values and files are refused."""

import json
import math
import pathlib

import numpy as np
import pytest

import tubes
from common.errors import InputError
from flow import __main__ as command_line
from flow.geometry import centreline
from flow.inputs import boundary, hyperaemia, lumen_summary
from flow.physics import ffr, viscosity
from flow import settings as settings_module


def test_hyperaemic_flow():
    # 0.71 * 150^0.75 = 30.4 mL/min at rest, for a mass of 150 g
    expected = 0.71 * np.exp(0.75 * np.log(150)) / 0.16
    assert hyperaemia.flow_of_mass(150, 0.16) * 6e7 == pytest.approx(expected, rel=1e-12)
    assert expected == pytest.approx(190.2, abs=0.2)


def test_implausible_mass_is_refused():
    with pytest.raises(InputError, match="grams"):
        hyperaemia.flow_of_mass(0.15, 0.16)


@pytest.mark.parametrize("anatomy", [{}, [], {"ends": []}, {"ends": [{"kind": "outlet"}]}])
def test_a_foreign_document_is_refused(anatomy):
    with pytest.raises(InputError, match="anatomy step"):
        lumen_summary.check(anatomy, "anatomy.json", "ends")


@pytest.mark.parametrize(
    "values", [{"rings": 3}, {"coarse_rings": [2, 4]}, {"coarse_rings": [3, 2]}, {"coarse_cells_per_radius": 2.5}]
)
def test_a_coarse_mesh_that_is_not_coarser_is_refused(values):
    with pytest.raises(InputError, match="not coarser"):
        settings_module.check_meshes(vars(settings_module.make(**values)), "flow settings")


def test_meshes_that_are_coarser_each_are_let_through():
    for values in ({}, {"coarse_rings": [3]}, {"coarse_rings": [2, 5], "rings": 6}):
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
    main = tubes.centre_branch(60, lambda s: 1.5)
    side = tubes.centre_branch(20, lambda s: 0.75, name="side1", branch_id=1)
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
    document = boundary.make(_anatomy([lesion]), _tree(), PATIENT, settings)
    probe = document["probes"][0]
    assert document["warnings"] == [] and probe["distance_mm"] == pytest.approx(10.0)
    assert (probe["name"], probe["branch"]) == ("distal", "main")
    assert probe["s_mm"] == pytest.approx(40.0)
    assert probe["point_mm"] == pytest.approx([40.0, 0, 0])


def test_probe_stays_inside_the_branch(settings):
    lesion = {"branch": "main", "s_end_mm": 52.0}
    document = boundary.make(_anatomy([lesion]), _tree(), PATIENT, settings)
    probe = document["probes"][0]
    assert probe["s_mm"] == pytest.approx(60 - 3 * 1.5) and probe["distance_mm"] == pytest.approx(3.5)
    (said,) = document["warnings"]
    assert "probe distal is 3.5 mm past its lesion's end instead of 10 mm" in said


WIRE = {"ffr_pre": 0.7, "ffr_post": None}


@pytest.mark.parametrize("place", [{"branch": "main", "s_mm": 48.0}, {"point_mm": [48.0, 2.8, 0.0]}])
def test_the_wires_sensor_is_one_more_probe(settings, place):
    """The place is an arc length or a point. The point is off the axis as far as the wall of a dilated vessel would be;
    this is allowed."""
    measured = {**WIRE, "probe": place}
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings, measured)
    *others, last = document["probes"]
    assert (last["name"], last["branch"], last["s_mm"]) == ("measured", "main", pytest.approx(48.0))
    assert last["point_mm"] == pytest.approx([48.0, 0, 0])
    assert others == boundary.make(_anatomy(), _tree(), PATIENT, settings)["probes"]


@pytest.mark.parametrize(
    "place, words",
    [
        ({"branch": "side2", "s_mm": 4.0}, "side2(.|\n)*main"),
        ({"branch": "main", "s_mm": 61.6}, "1.6 mm beyond the end of main, which is 60.0 mm long"),
        ({"point_mm": [61.6, 0.0, 0.0]}, "1.6 mm beyond the end of main, which is 60.0 mm long"),
        ({"point_mm": [48.0, 3.2, 0.0]}, "3.2 mm from the nearest axis"),
    ],
)
def test_a_sensor_outside_the_vessel_is_refused(settings, place, words):
    with pytest.raises(InputError, match=words):
        boundary.make(_anatomy(), _tree(), PATIENT, settings, {**WIRE, "probe": place})


@pytest.mark.parametrize("place", [{"branch": "main", "s_mm": 60.1}, {"point_mm": [61.4, 1.0, 0.0]}])
def test_a_sensor_less_than_a_radius_beyond_the_end_is_at_the_end(settings, place):
    measured = {**WIRE, "probe": place}
    assert boundary.make(_anatomy(), _tree(), PATIENT, settings, measured)["probes"][-1]["s_mm"] == 60.0


def test_unusual_values_are_said(settings):
    """A measured FFR that is lower after the procedure, or an implausible inflow, gives a warning and is still used."""
    patient = PATIENT | {"hyperaemic_inflow_ml_per_min": 900, "lvm_g": None}
    measured = {"ffr_pre": 0.92, "ffr_post": 0.71, "probe": {"branch": "main", "s_mm": 48.0}}
    flow, swapped = boundary.make(_anatomy(), _tree(), patient, settings, measured)["warnings"]
    assert "900 mL/min" in flow and "858" in flow and "0.71, is below measured.ffr_pre, 0.92" in swapped
    assert (
        boundary.patient_warnings(patient | {"hyperaemic_inflow_ml_per_min": 850}, measured | {"ffr_post": 0.92}) == []
    )
    (unused,) = boundary.make(
        _anatomy(), _tree(), PATIENT | {"territory": "lad"}, settings_module.make(hyperaemia_fraction=0.32)
    )["warnings"]
    assert "hyperaemia_fraction is 0.32: not used" in unused


@pytest.mark.parametrize("branch, s_mm, doubted", [("main", 2.5, True), ("side1", 9.0, True), ("main", 48.0, False)])
def test_a_sensor_upstream_of_every_lesion_is_doubted(settings, branch, s_mm, doubted):
    """A sensor in a side branch that leaves before the lesion is doubted, too. Without lesions there is no warning."""
    lesion = {"branch": "main", "s_start_mm": 25.0, "s_end_mm": 33.0}
    tree = [
        {"name": "main", "parent": None, "s_on_parent_mm": None, "length_mm": 60.0},
        {"name": "side1", "parent": "main", "s_on_parent_mm": 20.0, "length_mm": 20.0},
    ]
    measured = {**WIRE, "probe": {"branch": branch, "s_mm": s_mm}}
    anatomy = _anatomy([lesion]) | {"branches": tree}
    said = boundary.make(anatomy, _tree(), PATIENT, settings, measured)["warnings"]
    assert len(said) == doubted and all("upstream of every lesion" in one and "33.0 mm of main" in one for one in said)
    assert boundary.make(anatomy | {"lesions": []}, _tree(), PATIENT, settings, measured)["warnings"] == []
    tree[1]["s_on_parent_mm"] = 40.0  # a branch that leaves beyond the lesion shows its effect
    if branch == "side1":
        assert boundary.make(anatomy, _tree(), PATIENT, settings, measured)["warnings"] == []


def test_negative_resistance_is_refused(settings):
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    document["outlets"][1]["resistance_pa_s_per_m3"] *= -1
    with pytest.raises(InputError, match="outlet2"):
        boundary.check(document, pathlib.Path("boundary.json"))


@pytest.mark.parametrize("factor", [1e3, 1 / 133.322e6, 11, 1 / 11])
def test_a_resistance_in_other_units_is_refused(settings, factor):
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    document["outlets"][1]["resistance_pa_s_per_m3"] *= factor
    with pytest.raises(InputError, match="resistance does not belong(.|\n)*outlet2"):
        boundary.check(document)


def test_resistances_of_1_to_100_each_belong_to_their_own_flow(settings):
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    document["outlets"][0]["flow_m3_per_s"] /= 100
    document["outlets"][0]["resistance_pa_s_per_m3"] *= 100
    boundary.check(document)
    for factor in (9, 1 / 9):
        changed = json.loads(json.dumps(document))
        changed["outlets"][0]["resistance_pa_s_per_m3"] *= factor
        boundary.check(changed)


def test_pressure_in_mmhg_is_refused(settings):
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    document["map_pa"] = 96.0
    with pytest.raises(InputError, match="map_pa"):
        boundary.check(document)


THINNING = viscosity.from_settings(settings_module.make(viscosity_model="carreau_yasuda"))


def _changed(place, value):
    """boundary.json of the tree with one value changed, or removed if `value` is None. place: the keys of the value."""
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings_module.make())
    document = json.loads(json.dumps(document))
    inner = document
    for key in place[:-1]:
        inner = inner[key]
    if value is None:
        del inner[place[-1]]
    else:
        inner[place[-1]] = value
    return document


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("venous_pressure_pa",), 12798.912, ["venous_pressure_pa", "not below MAP", "12798.9"]),
        (("map_pa",), 96.0, ["map_pa", "96.0", "133.322 Pa"]),
        (("map_pa",), 12.8, ["map_pa", "1 kPa is 1000 Pa"]),
        (("map_pa",), 96000.0, ["map_pa", "at most 30000 in Pa"]),
        (("map_pa",), "93", ["map_pa", "'93'", "a number"]),
        (("outlets", 1, "region_id"), 2, ["outlets", "same region_id", "2"]),
        (("outlets", 1, "name"), "outlet1", ["outlets", "same name", "outlet1"]),
        (("outlets", 1, "branch"), "main", ["outlets", "same branch", "main"]),
        (("outlets", 1, "branch"), "side7", ["outlet2", "side7", "known: main, side1"]),
        (("probes", 1, "branch"), "side7", ["end_main", "side7", "known: main, side1"]),
        (("outlets", 1, "resistance_pa_s_per_m3"), math.inf, ["outlets[2].resistance", "not finite"]),
        (("outlets", 1, "resistance_pa_s_per_m3"), "5e9", ["outlets[2].resistance", "a number"]),
        (("outlets", 1, "resistance_pa_s_per_m3"), None, ["outlets[2]", "resistance_pa_s_per_m3 is missing"]),
        (("outlets", 1, "flow_m3_per_s"), None, ["outlets[2]", "flow_m3_per_s is missing"]),
        (("outlets",), [], ["outlets", "at least 1 entries"]),
        (("probes",), [], ["probes", "at least 1 entries"]),
        (("probes",), None, ["probes is missing"]),
        (("probes", 0, "name"), "first", ["first probe is not `distal`", "boundary.json: probes", "first"]),
        (("probes", 0, "point_mm"), [1.0, math.nan, 0.0], ["probes[1].point_mm[2]", "not finite"]),
        (("probes", 0, "point_mm"), [1.0, 0.0], ["probes[1].point_mm", "a list of 3 entries"]),
        (("venous_pressure_pa",), math.nan, ["venous_pressure_pa", "not finite"]),
        (("warnings",), "none", ["warnings", "a list"]),
        (("viscosity",), {"model": "carreau_yasuda"}, ["viscosity", "zero_shear_pa_s is missing"]),
        (("viscosity",), THINNING | {"model": "casson"}, ["viscosity", "casson"]),
        (("viscosity",), THINNING | {"infinite_shear_pa_s": 0.0}, ["viscosity", "infinite_shear_pa_s"]),
        (("viscosity",), THINNING | {"infinite_shear_pa_s": 0.1}, ["viscosities out of order", "0.1, 0.056"]),
    ],
)
def test_bad_boundary_values_are_refused_in_plain_words(place, value, words):
    with pytest.raises(InputError) as refused:
        boundary.check(_changed(place, value), "boundary.json", ["main", "side1"])
    for word in words:
        assert word in str(refused.value), str(refused.value)


def test_boundary_values_are_checked_where_they_are_made(settings):
    anatomy = _anatomy()
    anatomy["ends"][2]["region_id"] = 2
    with pytest.raises(InputError, match="same region_id"):
        boundary.make(anatomy, _tree(), PATIENT, settings)


def _summary():
    branches = [
        {"name": "main", "parent": None, "s_on_parent_mm": 0.0},
        {"name": "side1", "parent": "main", "s_on_parent_mm": 20.0},
    ]
    return _anatomy([{"branch": "main", "s_end_mm": 30.0}]) | {"branches": branches}


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("ends", 1, "diameter_mm"), "2.5", ["ends[2].diameter_mm", "'2.5'", "a number"]),
        (("ends", 1, "diameter_mm"), math.nan, ["ends[2].diameter_mm", "not finite"]),
        (("ends",), {}, ["ends", "a list"]),
        (("lesions", 0), {"branch": "main"}, ["lesions[1]", "s_end_mm is missing"]),
        (("branches", 1, "parent"), "side1", ["not one tree", "side1"]),
        (("branches", 1, "parent"), "side7", ["not one tree", "side1"]),
        (("branches", 1, "parent"), None, ["not one tree", "without a parent"]),
        (("branches", 1, "name"), "main", ["same name"]),
        (("branches", 1, "s_on_parent_mm"), None, ["side1", "s_on_parent_mm null"]),
    ],
)
def test_a_bad_summary_of_the_lumen_is_refused_in_plain_words(tmp_path, place, value, words):
    document, path = _summary(), tmp_path / "anatomy.json"
    path.write_text(json.dumps(document))
    assert lumen_summary.read(path, "ends", "branches") == document
    inner = document
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    path.write_text(json.dumps(document))
    with pytest.raises(InputError) as refused:
        lumen_summary.read(path, "ends", "branches")
    for word in [str(path), *words]:
        assert word in str(refused.value), str(refused.value)


OF_OTHER_KINDS = ["5", "[]", "{", '"93"']


@pytest.mark.parametrize(
    ("spoilt", "text"),
    [(name, text) for name in ("boundary.json", "anatomy.json", "settings.json") for text in OF_OTHER_KINDS]
    + [(name, text) for name in ("boundary.json", "anatomy.json") for text in ("", '{"map_pa": NaN}')],
)
def test_a_file_of_another_kind_ends_with_one_clear_error(tmp_path, capsys, spoilt, text):
    tubes.write_centreline(tmp_path / "centreline.vtp", list(_tree()))
    (tmp_path / "anatomy.json").write_text(json.dumps(_summary()))
    document = boundary.make(_anatomy(), _tree(), PATIENT, settings_module.make())
    (tmp_path / "boundary.json").write_text(json.dumps(document))
    (tmp_path / "settings.json").write_text("{}")
    (tmp_path / spoilt).write_text(text)
    command = ["solve", "none.msh", "--settings", str(tmp_path / "settings.json"), "--out", str(tmp_path / "out")]
    command += ["--boundary", str(tmp_path / "boundary.json"), "--centreline", str(tmp_path / "centreline.vtp")]
    with pytest.raises(SystemExit) as ended:
        command_line.main(command)
    said = capsys.readouterr().err
    assert ended.value.code == 2 and spoilt in said, said


def test_a_probe_of_another_vessel_is_refused_before_anything_is_solved():
    probes = [{"name": "distal", "branch": "main", "point_mm": [12.0, 2.9, 0.0]}]
    ffr.check_probes(probes, _tree())
    probes[0]["point_mm"][1] = 3.1  # further than two radii, 3 mm, from the axis
    with pytest.raises(InputError, match="distal"):
        ffr.check_probes(probes, _tree())


def test_a_probe_in_metres_is_refused(settings):
    """Without a check it would move to the vessel's start, near the origin. Its s_mm tells that this is wrong."""
    document = boundary.make(_anatomy([{"branch": "main", "s_end_mm": 30.0}]), _tree(), PATIENT, settings)
    probe = document["probes"][0]
    ffr.check_probes([probe], _tree())
    reached = probe["s_mm"]
    for planned in (reached + 5.9, reached / 0.81, reached / 1.19):  # four radii are 6 mm, and a fifth of s_mm is more
        ffr.check_probes([probe | {"s_mm": planned}], _tree())
    for wrong in (
        {"point_mm": [1e-3 * x for x in probe["point_mm"]]},
        {"s_mm": reached / 0.79},
        {"s_mm": 0.79 * reached},
    ):
        with pytest.raises(InputError, match="another place along the vessel(.|\n)*distal"):
            ffr.check_probes([probe | wrong], _tree())
    near = {"name": "distal", "branch": "main", "point_mm": [12.0, 0.0, 0.0]}  # here four radii are the larger one
    ffr.check_probes([near | {"s_mm": 12 + 5.9}], _tree())
    with pytest.raises(InputError, match="another place along the vessel"):
        ffr.check_probes([near | {"s_mm": 12 + 6.1}], _tree())


def test_boundary_values_say_where_the_flow_is_from(settings):
    """They name the territory's share of the flow. Other plausible flows are given only for a real case."""
    patient = PATIENT | {"territory": "lad"}
    document = boundary.make(_anatomy(), _tree(), patient, settings, with_range=True)
    assert document["flow_source"] == {"territory": "lad", "share": pytest.approx(7 / 17), "by": "3.69 mL/min/g"}
    assert document["q_hyperaemic_m3_per_s"] * 6e7 == pytest.approx(3.69 * 150 * 7 / 17)
    assert {"mass -20 %", "hyperaemia +1 SD"} <= {one["what"] for one in document["plausible_flows"]}
    study = boundary.make(_anatomy(), _tree(), PATIENT, settings)
    assert study["flow_source"]["territory"] == "whole" and "plausible_flows" not in study

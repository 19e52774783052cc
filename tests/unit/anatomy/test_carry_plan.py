"""A plan is transferred to another segmentation of the same lumen. Devices keep their places in space, whatever the arc
length there."""

import csv
import json

import numpy as np
import pytest

from anatomy.planning.carry_plan import transferred_s_mm
from common.errors import InputError


def axis(s, turn=0.02, radius=1.5, aside=0.0):
    """Rows of sections along an arc of curvature `turn` at the arc lengths s (n,), `aside` mm off its plane."""
    s = np.asarray(s, float)
    points = np.stack([np.sin(turn * s) / turn, (1 - np.cos(turn * s)) / turn, np.full(s.shape, aside)], axis=1)
    return [
        {"s_mm": k, "x_mm": p[0], "y_mm": p[1], "z_mm": p[2], "inscribed_radius_mm": radius} for k, p in zip(s, points)
    ]


def started(rows, cut_mm):
    """The same axis that begins cut_mm further on."""
    return [row | {"s_mm": row["s_mm"] - cut_mm} for row in rows if row["s_mm"] >= cut_mm]


BEFORE = {"main": axis(np.arange(0.0, 40.1, 0.5))}


def test_a_reading_that_begins_later_has_smaller_arc_lengths():
    after = {"main": started(BEFORE["main"], 3.5)}
    assert transferred_s_mm("main", 20.2, BEFORE, after, "x") == pytest.approx(16.7, abs=1e-3)


def test_the_nearest_place_of_an_axis_beside_it():
    after = {"main": axis(np.arange(0.0, 40.1, 0.37), aside=0.4)}
    assert transferred_s_mm("main", 20.2, BEFORE, after, "x") == pytest.approx(20.2, abs=0.01)


def test_what_reaches_beyond_the_sections_stays():
    """Sections begin past the mouth; a device on a side branch may begin in the parent."""
    after = {"main": started(BEFORE["main"], 3.0)}
    before = {"main": started(BEFORE["main"], 5.0)}
    assert transferred_s_mm("main", -2.0, before, after, "x") == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("aside, within", [(1.45, True), (1.55, False)])
def test_an_axis_further_off_than_the_radius_is_refused(aside, within):
    after = {"main": axis(np.arange(0.0, 40.1, 0.5), aside=aside)}
    if within:
        assert transferred_s_mm("main", 20.0, BEFORE, after, "x") == pytest.approx(20.0, abs=1e-3)
        return
    with pytest.raises(InputError, match="(?s)lies off the other axis.*1.55 mm at 20.0 mm of main"):
        transferred_s_mm("main", 20.0, BEFORE, after, "x")


def test_a_branch_that_was_not_found_is_named():
    with pytest.raises(InputError, match="(?s)a treated branch is missing.*side1.*branches found: main"):
        transferred_s_mm("side1", 5.0, BEFORE, BEFORE, "x")


def test_the_command_moves_places_and_keeps_the_rest(run_module, tmp_path):
    for name, rows in (("before", BEFORE["main"]), ("after", started(BEFORE["main"], 3.5))):
        (tmp_path / name).mkdir()
        others = dict.fromkeys(
            "area_mm2 equivalent_diameter_mm min_diameter_mm max_diameter_mm reference_diameter_mm".split(), 1.0
        )
        table = [{"branch": "main", **row, **others, "curvature_per_mm": 0.0} for row in rows]
        with (tmp_path / name / "sections.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, list(table[0]))
            writer.writeheader()
            writer.writerows(table)
    use = {"device": "des", "branch": "main", "centre_s_mm": 20.0, "pressure_bar": 11}
    plan = {"schema": "vci-scene-1", "lumen": "a", "centreline": "b", "patient": {"map_pa": 1}}
    plan |= {"devices": {"des": {"kind": "stent", "length_mm": 18}}}
    plan |= {"segment": {"branch": "main", "s_start_mm": 11.0, "s_end_mm": 29.0}}
    plan |= {"procedure": [{"name": "stent", "action": "stent", "devices": [use]}]}
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    places = ["--from", tmp_path / "before", "--to", tmp_path / "after", "--out", tmp_path / "ct" / "plan.json"]
    made = run_module("anatomy", "carry-plan", tmp_path / "plan.json", *places)
    assert made.returncode == 0, made.stderr
    found = json.loads((tmp_path / "ct" / "plan.json").read_text())
    assert found["lumen"] == "../after/lumen.vtp" and found["centreline"] == "../after/centreline.vtp"
    assert found["segment"] == {"branch": "main", "s_start_mm": 7.5, "s_end_mm": 25.5}
    assert found["procedure"][0]["devices"] == [use | {"centre_s_mm": 16.5}]
    assert found["devices"] == plan["devices"] and found["patient"] == plan["patient"]
    (tmp_path / "plan.json").write_text(json.dumps({key: value for key, value in plan.items() if key != "segment"}))
    refused = run_module("anatomy", "carry-plan", tmp_path / "plan.json", *places)
    assert refused.returncode == 2 and "a plan without its treated segment" in refused.stderr

"""Plans are compared over one and the same stretch of the vessel, and an oversized one does not come first."""

import re
import types

import numpy as np
import pandas as pd
import pytest

from whatif import plans, risks


def test_areas_of_every_plan_are_measured_along_the_planned_segment(monkeypatch):
    planned = {"branch": "main", "s_start_mm": 10.0, "s_end_mm": 28.0}
    own = planned | {"s_start_mm": 14.0, "s_end_mm": 24.0}
    monkeypatch.setattr(plans, "read_summary", lambda folder: None)
    monkeypatch.setattr(plans, "procedure", lambda *given: {"segment": own, "devices": {}, "procedure": ["shorter"]})
    case = types.SimpleNamespace(scene={"segment": planned, "procedure": ["planned"], "wall": {}}, anatomy=lambda: None)
    scene = plans.scene_with_steps(case, {}, [])
    assert scene["segment"] == planned and scene["procedure"] == ["shorter"] and "wall" in scene


CHART = {"pressure_bar": [6, 12], "diameter_mm": [2.9, 3.2]}
DEVICES = {
    "own": {"kind": "balloon", "length_mm": 18.0, "chart": CHART},
    "des": {"kind": "stent", "length_mm": 18.0, "balloon": "own"},
    "post": {"kind": "balloon", "length_mm": 8.0, "chart": {"pressure_bar": [8, 16], "diameter_mm": [3.25, 3.45]}},
}


OVERSIZED = "oversized balloon"


def tapered(s_mm):
    """Sections of a vessel that tapers from 3.4 to 2.6 mm over 40 mm, as sections.csv has them."""
    s_mm = np.asarray(s_mm, float)
    return pd.DataFrame({"branch": "main", "s_mm": s_mm, "reference_diameter_mm": 3.4 - 0.02 * s_mm})


@pytest.mark.parametrize("place, healthy", [(10.0, 3.2), (30.0, 2.8), (39.9, 2.6 + 0.02 * 2.05)])
def test_a_balloon_is_compared_with_the_artery_along_it(place, healthy):
    use = {"device": "post", "branch": "main", "centre_s_mm": place, "pressure_bar": 12.0}
    ratio = risks.balloon_to_artery({"devices": DEVICES, "procedure": [{"devices": [use]}]}, tapered(np.arange(41)))
    assert ratio == pytest.approx(3.35 / healthy, rel=0.01)


def test_a_stent_counts_by_its_balloon_and_the_widest_inflation_decides():
    uses = [{"device": name, "branch": "main", "centre_s_mm": 20.0, "pressure_bar": 12.0} for name in ("des", "post")]
    both = [
        risks.balloon_to_artery({"devices": DEVICES, "procedure": [{"devices": u}]}, tapered([20]))
        for u in ([uses[0]], uses)
    ]
    assert both == pytest.approx([3.2 / 3.0, 3.35 / 3.0])
    assert risks.balloon_to_artery({"devices": DEVICES, "procedure": []}, tapered([20])) is None


def test_an_oversized_plan_comes_behind_those_that_fit_unless_they_are_worse():
    columns = ["plan", "ffr", "minimal_stent_area_mm2", "balloon_to_artery", "risks"]
    rows = [("larger", 0.90, 9.0, 1.2, OVERSIZED), ("planned", 0.90, 7.0, 1.1, ""), ("shorter", 0.89, 7.5, 0.9, "")]
    rows += [("worse", 0.80, 8.0, 1.0, ""), ("impossible", np.nan, np.nan, np.nan, np.nan)]
    ranked = plans.sort_by_rank(pd.DataFrame(rows, columns=columns), 0.01)
    assert list(ranked["plan"]) == ["shorter", "planned", "larger", "worse", "impossible"]
    assert list(ranked["rank"][:4]) == [1, 2, 3, 4] and ranked["rank"].isna().iloc[4]
    table = pd.DataFrame([rows[0], *rows[3:]], columns=columns)
    assert list(plans.sort_by_rank(table, 0.01)["plan"]) == ["larger", "worse", "impossible"]


def test_a_plan_of_two_risks_comes_behind_one_of_one_whatever_their_areas():
    columns = ["plan", "ffr", "minimal_stent_area_mm2", "balloon_to_artery", "risks"]
    rows = [("none", 0.90, 6.0, 1.0, ""), ("off", 0.90, 7.0, 1.0, "stent off the wall")]
    rows += [("both", 0.90, 9.0, 1.0, "stent not expanded; stent off the wall"), ("wide", 0.90, 8.0, 1.2, OVERSIZED)]
    ranked = plans.sort_by_rank(pd.DataFrame(rows, columns=columns), 0.01)
    assert list(ranked["plan"]) == ["none", "off", "wide", "both"]


@pytest.mark.parametrize(
    "values, words",
    [
        ((1.1, 0.6, 0.4), []),
        ((1.101, 0.6, 0.4), [OVERSIZED]),
        ((1.1, 0.599, 0.401), ["stent not expanded", "stent off the wall"]),
        ((None, None, None), []),
    ],
)
def test_a_value_at_its_limit_is_no_risk(values, words):
    assert risks.named(*values) == words


def test_the_limits_are_those_of_the_engines_warnings(repo_root):
    text = (repo_root / "vci" / "results" / "readouts.hpp").read_text()
    limits = [
        float(re.search(rf"double {name} = ([\d.]+);", text)[1])
        for name in ("least_expansion", "largest_malapposition")
    ]
    assert limits == [risks.LEAST_EXPANSION, risks.LARGEST_MALAPPOSITION_MM]


def test_where_every_plan_is_oversized_the_widest_comes_last():
    rows = [("larger", 0.90, 6.8, 1.33), ("planned", 0.90, 6.0, 1.24), ("smaller", 0.90, 5.2, 1.14)]
    columns = ["plan", "ffr", "minimal_stent_area_mm2", "balloon_to_artery"]
    ranked = plans.sort_by_rank(pd.DataFrame(rows, columns=columns).assign(risks=OVERSIZED), 0.01)
    assert list(ranked["plan"]) == ["smaller", "planned", "larger"]


def narrowed(area_mm2, branch="side1", start=3.0):
    """Sections of a side branch whose first mm after `start` has the area_mm2, and 3 mm2 beyond."""
    s_mm = start + np.arange(0.0, 10.0, 0.5)
    return pd.DataFrame({"branch": branch, "s_mm": s_mm, "area_mm2": np.where(s_mm < start + 1, area_mm2, 3.0)})


def test_the_mouth_of_a_side_branch_that_loses_most_counts():
    branches = [{"name": "main", "parent": None}, {"name": "side1", "parent": "main"}]
    branches += [{"name": "side2", "parent": "main"}, {"name": "lost", "parent": "main"}]
    before = pd.concat([narrowed(2.0), narrowed(2.5, "side2"), narrowed(2.0, "lost")])
    after = pd.concat([narrowed(1.5, start=3.4), narrowed(2.4, "side2"), tapered([0.0, 1.0]).assign(area_mm2=9.0)])
    assert risks.side_branch_loss(branches, before, after) == pytest.approx(25.0)
    assert risks.side_branch_loss(branches[:1], before, after) is None
    assert risks.side_branch_loss(branches[:2], before, narrowed(2.2)) == pytest.approx(-10.0), "wider than before"


def test_a_narrowing_far_from_the_mouth_does_not_count():
    branches = [{"name": "side1", "parent": "main"}]
    after = narrowed(2.0)
    after.loc[after["s_mm"] > 3.0 + risks.MOUTH_MM, "area_mm2"] = 0.5
    assert risks.side_branch_loss(branches, narrowed(2.0), after) == 0

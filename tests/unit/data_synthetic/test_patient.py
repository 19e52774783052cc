import pathlib

import pytest
import yaml

from common.errors import InputError
from data_synthetic import patient

ROOT = pathlib.Path(__file__).resolve().parents[3]


def side(**changes):
    return {"s_mm": 20, "diameter_mm": 1.5, "length_mm": 8, **changes}


def lesion(**changes):
    return {"centre_s_mm": 12, "length_mm": 8, "diameter_stenosis_percent": 60, **changes}


def test_the_small_vessel_is_accepted(vessel):
    patient.check(vessel(), "case.yaml")


@pytest.mark.parametrize(
    "changes, key",
    [
        ({"side_branches": [side(s_mm=29)]}, "vessel.side_branches[1].s_mm"),
        ({"side_branches": [side(s_mm=1)]}, "vessel.side_branches[1].s_mm"),
        ({"side_branches": [side(diameter_mm=3.4)]}, "vessel.side_branches[1].diameter_mm"),
        ({"side_branches": [side(length_mm=14)]}, "vessel.side_branches[1].length_mm"),
        ({"side_branches": [side(length_mm=4)]}, "vessel.side_branches[1].length_mm"),
        (
            {"side_branches": [side(s_mm=s, diameter_mm=2.2) for s in (12, 14, 16, 18)]},
            "vessel.side_branches",
        ),
        ({"lesions": [lesion(centre_s_mm=28)]}, "vessel.lesions[1].centre_s_mm"),
        ({"lesions": [lesion(centre_s_mm=4)]}, "vessel.lesions[1].centre_s_mm"),
        ({"lesions": [lesion(branch="side2", centre_s_mm=4)]}, "vessel.lesions[1].branch"),
        (
            {"lesions": [lesion(calcium={"arc_deg": 90, "length_mm": 9, "direction_deg": 0})]},
            "vessel.lesions[1].calcium.length_mm",
        ),
        (
            {"main": {"length_mm": 30, "ostial_diameter_mm": 3.4, "mean_curvature_per_mm": 0.2}},
            "vessel.main.mean_curvature_per_mm",
        ),
        (
            {"main": {"length_mm": 130, "ostial_diameter_mm": 3.4, "taper_percent_per_cm": 15}},
            "vessel.main.taper_percent_per_cm",
        ),
        (
            {"side_branches": [side(s_mm=18, diameter_mm=0.8, length_mm=10, taper_percent_per_cm=40)]},
            "vessel.side_branches[1].taper_percent_per_cm",
        ),
    ],
)
def test_an_impossible_vessel_is_refused_by_its_key(vessel, changes, key):
    with pytest.raises(InputError) as caught:
        patient.check(vessel(**changes), "case.yaml")
    assert caught.value.where.startswith(f"case.yaml: {key}")


def test_lesions_may_overlap_only_where_the_lumen_shifts_alike(vessel):
    """Otherwise the axis would jump. The tree would be refused for sharp bends, whatever its seed."""
    first = lesion(centre_s_mm=10, eccentricity=0.4, direction_deg=30)
    for second in (lesion(centre_s_mm=14, eccentricity=0.4, direction_deg=390), lesion(centre_s_mm=18.1)):
        patient.check(vessel(lesions=[first, second], side_branches=[]), "case.yaml")
    for change in ({"eccentricity": 0.3, "direction_deg": 30}, {"eccentricity": 0.4, "direction_deg": 31}, {}):
        with pytest.raises(InputError, match="overlaps another") as caught:
            patient.check(vessel(lesions=[first, lesion(centre_s_mm=14, **change)], side_branches=[]), "case.yaml")
        assert caught.value.where == "case.yaml: vessel.lesions[2].centre_s_mm"
    concentric = [lesion(centre_s_mm=10, direction_deg=30), lesion(centre_s_mm=14)]
    patient.check(vessel(lesions=concentric, side_branches=[]), "case.yaml")


@pytest.mark.parametrize(
    "path, value",
    [
        (("seed",), "seven"),
        (("main", "ostial_diameter_mm"), -3.2),
        (("lesions", 0, "diameter_stenosis_percent"), 99),
        (("main", "max_curvature_per_mm"), 0.5),
        (("side_branches", 0, "diametre_mm"), 2),
    ],
)
def test_a_value_off_the_schema_is_refused_by_its_key(tmp_path, path, value):
    case = yaml.safe_load((ROOT / "config/cases/quick_focal.yaml").read_text())
    at = case["vessel"]
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    file = tmp_path / "broken.yaml"
    file.write_text(yaml.safe_dump(case))
    with pytest.raises(InputError) as caught:
        patient.load(file)
    assert str(path[-1]) in str(caught.value)


def test_a_surface_case_is_refused(tmp_path):
    with pytest.raises(InputError, match="not a synthetic case"):
        patient.load(ROOT / "config/cases/real_artery.yaml")


@pytest.mark.parametrize("case", ["quick_focal", "quick_branch", "lad01", "rca01", "lcx01"])
def test_shipped_cases_are_possible(case):
    patient.load(ROOT / f"config/cases/{case}.yaml")

"""The shipped cohorts: nine patients that spread like the published ones, hard anatomies, and random patients.

FFR is from the one-dimensional network on the true radii, without meshing or solving in three dimensions.
"""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from common.patient.blood_pressure import mean_arterial_pressure_mmhg
from common.documents import config, schema
from data_synthetic import draw, patient, tree
from flow import settings
from flow.inputs import boundary, hyperaemia
from flow.reduced import network as network_model

PA_PER_MMHG = 133.322


def network_ffr(case, branches):
    """FFR behind the main branch's most severe lesion, from the true radii. Boundary values and the probe's distance
    are those of the flow part."""
    flow = settings.make()
    probe_mm = case.get("settings", {}).get("flow", {}).get("probe_distance_mm", flow.probe_distance_mm)
    tables = []
    for branch in branches:
        s = np.arange(0, branch.axis.length_mm, 0.25)
        tables.append(pd.DataFrame({"branch": branch.name, "s_mm": s, "area_mm2": np.pi * branch.radius(s) ** 2}))
    names = [{"name": b.name, "parent": b.parent or None, "s_on_parent_mm": b.s_on_parent_mm} for b in branches]
    map_pa = PA_PER_MMHG * mean_arterial_pressure_mmhg(case["patient"]["sbp_mmhg"], case["patient"]["dbp_mmhg"])
    venous_pa = PA_PER_MMHG * flow.venous_pressure_mmhg
    total = hyperaemia.flow_of_mass(case["patient"]["lvm_g"], flow.hyperaemia_fraction)
    ends = [2 * float(branch.radius(branch.axis.length_mm)) for branch in branches]
    shares = boundary.split_by_diameter(ends, flow.split_exponent)
    document = {"map_pa": map_pa, "venous_pressure_pa": venous_pa, "density_kg_per_m3": flow.density_kg_per_m3}
    document["viscosity_pa_s"] = flow.viscosity_pa_s
    document["outlets"] = [
        {"name": branch.name, "branch": branch.name, "resistance_pa_s_per_m3": (map_pa - venous_pa) / (share * total)}
        for branch, share in zip(branches, shares)
    ]
    network = network_model.Network({"branches": names}, pd.concat(tables), document, flow.expansion_loss)
    s, pressure = network.pressures(network.solve())["main"]
    lesion = max(case["vessel"]["lesions"], key=lambda le: le["diameter_stenosis_percent"])
    at = min(lesion["centre_s_mm"] + 0.5 * lesion["length_mm"] + probe_mm, branches[0].axis.length_mm - 4)
    return float(np.interp(at * 1e-3, s, pressure)) / map_pa


def treated_lesions(case):
    """The lesions of the main branch whose middle a stent covers. For a plan `auto`: the first lesion."""
    lesions = case["vessel"]["lesions"]
    if case["plan"] == "auto":
        return lesions[:1]
    found = []
    for lesion in lesions:
        for step in case["plan"]:
            for device in step["devices"]:
                at = device.get("centre_s_mm", lesions[device.get("lesion", 1) - 1]["centre_s_mm"])
                covers = abs(at - lesion["centre_s_mm"]) < 0.5 * device["length_mm"]
                if step["action"] == "stent" and covers and lesion not in found:
                    found.append(lesion)
    return found


def treated_branches(branches, lesions):
    """The branches after ideal stenting: the main branch has its healthy radius all along the given lesions."""
    main = branches[0]
    radius = main.radius_mm.copy()
    for lesion in lesions:
        inside = np.abs(main.axis.s_mm - lesion["centre_s_mm"]) < 0.5 * lesion["length_mm"] + 1
        radius[inside] = main.healthy_radius_mm[inside]
    return [dataclasses.replace(main, radius_mm=radius), *branches[1:]]


def cases_of(repo_root, cohort):
    names = config.load_study(repo_root / "config" / "study.yaml")["cohorts"][cohort]
    return {name: patient.load(repo_root / "config" / "cases" / f"{name}.yaml") for name in names}


def stenosis_share(lesion, s_mm):
    """Share of the diameter that a cosine lesion takes at a place."""
    offset = 2 * abs(s_mm - lesion["centre_s_mm"]) / lesion["length_mm"]
    return 0.005 * lesion["diameter_stenosis_percent"] * (1 + np.cos(np.pi * min(offset, 1)))


def test_nine_patients_spread_like_the_published_ones(repo_root):
    """Published: FFR below .80 before, .90 (.08) or .92 (.09) after; area after 16.4 (4.4) or 17.9 (4.8) mm2.

    The limits here differ from these for two reasons. The area is a little less than that of the widest balloon, which
    is checked instead. The network has a smaller pressure loss than the flow in three dimensions. Curvature is .15
    (.04) or .17 (.03) /mm after. Before, it is checked to be a fifth to a third larger, which the two models take away.
    """
    cases = cases_of(repo_root, "nine")
    assert len(cases) == 9
    after, widest, unprepared, bifurcations, calcified, two, curvature = [], [], [], [], [], [], []
    for name, case in cases.items():
        branches = tree.grow(case["vessel"], name)
        lesions = treated_lesions(case)
        assert 0.65 < network_ffr(case, branches) < 0.78, name
        after.append(network_ffr(case, treated_branches(branches, lesions)))
        lesion = lesions[0]
        reach = 0.5 * lesion["length_mm"] + 2.5
        place = np.linspace(lesion["centre_s_mm"] - reach, lesion["centre_s_mm"] + reach, 80)
        curvature.append(branches[0].axis.curvature(place).mean())
        assert 0.1 <= curvature[-1] <= 0.25, name
        mouths = [side["s_mm"] for side in case["vessel"]["side_branches"]]
        bifurcations += [name] if any(stenosis_share(lesion, s) > 0.4 for s in mouths) else []
        calcified += [name] if lesion.get("calcium", {}).get("arc_deg", 0) > 180 else []
        two += [name] if len(lesions) == 2 else []
        if case["plan"] != "auto":
            unprepared += [] if "predilatation" in [step["action"] for step in case["plan"]] else [name]
            balloons = [device["diameter_mm"] for step in case["plan"] for device in step["devices"]]
            widest.append(np.pi / 4 * max(balloons) ** 2)
    assert np.mean(after) == pytest.approx(0.93, abs=0.02) and 0.03 < np.std(after, ddof=1) < 0.06
    assert 0.18 < np.mean(curvature) < 0.22 and 0.02 < np.std(curvature, ddof=1) < 0.05
    assert min(after) < 0.87 and max(after) > 0.98
    assert 15 < np.mean(widest) < 20 and 3.5 < np.std(widest, ddof=1) < 6
    assert [len(names) for names in (unprepared, bifurcations, calcified, two)] == [2, 2, 1, 1]


def test_hard_anatomies_can_be_grown(repo_root):
    cases = cases_of(repo_root, "hard")
    assert len(cases) >= 8 and "culotte_bench" in cases
    for name, case in cases.items():
        assert tree.grow(case["vessel"], name), name
    worst = max(le["diameter_stenosis_percent"] for case in cases.values() for le in case["vessel"]["lesions"])
    assert worst > 80


@pytest.mark.slow
def test_random_patients_have_lesions_of_every_grade():
    found = []
    for number in range(1, 21):
        case = draw.draw_patient(11, number)
        case = {**case, "vessel": schema.with_defaults(case["vessel"], schema.read("vessel"))}
        found.append(network_ffr(case, tree.grow(case["vessel"])))
    assert 0.3 < np.mean(np.array(found) < 0.8) < 0.8
    assert 0.4 < min(found) < max(found) < 0.97
    assert np.mean(found) == pytest.approx(0.79, abs=0.08)

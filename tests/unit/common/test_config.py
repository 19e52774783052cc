"""Cases, devices and the study: what the schemas cannot say."""

import shutil

import pytest
import yaml

from common.documents import config
from common.errors import InputError


@pytest.fixture
def edited(repo_root, tmp_path):
    """edited("devices/des.yaml", {"diameters_mm": [...]}) -> a copy of config/ with the keys of one file replaced."""

    def edit(name, changes):
        folder = tmp_path / "config"
        shutil.copytree(repo_root / "config", folder, dirs_exist_ok=True)
        file = folder / name
        file.write_text(yaml.safe_dump({**yaml.safe_load(file.read_text()), **changes}))
        return folder

    return edit


def test_shipped_catalogue(repo_root):
    families = config.load_devices(repo_root / "config" / "devices")
    assert {"semi_compliant", "non_compliant", "des", "des_balloon"} <= set(families)
    for family in families.values():
        if family["kind"] == "balloon":
            chart = dict(zip(family["chart"]["pressure_bar"], family["chart"]["diameter_percent"]))
            assert chart[family["nominal_pressure_bar"]] == 100


def test_semi_compliant_grows_more_than_non_compliant(repo_root):
    """Growth from nominal to rated burst pressure: 5-10 % against at most 4 %."""
    growth = {}
    for name in ("semi_compliant", "non_compliant"):
        family = config.load_device(repo_root / "config" / "devices" / f"{name}.yaml")
        chart = dict(zip(family["chart"]["pressure_bar"], family["chart"]["diameter_percent"]))
        growth[name] = chart[family["rated_burst_pressure_bar"]] - 100
    assert 5 <= growth["semi_compliant"] <= 10
    assert 1 <= growth["non_compliant"] <= 4


def test_settings_of_a_case_lie_over_those_of_the_study(repo_root):
    study = config.load_study(repo_root / "config" / "study.yaml")
    case = {"settings": {"deployment": {"wall": {"plaque": {"lipid": {"hardening": 0.5}}}}}}
    resolved = config.resolve_settings(study, case)
    lipid = resolved["deployment"]["wall"]["plaque"]["lipid"]
    assert lipid == {**study["deployment"]["wall"]["plaque"]["lipid"], "hardening": 0.5}
    assert resolved["flow"] == study["flow"]
    assert study["deployment"]["wall"]["plaque"]["lipid"]["hardening"] != 0.5


@pytest.mark.parametrize(
    "name, changes, words",
    [
        ("des.yaml", {"delivery_balloon": "semi"}, ["delivery_balloon", "semi", "known balloons"]),
        ("des.yaml", {"lengths_mm": [8, 12, 99]}, ["lengths_mm", "at most 60"]),
        ("des.yaml", {"lengths_mm": [8, 13]}, ["lengths_mm", "13", "des_balloon"]),
        ("des.yaml", {"diameters_mm": [3.0, 2.5]}, ["diameters_mm", "rise"]),
        ("des.yaml", {"diameters_mm": [2.25, 5.0]}, ["designs", "cover"]),
        ("semi_compliant.yaml", {"rated_burst_pressure_bar": 7}, ["rated_burst_pressure_bar", "7"]),
        ("semi_compliant.yaml", {"crimped_diameter_mm": 1.6}, ["crimped_diameter_mm", "1.6"]),
        (
            "semi_compliant.yaml",
            {"chart": {"pressure_bar": [4, 8, 18], "diameter_percent": [95, 100]}},
            ["chart.diameter_percent", "at least 3"],
        ),
        (
            "semi_compliant.yaml",
            {"chart": {"pressure_bar": [4, 8, 18], "diameter_percent": [95, 100, 99]}},
            ["chart.diameter_percent", "rise"],
        ),
        (
            "semi_compliant.yaml",
            {"chart": {"pressure_bar": [4, 8, 16, 18], "diameter_percent": [95, 100, 110]}},
            ["chart.diameter_percent", "length"],
        ),
    ],
)
def test_refused_devices(edited, name, changes, words):
    folder = edited(f"devices/{name}", changes)
    with pytest.raises(InputError) as error:
        config.load_devices(folder / "devices")
    for word in [name, *words]:
        assert word in str(error.value)


@pytest.mark.parametrize(
    "device, words",
    [
        ({"lesion": 1, "centre_s_mm": 3.0}, ["plan[1].devices[1]", "either centre_s_mm or lesion"]),
        ({}, ["plan[1].devices[1]", "either centre_s_mm or lesion"]),
        ({"lesion": 1, "branch": "left"}, ["plan[1].devices[1].branch", "left"]),
        ({"lesion": 0}, ["plan[1].devices[1].lesion", "at least 1"]),
    ],
)
def test_refused_placements(edited, device, words):
    balloon = {"device": "semi_compliant", "diameter_mm": 2.5, "length_mm": 12, "pressure_bar": 10, **device}
    plan = [{"action": "predilatation", "devices": [balloon]}]
    folder = edited("cases/real_artery.yaml", {"plan": plan})
    with pytest.raises(InputError) as error:
        config.load_case(folder / "cases" / "real_artery.yaml")
    for word in words:
        assert word in str(error.value)


@pytest.mark.parametrize("sbp, dbp", [(80, 120), (90, 90)])
def test_blood_pressures_that_are_swapped_or_equal(edited, sbp, dbp):
    folder = edited("cases/real_artery.yaml", {"patient": {"lvm_g": 150, "sbp_mmhg": sbp, "dbp_mmhg": dbp}})
    with pytest.raises(InputError, match=rf"key patient.dbp_mmhg\n.*{dbp}\n.*sbp_mmhg: {sbp}; are they swapped"):
        config.load_case(folder / "cases" / "real_artery.yaml")


@pytest.mark.parametrize(
    "flow, refused",
    [
        ({}, "lvm_g is missing"),
        ({"cardiac_output_l_per_min": 5}, "shared out by territory"),
        ({"cardiac_output_l_per_min": 5, "territory": "left"}, None),
        ({"hyperaemic_inflow_ml_per_min": 140}, None),
        ({"hyperaemic_inflow_ml_per_min": 140, "cardiac_output_l_per_min": 5}, None),
        ({"hyperaemic_inflow_ml_per_min": 10}, None),
        ({"hyperaemic_inflow_ml_per_min": 2.3}, "too small(.|\n)*give mL/min; if it is in mL/s, that is 138$"),
        ({"hyperaemic_inflow_ml_per_min": 0.15}, "too small(.|\n)*give mL/min; if it is in L/min, that is 150"),
        ({"hyperaemic_inflow_ml_per_min": 0.001}, "too small(.|\n)*give mL/min$"),
        ({"lvm_g": 150, "territory": 0.3}, None),
        (
            {"lvm_g": 150, "territory": "lm"},
            "lm\n.*one of whole, .* or a number at least 0.02 at most 1: the territory",
        ),
        ({"lvm_g": 150, "territory": 30}, "30\n.*one of whole, .* or a number at least 0.02 at most 1: the territory"),
    ],
)
def test_what_tells_the_flow(edited, flow, refused):
    folder = edited("cases/real_artery.yaml", {"patient": {**flow, "sbp_mmhg": 120, "dbp_mmhg": 80}})
    if refused is None:
        assert config.load_case(folder / "cases" / "real_artery.yaml")["patient"].items() >= flow.items()
        return
    with pytest.raises(InputError, match=refused):
        config.load_case(folder / "cases" / "real_artery.yaml")


@pytest.mark.parametrize(
    "plan, refused",
    [
        ({"treat": "all"}, None),
        ({"treat": "culprit", "least_stenosis_percent": 1}, None),
        ({"treat": "culprit", "least_stenosis_percent": 0.5}, "at least 1"),
        ({"treat": "some"}, "some"),
        ({}, "treat"),
    ],
)
def test_proposed_plans(edited, plan, refused):
    folder = edited("cases/real_artery.yaml", {"plan": plan})
    if refused is None:
        assert config.load_case(folder / "cases" / "real_artery.yaml")["plan"] == plan
        assert config.listed_steps(plan) == []
        return
    with pytest.raises(InputError, match=refused):
        config.load_case(folder / "cases" / "real_artery.yaml")


def test_vessel_and_lumen_exclude_each_other(edited):
    folder = edited("cases/real_artery.yaml", {"vessel": {"seed": 1}})
    with pytest.raises(InputError, match="key has no place here\n.*key vessel"):
        config.load_case(folder / "cases" / "real_artery.yaml")
    folder = edited("cases/real_artery.yaml", {"kind": "synthetic"})
    with pytest.raises(InputError, match="vessel is missing|lumen"):
        config.load_case(folder / "cases" / "real_artery.yaml")


@pytest.mark.parametrize(
    "lumen, expected",
    [
        ("{units: mm}", "path, contours"),
        ("{units: mm, path: a.stl, contours: {lumen: b.csv}}", "path, contours"),
        ("{units: mm, contours: {lumen: b.csv}, inlet_point_mm: [0, 0, 0]}", "lumen.inlet_point_mm"),
        ("{units: mm, contours: {lumn: b.csv}}", "lumen.contours.lumn"),
        ("{units: cm, ct: {path: a.nii, inlet_mm: [0, 0, 0], outlets_mm: [[9, 0, 0]]}}", "lumen.units"),
        ("{units: mm, ct: {path: a.nii, inlet_mm: [0, 0, 0], outlets_mm: [[9, 0, 0]]}, label: 1}", "lumen.label"),
        ("{units: mm, ct: {path: a.nii, inlet_mm: [0, 0, 0]}}", "outlets_mm"),
    ],
)
def test_a_lumen_is_given_in_one_way(tmp_path, lumen, expected):
    text = "kind: surface\ndescription: x\npatient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}\nlumen: "
    path = tmp_path / "own.yaml"
    path.write_text(text + lumen + "\n")
    with pytest.raises(InputError, match=expected):
        config.load_case(path)
    path.write_text(text + "{units: mm, contours: {lumen: b.csv}, cut_points_mm: [[0, 0, 3]]}\n")
    assert config.load_case(path)["lumen"]["contours"]["z_from"] == "distal"


POST = {"path": "data/after.stl", "units": "cm", "outlet_points_mm": [[1.0, 2.0, 3.0]]}
MEASURED = {"ffr_pre": 0.71, "ffr_post": 0.9, "probe": {"branch": "side1", "s_mm": 12.5}}


def real_case(edited, **changes):
    """The shipped case of a real artery, read with some keys changed."""
    return config.load_case(edited("cases/real_artery.yaml", changes) / "cases" / "real_artery.yaml")


def test_the_truth_of_a_real_patient_is_taken(edited):
    """A post lumen takes every key of `lumen`; flow is compared unless areas are asked for; a probe may be a point."""
    pair = {"pre_mm": [1, 2, 3], "post_mm": [4, 5, 6]}
    case = real_case(edited, post=POST, measured=MEASURED, registration={"landmarks": [pair]})
    assert case["post"] == POST and case["measured"] == MEASURED
    assert case["registration"] == {"landmarks": [pair], "compare": "flow"}
    only = real_case(edited, measured={"ffr_post": 0.92, "probe": {"point_mm": [1, 2, 3]}})
    assert "post" not in only and only["measured"]["probe"] == {"point_mm": [1, 2, 3]}


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"post": {"path": "data/after.stl"}}, ["post", "units is missing"]),
        ({"registration": {"compare": "areas"}}, ["registration", "nothing to register", "give `post`"]),
        ({"post": POST, "registration": {"compare": "ffr"}}, ["registration.compare", "flow, areas"]),
        ({"measured": {"probe": {"branch": "main", "s_mm": 3.0}}}, ["measured", "ffr_pre"]),
        ({"measured": {"ffr_pre": 71, "probe": {"point_mm": [1, 2, 3]}}}, ["measured.ffr_pre", "at most 1.05"]),
        ({"measured": {"ffr_pre": 0.71}}, ["measured", "probe is missing"]),
        ({"measured": {"ffr_pre": 0.71, "probe": {"branch": "main"}}}, ["measured.probe", "s_mm is missing"]),
        ({"kind": "synthetic", "post": POST}, ["post", "no place here"]),
    ],
)
def test_a_truth_that_cannot_be_used_is_refused(edited, changes, words):
    if changes.get("kind") == "synthetic":
        folder, name = edited("cases/quick_focal.yaml", changes), "quick_focal"
    else:
        folder, name = edited("cases/real_artery.yaml", changes), "real_artery"
    with pytest.raises(InputError) as error:
        config.load_case(folder / "cases" / f"{name}.yaml")
    for word in words:
        assert word in str(error.value), str(error.value)

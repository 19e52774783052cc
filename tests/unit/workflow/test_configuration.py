"""The whole configuration: every kind of bad value is refused with file, key, value and what is allowed."""

import json
import re
import shlex
import shutil
from types import SimpleNamespace

import pytest

from anatomy.__main__ import _parser as anatomy_parser
from common.errors import InputError
from workflow import provenance
from workflow.__main__ import run_provenance, run_validate
from workflow.configuration import Configuration
from workflow.inputs import Inputs

STUDY, DEVICE, CASE = "study.yaml", "devices/semi_compliant.yaml", "cases/quick_focal.yaml"


@pytest.fixture
def folder(repo_root, tmp_path):
    """A copy of config/ to spoil."""
    shutil.copytree(repo_root / "config", tmp_path / "config")
    return tmp_path / "config"


SECOND_DEVICE = (
    "\n      - {device: non_compliant, diameter_mm: 2.75, length_mm: 15, branch: main, lesion: 1, pressure_bar: 14}"
)
TWO_DEVICES = "pressure_bar: 16}" + SECOND_DEVICE


def edit(file, old, new):
    """Replaces text that must be there."""
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    "file, old, new, expected",
    [
        (CASE, "lvm_g: 130", "lvm_g: -130", ["patient.lvm_g", "-130", "at least 30"]),
        (CASE, "lvm_g: 130", "lvm_g: heavy", ["patient.lvm_g", "heavy", "a number"]),
        (CASE, "lvm_g: 130", "lvm: 130", ["patient.lvm", "did you mean lvm_g?"]),
        (CASE, "lvm_g: 130, ", "", ["lvm_g is missing", "left ventricular mass"]),
        (CASE, "kind: synthetic", "kind: synthetic\nkind: synthetic", ["key given twice", "line 2"]),
        (CASE, "seed: 4", "seed: 4.5", ["vessel.seed", "4.5", "a whole number"]),
        (CASE, "ostial_diameter_mm: 2.9", "ostial_diameter_mm: -2.9", ["vessel.main.ostial_diameter_mm", "-2.9"]),
        (CASE, "device: des,", "device: dess,", ["plan[2].devices[1].device", "dess", "des"]),
        (CASE, "length_mm: 18", "length_mm: 16", ["plan[2].devices[1].length_mm", "16", "15, 18"]),
        (CASE, "pressure_bar: 16", "pressure_bar: 26", ["plan[3].devices[1].pressure_bar", "26", "at most 20"]),
        (CASE, "action: postdilatation", "action: kissing", ["plan[3].devices", "kissing inflates two balloons"]),
        (CASE, "pressure_bar: 16}", TWO_DEVICES, ["plan[3].devices", "only kissing inflates two devices at once"]),
        (CASE, "pressure_bar: 16}", TWO_DEVICES + SECOND_DEVICE, ["plan[3].devices", "at most 2"]),
        (DEVICE, "nominal_pressure_bar: 8", "nominal_pressure_bar: 7", ["chart", "100 at 7 bar"]),
        (DEVICE, "shoulder_mm: 2.0", "shoulder_mm: .nan", ["shoulder_mm", "not finite"]),
        (DEVICE, "kind: balloon", "kind: ballon", ["kind", "ballon", "one of balloon, stent"]),
        (STUDY, "quick_focal", "quick_fokal", ["cohorts.quick[1]", "quick_fokal", "quick_focal"]),
        (STUDY, "cohorts:", "flow: {density_kg_per_m3: 1.06}\ncohorts:", ["flow.density_kg_per_m3", "1.06", "900"]),
        (CASE, "settings:", "settings:\n  flow: {viscosity_time_s: 2}", ["viscosity_time_s", "2", "viscosity_model"]),
        (CASE, "settings:", "settings:\n  flow: {coarse_rings: [3]}", ["two coarser meshes", "coarse_rings", "[3]"]),
        (CASE, "settings:", "settings:\n  flow: {coarse_rings: [3, 2]}", ["not coarser", "[3, 2]"]),
        (CASE, "settings:", "settings:\n  flow: {coarse_rings: 2}", ["coarse_rings", "not allowed"]),
        (STUDY, "cohorts:", "flow: [1\ncohorts:", ["not valid YAML", "study.yaml, line"]),
    ],
)
def test_refused(folder, file, old, new, expected):
    edit(folder / file, old, new)
    with pytest.raises(InputError) as error:
        Configuration(folder)
    for words in [file, *expected]:
        assert words in str(error.value), str(error.value)


@pytest.mark.parametrize("name, text", [("mine", "kind: synthetic\nnonsense: 3\n"), ("Mine", "kind: synthetic\n")])
def test_a_bad_case_is_left_out_where_asked(folder, name, text):
    (folder / "cases" / f"{name}.yaml").write_text(text)
    with pytest.raises(InputError):
        Configuration(folder)
    found = Configuration(folder, leave_out_bad_cases=True)
    assert list(found.refused) == [name] and name not in found.cases
    assert found.selected_cases("quick") == ["quick_focal", "quick_branch"]
    with pytest.raises(InputError, match=name):
        found.selected_cases("quick", name)


def test_the_record_of_a_study_needs_no_other_case(folder, monkeypatch):
    (folder / "cases" / "mine.yaml").write_text("kind: synthetic\nnonsense: 3\n")
    refused = []
    monkeypatch.setattr(provenance, "write_provenance", lambda study, *others: refused.extend(study.refused))
    unused = dict.fromkeys(("cases", "results", "programs", "software", "out"))
    run_provenance(SimpleNamespace(folder=folder, **unused))
    assert refused == ["mine"]


def test_shipped_configuration_is_valid(folder):
    found = Configuration(folder)
    assert found.selected_cases("quick") == ["quick_focal", "quick_branch"]
    assert found.selected_cases("quick", "lad01, rca01") == ["lad01", "rca01"]
    assert found.selected_cases("quick", "rca01 lad01 rca01") == ["rca01", "lad01"], "no case counts twice"


def test_unusual_values_of_a_patient_are_said(folder, capsys):
    run_validate(SimpleNamespace(folder=folder))
    assert "warning" not in capsys.readouterr().err
    readings = "measured: {ffr_pre: 0.92, ffr_post: 0.71, probe: {branch: main, s_mm: 4}}\n"
    with (folder / "cases" / "real_artery.yaml").open("a") as file:
        file.write(readings)
    run_validate(SimpleNamespace(folder=folder))
    assert "real_artery.yaml: measured.ffr_post, 0.71, is below" in capsys.readouterr().err


def test_a_setting_that_does_not_act_for_a_territory_is_said(folder, capsys):
    file = folder / "cases" / "real_artery.yaml"
    case = file.read_text() + "settings: {flow: {hyperaemia_fraction: 0.32}}\n"
    for territory, said in (("whole", False), ("lad", True)):
        file.write_text(case.replace("dbp_mmhg: 80}", f"dbp_mmhg: 80, territory: {territory}}}"))
        run_validate(SimpleNamespace(folder=folder))
        assert ("settings.flow.hyperaemia_fraction is 0.32: not used" in capsys.readouterr().err) == said


def test_make_help_lists_the_shipped_cohorts(folder, repo_root):
    listed = re.search(r"COHORT=([a-z|]+)\)", (repo_root / "Makefile").read_text()).group(1).split("|")
    assert sorted(listed) == sorted(Configuration(folder).study["cohorts"])


def test_unknown_cohort_and_case(folder):
    found = Configuration(folder)
    with pytest.raises(InputError, match="one of nine, three, quick"):
        found.selected_cases("small")
    with pytest.raises(InputError, match="lad99"):
        found.selected_cases("quick", "lad99")


@pytest.mark.parametrize("name", ["cases/My case.yaml", "cases/Mine.yaml", "cases/mine.yml", "devices/mine.yml"])
def test_files_that_would_not_be_found(folder, name):
    shutil.copy(folder / CASE, folder / name)
    with pytest.raises(InputError, match="rename it"):
        Configuration(folder)


def test_surface_is_looked_for_in_the_data_folder(folder, tmp_path):
    with pytest.raises(InputError, match="VCI_DATA_DIR"):
        Configuration(folder, tmp_path).selected_cases("real", "real_artery")
    (tmp_path / "dfemtoolz_case4_artery.stl").write_text("solid")
    assert Configuration(folder, tmp_path).selected_cases("real", "real_artery") == ["real_artery"]
    assert Configuration(folder, tmp_path).lumen_file("real_artery") == str(tmp_path / "dfemtoolz_case4_artery.stl")


def test_contour_tables_are_looked_for_as_surfaces_are(folder, tmp_path):
    text = (folder / "cases/ivus_plaque.yaml").read_text()
    (folder / "cases/own.yaml").write_text(text.replace("config/patients/ivus_plaque/", "data/own/"))
    with pytest.raises(InputError, match="lumen.contours.lumen"):
        Configuration(folder, tmp_path).selected_cases("real", "own")
    (tmp_path / "own").mkdir()
    for name in ("lumen", "outer_wall", "calcium", "branches"):
        (tmp_path / "own" / f"{name}.csv").write_text("1,2,3,4")
    found = Configuration(folder, tmp_path)
    assert found.selected_cases("real", "own") == ["own"]
    assert found.contour_files("own")["calcium"] == str(tmp_path / "own" / "calcium.csv")
    assert found.contour_files("real_artery") == {}


def test_every_key_of_contours_reaches_the_command(folder, tmp_path):
    for name in ("lumen", "outer_wall", "marks", "line"):
        (tmp_path / f"{name}.csv").write_text("1,2,3,4")
    case = """
kind: surface
description: a pull-back
patient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}
lumen:
  units: cm
  extend_outlets_radii: 4
  contours:
    lumen: data/lumen.csv
    outer_wall: data/outer_wall.csv
    landmarks: data/marks.csv
    z_from: proximal
    z_range_mm: [1, 20]
    drop_frames: [4, 7]
    healthy_wall_mm: 0.2
    centreline: {path: data/line.csv, units: m, line: 2, landmark_points_mm: [[-1, 2, 3]], mirrored: true}
"""
    (folder / "cases/own.yaml").write_text(case)
    inputs = Inputs(Configuration(folder, tmp_path))
    wildcards = SimpleNamespace(case="own")
    command = shlex.split(inputs.contour_options(wildcards))
    assert set(inputs.cases_from_contours()) == {"ivus_plaque", "ivus_stent", "own"}
    assert inputs.cases_from_contours("post") == ["ivus_stent"]
    options = anatomy_parser().parse_args(["contours", *command, "--out", "x"])
    assert str(options.lumen) == str(tmp_path / "lumen.csv") and options.units == "cm" and options.z_from == "proximal"
    assert options.z_range == [1, 20] and options.drop_frame == [4, 7] and options.healthy_wall == "0.2"
    assert options.line == 2 and options.centreline_units == "m" and options.mirrored
    assert options.landmark_point == [[-1, 2, 3]] and options.landmarks == tmp_path / "marks.csv"
    assert inputs.lumen_file(wildcards).endswith("own/source/lumen.vtp")
    assert inputs.lumen_options(wildcards) == "--units mm --extend-outlets 4"


def test_the_tree_of_an_aorta_reaches_the_command(folder, tmp_path):
    case = """
kind: surface
description: an aorta
patient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}
lumen: {path: data/aorta.stl, units: cm, tree: left, ostium_point_mm: [-1, 2, 3.5]}
"""
    (tmp_path / "aorta.stl").write_text("solid")
    (folder / "cases/own.yaml").write_text(case)
    inputs = Inputs(Configuration(folder, tmp_path))
    assert inputs.lumen_options(SimpleNamespace(case="own")) == "--units cm --tree left --ostium -1,2,3.5"
    edit(folder / "cases/own.yaml", "tree: left", "tree: lft")
    with pytest.raises(InputError, match="lumen.tree"):
        Configuration(folder, tmp_path)


@pytest.mark.parametrize("given, option", [("2", "2"), ("[1, 3]", "1,3")])
def test_labels_of_a_mask_reach_the_command(folder, tmp_path, given, option):
    case = """
kind: surface
description: a segmentation
patient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}
lumen: {path: data/mask.nii.gz, units: mm, label: LABEL}
"""
    (tmp_path / "mask.nii.gz").write_bytes(b"mask")
    (folder / "cases/own.yaml").write_text(case.replace("LABEL", given))
    inputs = Inputs(Configuration(folder, tmp_path))
    assert inputs.lumen_options(SimpleNamespace(case="own")) == f"--units mm --label {option}"


def test_a_ct_reaches_the_command_with_its_ends(folder, tmp_path):
    case = """
kind: surface
description: an angiogram
patient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}
lumen:
  units: mm
  ct: {path: data/series, series: 1.2.3, inlet_mm: [-1, 2, 3], outlets_mm: [[4, 5, -6], [7, 8, 9]]}
"""
    (folder / "cases/own.yaml").write_text(case)
    with pytest.raises(InputError, match="lumen.ct.path"):
        Configuration(folder, tmp_path).selected_cases("real", "own")
    (tmp_path / "series").mkdir()
    inputs = Inputs(Configuration(folder, tmp_path))
    wildcards = SimpleNamespace(case="own")
    options = anatomy_parser().parse_args(["ct", *shlex.split(inputs.ct_options(wildcards)), "--out", "x"])
    assert options.volume == tmp_path / "series" and options.series == "1.2.3"
    assert options.inlet == [-1, 2, 3] and options.outlet == [[4, 5, -6], [7, 8, 9]]
    assert not options.stented
    assert inputs.cases_from_ct() == ["own"] and inputs.lumen_file(wildcards).endswith("own/source/lumen.vtp")
    assert inputs.lumen_options(wildcards) == "--units mm --inlet -1,2,3 --outlet 4,5,-6 --outlet 7,8,9"
    assert inputs.segmentation_files(wildcards) == ["results/cases/own/source/segmentation.json"]
    wildcards.case = "ivus_plaque"
    assert inputs.segmentation_files(wildcards) == ["results/cases/ivus_plaque/source/contours.json"]


@pytest.mark.parametrize(
    "key, word, stented", [("lumen", None, False), ("lumen", True, True), ("post", None, True), ("post", False, False)]
)
def test_a_ct_has_a_stent_after_the_procedure_or_by_the_users_word(folder, tmp_path, key, word, stented):
    (tmp_path / "ct.nii").touch()
    inputs = Inputs(Configuration(folder, tmp_path))
    given = {"path": "data/ct.nii", "inlet_mm": [1, 2, 3], "outlets_mm": [[4, 5, 6]]}
    given |= {} if word is None else {"stented": word}
    inputs.configuration.cases["own"] = {key: {"units": "mm", "ct": given}}
    assert ("--stented" in inputs.ct_options(SimpleNamespace(case="own"), key)) == stented


@pytest.mark.parametrize(
    "plan, has",
    [("{treat: culprit}", True), ("{treat: all}", False), ("{treat: all, least_stenosis_percent: 70}", False)],
)
def test_a_plan_for_all_lesions_has_no_reference(folder, plan, has):
    """It may go into several branches, which is not known before the lumen is measured."""
    edit(folder / "cases/lcx01.yaml", "plan: auto", f"plan: {plan}")
    assert Inputs(Configuration(folder)).has_reference("lcx01") == has


@pytest.mark.parametrize(
    "place, other_branch, has",
    [({"lesion": 1}, "main", True), ({"lesion": 1}, "side1", False), ({"centre_s_mm": 20}, "side1", True)],
)
def test_a_lesion_of_an_unknown_branch_has_no_reference(folder, place, other_branch, has):
    """Where lesions lie in two branches, a device placed by its lesion alone may go into either."""
    inputs = Inputs(Configuration(folder))
    case = inputs.configuration.cases["quick_focal"]
    for step in case["plan"]:
        for device in step["devices"]:
            del device["branch"], device["lesion"]
            device |= place
    case["vessel"]["lesions"] = [{"branch": "main"}, {"branch": other_branch}]
    assert inputs.has_reference("quick_focal") == has


def test_devices_of_a_plan(folder):
    found = Configuration(folder)
    listed = [file.rsplit("/", 1)[1] for file in found.device_files("quick_focal")]
    assert listed == ["des.yaml", "des_balloon.yaml", "non_compliant.yaml", "semi_compliant.yaml"]
    assert len(found.device_files("real_artery")) == len(found.devices)


def test_a_section_changes_only_with_its_own_keys(folder):
    before = {key: Configuration(folder).section("quick_focal", key) for key in ("flow", "metrics", "vessel", "plan")}
    with open(folder / CASE, "a") as stream:
        stream.write("  metrics: {margin_mm: 3}\n")
    after = {key: Configuration(folder).section("quick_focal", key) for key in before}
    assert {key for key in before if before[key] != after[key]} == {"metrics"}
    assert json.loads(after["metrics"])["margin_mm"] == 3

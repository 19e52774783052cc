"""Provenance lists what a finished study was made of; a manifest tells a study that differs from one that agrees."""

import hashlib
import json
import types

import pytest

from common.errors import ComputationError, InputError
from workflow.manifest import verify, write_manifest
from workflow.provenance import write_provenance


def state(ffr=0.8, estimate=0.01, area=5.0):
    """A state of metrics.json; no flow where ffr is None."""
    flow = None if ffr is None else {"distal": ffr, "error_estimate": estimate}
    return {"ffr": flow, "area": {"mean_mm2": area, "minimum_mm2": 3.0}, "curvature": {"mean_per_mm": 0.1}}


PRODUCTS = {
    "settings/flow.json": '{"order": 2}',
    "source/lumen.vtp": "vessel",
    "anatomy/lumen.vtp": "surface",
    "vci/lumen.vtp": "deployed",
    "vci/deployment.json": '{"seconds": 3.1, "steps": [{"pressure_bar": 12, "seconds": 2.0}]}',
    "vci/anatomy/sections.csv": "s_mm\n",
    "flow/vci/mesh.msh": "mesh",
    "flow/vci/ffr.json": "{}",
}


@pytest.fixture
def study(tmp_path):
    """A finished study of one case: a namespace of its `results`, `case` folder, configuration and `provenance()`."""
    results, folder = tmp_path / "results", tmp_path / "config"
    case = results / "cases" / "one"
    for name, text in PRODUCTS.items():
        (case / name).parent.mkdir(parents=True, exist_ok=True)
        (case / name).write_text(text)
    states = {"pre": state(), "vci": state(0.9)}
    (case / "metrics.json").write_text(json.dumps({"schema": "vci-metrics-1", "states": states}))
    (case / "logs" / "vci").mkdir(parents=True)
    (case / "logs" / "vci" / "deploy.log").write_text("$ build/vci deploy scene.json\nsteps\n")
    (results / "study").mkdir()
    software = results / "study" / "software.json"
    software.write_text(json.dumps({"system": "Debian", "packages": {"gmsh": "4.8"}}))
    (folder / "devices").mkdir(parents=True)
    for name in ("study.yaml", "one.yaml", "devices/des.yaml"):
        (folder / name).write_text(name)
    (tmp_path / "vci").write_text("program")
    surface = tmp_path / "mine.stl"
    surface.write_text("solid")
    configuration = types.SimpleNamespace(
        folder=folder,
        cases={"one": {"vessel": {"seed": 4}, "lumen": {"path": str(surface)}}},
        case_file=lambda name: folder / f"{name}.yaml",
        device_files=lambda name: [str(folder / "devices" / "des.yaml")],
        settings=lambda name: {"ct": {"scanner": {"seed": 7}}},
        lumen_file=lambda name, key: str(surface),
        cap_files=lambda name, key: [],
        ct_files=lambda name, key: {},
        contour_files=lambda name, key: {},
    )
    out = results / "study" / "provenance.json"

    def provenance():
        write_provenance(configuration, ["one"], results, [tmp_path / "vci"], software, out)
        return json.loads(out.read_text())

    return types.SimpleNamespace(results=results, case=case, surface=surface, provenance=provenance)


@pytest.fixture
def manifest(study, tmp_path):
    """The manifest of the study as it is."""
    study.provenance()
    write_manifest(study.results, tmp_path / "manifest.json")
    return tmp_path / "manifest.json"


def test_inputs_seeds_commands_and_products_are_listed(study):
    found = study.provenance()
    one = found["cases"]["one"]
    assert one["inputs"][str(study.surface)] == hashlib.sha256(b"solid").hexdigest()
    assert {name.rpartition("/")[2] for name in one["inputs"]} == {"one.yaml", "des.yaml", "mine.stl"}
    assert one["seeds"] == {"vessel.seed": 4, "settings.ct.scanner.seed": 7}
    assert one["commands"] == {"vci/deploy.log": "build/vci deploy scene.json"}
    assert set(one["products"]) == {*PRODUCTS, "metrics.json"}
    assert found["programs"] == {"vci": hashlib.sha256(b"program").hexdigest()}
    assert found["software"]["packages"] == {"gmsh": "4.8"}


def test_what_an_earlier_run_left_is_no_product(study):
    for name in ("ct/pre/ct.nii.gz", "rc/lumen.vtp", "flow/rc/ffr.json", "vci/.partial-7-lumen.vtp"):
        (study.case / name).parent.mkdir(parents=True, exist_ok=True)
        (study.case / name).write_text("old")
    assert set(study.provenance()["cases"]["one"]["products"]) == {*PRODUCTS, "metrics.json"}


def test_an_unfinished_case_and_a_log_without_command_are_refused(study):
    (study.case / "logs" / "settings.log").write_text("")  # of a rule inside Snakemake: nothing to refuse
    study.provenance()
    (study.case / "logs" / "plan.log").write_text("some output\n")
    with pytest.raises(InputError, match="log without its command"):
        study.provenance()
    (study.case / "logs" / "plan.log").unlink()
    (study.case / "metrics.json").unlink()
    with pytest.raises(InputError, match="case is not finished"):
        study.provenance()


def test_the_same_study_agrees_also_when_it_took_longer(study, manifest):
    other = PRODUCTS["vci/deployment.json"].replace("3.1", "9.9").replace("2.0", "8.8")
    (study.case / "vci" / "deployment.json").write_text(other)
    assert verify(manifest, study.results) == 7 + 2 * 4


@pytest.mark.parametrize(
    "name, text, message",
    [
        ("vci/lumen.vtp", "deployed otherwise", "one: deployment: vci/lumen.vtp has other bits"),
        ("vci/deployment.json", '{"steps": [{"pressure_bar": 13}]}', "deployment: vci/deployment.json has other bits"),
        ("anatomy/lumen.vtp", "", "anatomy: anatomy/lumen.vtp has other bits"),
        ("flow/vci/mesh.msh", None, "mesh: flow/vci/mesh.msh is not there"),
        ("vci/devices/des.vtp", "stent", "deployment: vci/devices/des.vtp is not in the manifest"),
    ],
)
def test_products_that_differ_are_named(study, manifest, name, text, message):
    (study.case / name).parent.mkdir(exist_ok=True)
    (study.case / name).unlink() if text is None else (study.case / name).write_text(text)
    with pytest.raises(ComputationError, match=message):
        verify(manifest, study.results)


@pytest.mark.parametrize(
    "changed, message",
    [
        (state(0.9 + 0.009), None),  # within the estimate of .01
        (state(0.9 + 0.011), "vci: ffr 0.911, not 0.9 within 0.01"),
        (state(0.9, area=5.0 * 1.0019), None),
        (state(0.9, area=5.0 * 1.0021), "vci: mean_area_mm2 5.01"),
        (state(None), "vci: ffr is not there"),
        (None, "state vci is not there"),
    ],
)
def test_numbers_have_their_tolerances(study, manifest, changed, message):
    states = {"pre": state(), "vci": changed} if changed else {"pre": state()}
    (study.case / "metrics.json").write_text(json.dumps({"schema": "vci-metrics-1", "states": states}))
    if message is None:
        verify(manifest, study.results)
    else:
        with pytest.raises(ComputationError, match=message):
            verify(manifest, study.results)


def test_other_versions_and_machines_differ_in_no_comparison_but_versions_are_said_where_something_does(
    study, manifest
):
    newer = {
        "system": "Debian",
        "packages": {"gmsh": "4.13"},
        "machine": {"processor": "x", "cores": 64, "memory_gib": 9},
    }
    (study.results / "study" / "software.json").write_text(json.dumps(newer))
    study.provenance()
    verify(manifest, study.results)
    (study.case / "flow/vci/mesh.msh").write_text("other mesh")
    with pytest.raises(ComputationError, match=r"gmsh 4\.13 here, 4\.8 there"):
        verify(manifest, study.results)


def test_a_case_that_was_not_run_is_said(study, manifest):
    wanted = json.loads(manifest.read_text())
    wanted["cases"]["two"] = wanted["cases"]["one"]
    manifest.write_text(json.dumps(wanted))
    with pytest.raises(ComputationError, match="two: not in this study"):
        verify(manifest, study.results)

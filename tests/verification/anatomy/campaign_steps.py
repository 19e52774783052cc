"""The campaign beyond the anatomy: plan, deployment and volume mesh of a case; the real surfaces of the shared data."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from places import ROOT, public_data  # noqa: E402
from workflow.configuration import Configuration  # noqa: E402

SETTINGS_OF = "real_artery"  # whose settings are the study's own
REAL = {  # file of the shared data: its ends, by its source
    "dfemtoolz_case4_artery.stl": 2,
    "offset_stenosis_capped_oriented.stl": 2,
    "vasp_offset_stenosis.stl": 2,
    "dbihar/227A_lumen_derived_mm.stl": 5,
    "dbihar/721A_lumen_derived_mm.stl": 3,
    "multimoda/lca_tree_mm.stl": 6,
    "multimoda/rca_tree_mm.stl": 5,
    "multimoda/ivus_full_lumen_straight_mm.stl": 2,
    "multimoda/ivus_poststent_lumen_straight_mm.stl": 2,
    "multimoda/ivus_prestent_lumen_straight_mm.stl": 2,
    "multimoda/ivus_rest_lumen_straight_mm.stl": 2,
}
CASE = "kind: surface\ndescription: {name}\npatient: {{lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}}\n"
CASE += "lumen: {{path: {path}, units: mm}}\nplan: auto\n"


def real_surfaces():
    """[(path, number of ends)] of those that are there."""
    found = {name: public_data(name) for name in REAL}
    return [(path, REAL[name]) for name, path in found.items() if path]


def steps_of(case, folder, build):
    """[(name, command)] from the anatomy in folder/anatomy to the mesh of the deployed lumen."""
    study, python = Configuration(ROOT / "config"), [sys.executable, "-m"]
    for section in ("deployment", "flow"):
        (folder / f"{section}.json").write_text(study.section(SETTINGS_OF, section))
    vci, after = folder / "vci", folder / "vci" / "anatomy"
    vci.mkdir(exist_ok=True)
    plan = ["anatomy", "plan", case, "--anatomy", folder / "anatomy", "--devices", ROOT / "config" / "devices"]
    scene = ["workflow", "scene", vci / "plan.json", "--settings", folder / "deployment.json"]
    mesh = ["flow", "mesh", after / "lumen.vtp", "--centreline", after / "centreline.vtp"]
    mesh += ["--settings", folder / "flow.json", "--out", folder / "mesh.msh"]
    mesh += ["--coarse", folder / "mesh_coarsest.msh", folder / "mesh_coarse.msh"]
    like = ["--units", "mm", "--like", folder / "anatomy" / "anatomy.json", "--out", after]
    return [
        ("plan", [*python, *plan, "--out", vci / "plan.json"]),
        ("scene", [*python, *scene, "--out", vci / "scene.json"]),
        ("deployment", [build / "vci", "deploy", vci / "scene.json", "--out", vci]),
        ("deployed anatomy", [build / "lumen", "process", vci / "lumen.vtp", *like]),
        ("volume mesh", [*python, *mesh, "--json", folder / "mesh.json"]),
    ]

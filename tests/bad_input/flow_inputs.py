"""Inputs of the flow commands, the plan and the generator: an anatomy's summary, boundary values, patients."""

import json

import tubes
from input_cases import input_case, module
from places import ROOT

CASE = ROOT / "config" / "cases" / "quick_focal.yaml"
PATIENT = ["--lvm-g", "130", "--sbp-mmhg", "120", "--dbp-mmhg", "80"]


def anatomy(folder):
    """The anatomy step's files of a straight tube."""
    tubes.write_case(folder, tubes.tube(20.0, lambda s: 1.2, 0.8), [tubes.centre_branch(20.0, lambda s: 1.2)])
    return folder / "anatomy.json"


def boundary(folder, *more, patient=PATIENT, change=None):
    """`flow boundary` of the tube; change(document): alters the tube's anatomy.json first."""
    path = anatomy(folder / "anatomy")
    if change:
        document = json.loads(path.read_text())
        change(document)
        path.write_text(json.dumps(document))
    return module("flow", "boundary", "--anatomy", path, *patient, *more, "--out", folder / "out" / "boundary.json")


def plan(folder, case=CASE, devices=ROOT / "config" / "devices"):
    where = anatomy(folder / "anatomy").parent
    return module(
        "anatomy", "plan", case, "--anatomy", where, "--devices", devices, "--out", folder / "out" / "plan.json"
    )


@input_case("an anatomy.json that is not there")
def _(folder):
    return module("flow", "boundary", "--anatomy", folder / "anatomy.json", *PATIENT, "--out", folder / "out.json")


@input_case("an anatomy.json of nothing")
def _(folder):
    command = boundary(folder)
    (folder / "anatomy" / "anatomy.json").write_text("")
    return command


@input_case("an anatomy.json that is a list")
def _(folder):
    command = boundary(folder)
    (folder / "anatomy" / "anatomy.json").write_text("[]")
    return command


@input_case("an anatomy.json without ends")
def _(folder):
    return boundary(folder, change=lambda document: document.pop("ends"))


@input_case("an anatomy.json with an outlet of no width")
def _(folder):
    return boundary(folder, change=lambda document: document["ends"][1].update(diameter_mm=0))


@input_case("an anatomy.json with an outlet of a branch that is not there")
def _(folder):
    return boundary(folder, change=lambda document: document["ends"][1].update(branch="side4"))


@input_case("an anatomy.json to draw without its lesions")
def _(folder):
    path = anatomy(folder / "anatomy")
    document = json.loads(path.read_text())
    del document["lesions"]
    path.write_text(json.dumps(document))
    return module("anatomy", "picture", "--anatomy", folder / "anatomy", "--out", folder / "tree.png")


@input_case("an anatomy.json in place of the candidates for ends")
def _(folder):
    path = anatomy(folder / "anatomy")
    drawn = ["--surface", folder / "anatomy" / "lumen.vtp", "--ends", path]
    return module("anatomy", "ends", *drawn, "--out", folder / "ends.png")


@input_case("a patient without a mass")
def _(folder):
    return boundary(folder, patient=PATIENT[2:])


@input_case("a patient given twice")
def _(folder):
    return boundary(folder, "--case", CASE)


@input_case("a systolic pressure below the diastolic")
def _(folder):
    return boundary(folder, patient=["--lvm-g", "130", "--sbp-mmhg", "70", "--dbp-mmhg", "80"])


@input_case("a mass of nothing")
def _(folder):
    return boundary(folder, patient=["--lvm-g", "0", *PATIENT[2:]])


@input_case("a pressure that is not a number")
def _(folder):
    return boundary(folder, patient=[*PATIENT[:3], "nan", *PATIENT[4:]])


@input_case("a centreline that is not there")
def _(folder):
    return boundary(folder, "--centreline", folder / "gone.vtp")


@input_case("a surface in place of the centreline")
def _(folder):
    return boundary(folder, "--centreline", folder / "anatomy" / "lumen.vtp")


def solve(folder, content):
    """`flow solve` with a boundary.json of this content."""
    where = anatomy(folder / "anatomy").parent
    (folder / "boundary.json").write_text(content)
    (folder / "mesh.msh").write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n")
    files = ["--boundary", folder / "boundary.json", "--centreline", where / "centreline.vtp", "--out", folder / "out"]
    return module("flow", "solve", folder / "mesh.msh", *files)


@input_case("a boundary.json that was cut off")
def _(folder):
    return solve(folder, '{"schema": "vci-boundary-1", ')


@input_case("a boundary.json of another schema")
def _(folder):
    return solve(folder, '{"schema": "vci-anatomy-1"}')


@input_case("a boundary.json of numbers that are not finite")
def _(folder):
    return solve(folder, '{"schema": "vci-boundary-1", "inlet_pressure_pa": NaN}')


@input_case("a boundary.json of an earlier version with a given inflow")
def _(folder):
    document = {"schema": "vci-boundary-1", "map_pa": 12000, "venous_pressure_pa": 660, "density_kg_per_m3": 1060}
    outlet = {"name": "outlet1", "region_id": 2, "branch": "main", "flow_m3_per_s": 1e-6}
    outlet["resistance_pa_s_per_m3"] = (12000 - 660) / outlet["flow_m3_per_s"]
    probe = {"name": "distal", "branch": "main", "point_mm": [0, 0, 10]}
    document |= {"viscosity_pa_s": 0.0035, "outlets": [outlet], "probes": [probe], "inlet_flow_m3_per_s": 1e-6}
    return solve(folder, json.dumps(document))


@input_case("a lumen for the mesh that is not there")
def _(folder):
    line = anatomy(folder / "anatomy").parent / "centreline.vtp"
    return module("flow", "mesh", folder / "gone.vtp", "--centreline", line, "--out", folder / "out" / "mesh.msh")


@input_case("a mesh that would replace its lumen")
def _(folder):
    where = anatomy(folder / "anatomy").parent
    command = module("flow", "mesh", where / "lumen.vtp", "--centreline", where / "centreline.vtp")
    return [*command, "--out", folder / "out.msh", "--json", where / "lumen.vtp"]


@input_case("a plan for a lesion that the lumen does not have")
def _(folder):
    return plan(folder)


@input_case("a plan from a folder without devices")
def _(folder):
    (folder / "none").mkdir()
    return plan(folder, devices=folder / "none")


@input_case("a cohort of fewer than no patients")
def _(folder):
    return module("data_synthetic", "draw", "--count", "-3", "--seed", "1", "--out", folder / "out")


@input_case("a cohort of a million million patients")
def _(folder):
    return module("data_synthetic", "draw", "--count", "1000000000000", "--seed", "1", "--out", folder / "out")


@input_case("a user's own surface to generate")
def _(folder):
    return module("data_synthetic", "generate", ROOT / "config" / "cases" / "real_artery.yaml", "--out", folder / "out")


@input_case("metrics that are another file")
def _(folder):
    path = anatomy(folder / "anatomy")
    return module("reports", "agreement", "--metrics", path, "--out", folder / "out.csv")


# unusual, but computed


@input_case("a patient of a light heart and low pressures")
def _(folder):
    return boundary(folder, patient=["--lvm-g", "40", "--sbp-mmhg", "75", "--dbp-mmhg", "45"])


@input_case("an anatomy.json in a folder with blanks and an umlaut")
def _(folder):
    path = anatomy(folder / "Gefäß 1")
    return module("flow", "boundary", "--anatomy", path, *PATIENT, "--out", folder / "out" / "boundary 1.json")

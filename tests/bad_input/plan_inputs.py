"""Inputs of the commands that read a plan.json, and of `whatif`, which varies the plan of a case."""

import json

import pandas as pd
import tubes

from flow import settings
from flow.geometry.centreline import Tree
from flow.inputs import boundary
from input_cases import input_case, module

USE = {"device": "des_3.00x18", "branch": "main", "centre_s_mm": 20.0, "pressure_bar": 12}
STENT = {"kind": "stent", "nominal_diameter_mm": 3.0, "length_mm": 18}
PLAN = {
    "schema": "vci-scene-1",
    "segment": {"branch": "main", "s_start_mm": 11.0, "s_end_mm": 29.0},
    "devices": {"des_3.00x18": STENT},
    "procedure": [{"name": "stent", "action": "stent", "devices": [USE]}],
}
LENGTH_MM, PATIENT = 40.0, {"lvm_g": 150, "sbp_mmhg": 120, "dbp_mmhg": 80}


def written(path, document):
    """Writes a document as JSON (a text as it is) to `path`, which is returned."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def carried(folder, document):
    """`anatomy carry-plan` of a plan.json with this content; None: without the file."""
    plan = folder / "plan.json" if document is None else written(folder / "plan.json", document)
    return module("anatomy", "carry-plan", plan, "--from", folder, "--to", folder, "--out", folder / "out.json")


def scene(folder, plan=PLAN, settings=None):
    """`workflow scene` of a plan.json and of settings with these contents; None: without the file."""
    files = folder / "plan.json", folder / "deployment.json"
    for path, document in zip(files, (plan, settings)):
        if document is not None:
            written(path, document)
    return module("workflow", "scene", files[0], "--settings", files[1], "--out", folder / "scene.json")


def stents(folder, document):
    """`workflow stent-alone` of a plan.json with this content."""
    plan = written(folder / "vci" / "plan.json", document)
    return module("workflow", "stent-alone", plan, "--out", folder / "rc_stent" / "plan.json")


def varied(folder, deployment):
    """`whatif plans` of a tube that was widened, with this content of deployment.json; None: without the file."""
    case = folder / "case"
    for place, radius in ((case / "anatomy", 1.0), (case / "vci" / "anatomy", 1.4)):
        line = tubes.centre_branch(LENGTH_MM, lambda s: radius)
        tubes.write_case(place, tubes.tube(LENGTH_MM, lambda s: radius, 0.8), [line])
        table = pd.read_csv(place / "sections.csv")
        table.assign(x_mm=table["s_mm"], y_mm=0.0, z_mm=0.0).to_csv(place / "sections.csv", index=False)
    summary = json.loads((case / "anatomy" / "anatomy.json").read_text())
    written(case / "flow" / "boundary.json", boundary.make(summary, Tree([line]), PATIENT, settings.make()))
    written(case / "settings" / "flow.json", {})
    for state, ffr in (("pre", 0.7), ("vci", 0.9)):
        written(case / "flow" / state / "ffr.json", {"ffr": ffr, "models": {"3d": {"ffr": ffr}}})
    written(case / "vci" / "scene.json", PLAN)
    if deployment is not None:
        written(case / "vci" / "deployment.json", deployment)
    out = ["--case-dir", case, "--out", folder / "ranking.csv"]
    return module("whatif", "plans", "--states", "pre", "vci", *out)


@input_case("a plan to carry that is not there")
def _(folder):
    return carried(folder, None)


@input_case("a plan to carry without its treated segment")
def _(folder):
    return carried(folder, {key: value for key, value in PLAN.items() if key != "segment"})


@input_case("a plan to carry with a device that it does not define")
def _(folder):
    return carried(folder, PLAN | {"devices": {}})


@input_case("a plan for a scene that was cut off")
def _(folder):
    return scene(folder, json.dumps(PLAN)[:99])


@input_case("a list in place of the plan for a scene")
def _(folder):
    return scene(folder, [PLAN])


@input_case("a plan for a scene without its settings")
def _(folder):
    return scene(folder)


@input_case("settings of the flow in place of those for a scene")
def _(folder):
    return scene(folder, settings={"rings": 4})


@input_case("metrics in place of a plan for its stents alone")
def _(folder):
    return stents(folder, {"schema": "vci-metrics-1"})


@input_case("a plan for its stents alone with an infinite pressure")
def _(folder):
    return stents(folder, json.dumps(PLAN).replace("12", "1e999"))


@input_case("a plan for its stents alone that has none")
def _(folder):
    return stents(folder, PLAN | {"devices": {"des_3.00x18": STENT | {"kind": "balloon"}}})


@input_case("a case to vary that was not deployed")
def _(folder):
    return varied(folder, None)


@input_case("a case to vary whose deployment.json was cut off")
def _(folder):
    return varied(folder, '{"schema": "vci-deployment-1", ')


BALLOON = {"device": "semi_compliant", "diameter_mm": 2.5, "length_mm": 12, "centre_s_mm": 19.8, "pressure_bar": 8}


def other_plan(folder, action="predilatation", name="longer", **change):
    """`whatif deploy` of the plan `name`; plans.json has the plan longer, of one step with one balloon."""
    plans = {"longer": [{"action": action, "devices": [BALLOON | change]}]}
    path = written(folder / "plans.json", plans)
    return module("whatif", "deploy", name, "--plans", path, "--case-dir", folder, "--out", folder / "out")


@input_case("other plans without the one to deploy")
def _(folder):
    return other_plan(folder, name="larger")


@input_case("another plan with a pressure in atmospheres, as text")
def _(folder):
    return other_plan(folder, pressure_bar="8 atm")


@input_case("another plan with one kissing balloon")
def _(folder):
    return other_plan(folder, action="kissing")


@input_case("a plan in place of a manifest")
def _(folder):
    return module("workflow", "verify", "--manifest", written(folder / "plan.json", PLAN), "--results", folder)

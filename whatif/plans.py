"""ranking.csv: other plans of one patient, deployed by the engine and ranked."""

import pathlib
import tempfile

import numpy as np
import pandas as pd

from anatomy.lumen_results import read_summary
from anatomy.planning.plan import procedure
from common.documents import config, json_reader, schema
from common.errors import InputError
from flow.geometry import centreline, surface
from flow.meshing.provenance import fingerprint
from whatif import alternatives, calibrated, engine, risks
from whatif.case import PLANNED

READOUTS = {
    "minimal_stent_area_mm2": "minimal_stent_area_mm2",
    "minimal_lumen_area_mm2": "minimal_lumen_area_mm2",
    "expansion_index": "expansion_index",
    "malapposition_mm": "maximal_malapposition_mm",
}
COLUMNS = ["rank", "plan", "change", "ffr", "ffr_error", "as_good_as_best", "ffr_3d", *READOUTS, "wall_stretch"]
COLUMNS += ["side_branch_loss_percent", "balloon_to_artery", "risks"]
COLUMNS += ["warnings", "procedure", "status", "lumen_sha256"]
DEPLOYED = "deployed"


def rank_plans(case, devices_folder, states):
    """(DataFrame of ranking.csv, {plan: steps as a case file lists them}) of a case (whatif.case.Case).

    states: states with a 3D answer, which calibrate the network and give its error. First come the plans as good as the
    best (`sort_by_rank`): those of the fewest risks (`risks.named`) first, among them the largest stent area. Then come
    the other plans by FFR. Last come plans without an answer; their `status` says why.
    """
    families, calibration = config.load_devices(devices_folder), calibrated.calibrate(case, states)
    steps = alternatives.case_steps(case.scene)
    rows = [planned_row(case, calibration, steps)]
    plans = {"planned": steps}
    with tempfile.TemporaryDirectory(dir=case.folder, prefix=".plans-") as folder:
        for name, (description, changed_steps, reason) in alternatives.all_alternatives(steps, families).items():
            row = {"plan": name, "change": description, "status": reason}
            if changed_steps is not None:
                plans[name] = changed_steps
                row |= alternative_row(case, calibration, families, changed_steps, pathlib.Path(folder) / name)
            rows.append(row)
    table = sort_by_rank(pd.DataFrame(rows).reindex(columns=COLUMNS), calibration.error)
    return table, {name: plans[name] for name in table["plan"] if name in plans}


def sort_by_rank(table, error):
    """The rows of ranking.csv sorted by rank, with the columns rank, ffr_error and as_good_as_best.

    error: error of each FFR. A plan is as good as the best unless their FFRs differ by more than both errors together.
    Among plans as good as the best, those of fewer risks come first, however large the areas of the others. Of as many
    risks, the widest balloon beyond risks.LARGEST_RATIO comes last. Otherwise the largest stent area comes first.
    """
    table = table.assign(ffr_error=np.where(table["ffr"].notna(), error, np.nan))
    table["as_good_as_best"] = table["ffr"].max() - table["ffr"] <= 2 * error
    good = table["as_good_as_best"]
    excess = (table["balloon_to_artery"].astype(float) - risks.LARGEST_RATIO).clip(lower=0).fillna(0)
    count = table["risks"].fillna("").map(lambda text: len([words for words in text.split("; ") if words]))
    keys = {
        "safe": -count.where(good),
        "fit": -excess.where(good),
        "area": table["minimal_stent_area_mm2"].astype(float).where(good),
    }
    table = table.assign(**keys).sort_values(
        ["as_good_as_best", *keys, "ffr", "plan"],
        ascending=[False, False, False, False, False, True],
        na_position="last",
    )
    table = table.drop(columns=list(keys)).reset_index(drop=True)
    table["rank"] = np.where(table["ffr"].notna(), table.index + 1, np.nan)
    table["rank"] = table["rank"].astype("Int64")
    table["as_good_as_best"] = table["as_good_as_best"].where(table["ffr"].notna(), None)
    return table


def planned_row(case, calibration, steps):
    """The row (dict) of the given plan, from the results of the study."""
    answer = case.flow_result(PLANNED)
    deployed = case.folder / "vci" / "deployment.json"
    deployment = json_reader.read(deployed, "deployment.json", "run `vci deploy` on the planned scene").data
    row = {
        "plan": "planned",
        "change": "as planned",
        "ffr_3d": answer["models"].get("3d", {}).get("ffr"),
        "status": DEPLOYED,
    }
    return row | deployment_columns(
        case, calibration, case.scene, deployment, case.folder / "vci" / "lumen.vtp", case.anatomy(PLANNED), steps
    )


def alternative_row(case, calibration, families, steps, folder):
    """The columns of another plan's row (dict); only `status` and `procedure` if the plan has no answer."""
    try:
        scene = scene_with_steps(case, families, steps)
    except InputError as error:  # the catalogue or the vessel does not allow this plan
        return {"status": f"{error.what}: {error.value}", "procedure": describe_steps(steps)}
    try:
        deployment, anatomy = engine.deploy_and_measure(case, scene, folder)
    except engine.ProcedureFailed as error:
        return {"status": error.reason, "procedure": describe_steps(steps)}
    return {"status": DEPLOYED} | deployment_columns(
        case, calibration, scene, deployment, folder / "lumen.vtp", anatomy, steps
    )


def read_steps(path, name):
    """The steps of the plan `name` in plans.json at `path`, which `whatif plans` writes. Raises InputError."""
    remedy = "give plans.json of `whatif plans`"
    plans = json_reader.read(path, "plans.json", remedy)
    schema.validate(plans, schema.read("plans"), "a file of plans", remedy)
    if name not in plans.data:
        raise InputError("no such plan", path, name, f"one of {', '.join(plans.data)}")
    config.check_steps(plans, name)
    return plans.data[name]


def deploy(case, steps, devices_folder, folder):
    """Writes the lumen after a plan, its anatomy and deployment.json into `folder`. Raises InputError, ProcedureFailed.

    steps: as plans.json lists them.
    """
    engine.deploy_and_measure(case, scene_with_steps(case, config.load_devices(devices_folder), steps), folder)


def scene_with_steps(case, families, steps):
    """The content of scene.json with other steps. Raises InputError.

    All plans are measured along the segment of the given plan. The segment of a shorter stent would leave out the part
    of the lesion that this stent does not cover.
    """
    changed = procedure(steps, families, read_summary(case.anatomy()), "plan")
    return case.scene | changed | {"segment": case.scene["segment"]}


def deployment_columns(case, calibration, scene, deployment, lumen_file, anatomy, steps):
    """The columns of ranking.csv for a deployed lumen: FFR, results of the deployment, and steps in words.

    scene: content of the plan's scene.json. lumen_file: lumen.vtp of the deployment. anatomy: folder of the lumen's
    anatomy.
    """
    summary, before = case.lumen(case.anatomy())
    after = case.lumen(anatomy)
    ratio = risks.balloon_to_artery(scene, before)
    loss = calibrated.network_loss(after, case.boundary, case.flow_settings.expansion_loss)
    return {
        "ffr": calibration.ffr(loss),
        **{column: deployment.get(key) for column, key in READOUTS.items()},
        "wall_stretch": risks.wall_stretch(lumen_file),
        "side_branch_loss_percent": risks.side_branch_loss(summary["branches"], before, after[1]),
        "balloon_to_artery": ratio,
        "risks": "; ".join(
            risks.named(ratio, deployment.get("expansion_index"), deployment.get("maximal_malapposition_mm"))
        ),
        "warnings": "; ".join(deployment.get("warnings", [])),
        "procedure": describe_steps(steps),
        "lumen_sha256": fingerprint(surface.read(anatomy / "lumen.vtp"), centreline.read(anatomy / "centreline.vtp")),
    }


def describe_steps(steps):
    """All steps in one line, as a clinician writes them."""
    return "; ".join(
        f"{step['action'].replace('_', ' ')}: "
        + " + ".join(
            f"{use['diameter_mm']:.2f}x{use['length_mm']:g} mm at {use['pressure_bar']:g} bar"
            for use in step["devices"]
        )
        for step in steps
    )

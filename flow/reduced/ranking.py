"""Several plans of one patient ranked by a reduced model's FFR, with the model's measured error.

The reduced model includes the extensions that the plan's mesh would get (meshing.extension), as in every ffr.json.

The error of the reduced model is its largest difference from the 3D model's FFR in this patient, over all ffr.json that
have both. It is at least the largest error estimate of these 3D answers. Without any 3D answer, it is the error
measured in other patients (measured.md).

In similar lumens the reduced model errs by similar amounts. So two plans count as different if their FFRs differ by
more than a limit: the largest minus the smallest of the differences between 3D and reduced model. This range is known
only to within the two largest error estimates, so the limit is at least their sum. With fewer than two differences, the
limit is the error. Where a 3D answer has no error estimate, the reduced model's error in other patients takes its
place.
"""

import pathlib

import numpy as np
import pandas as pd

from common.documents import json_reader, schema
from common.errors import InputError
from flow.geometry import centreline, surface
from flow.inputs import lumen_summary
from flow.meshing import extension
from flow.physics import ffr
from flow.reduced import extended, network as network_model
from flow.reduced.answer import ERROR_IN_OTHER_PATIENTS, MILD_FFR

COLUMNS = ("rank", "plan", "ffr", "error", "model", "as_good_as_best", "inlet_flow_m3_per_s", "cpu_seconds")
COORDINATE_TOLERANCE_MM = 1e-6  # mm: files give coordinates to within this


def error_in_other_patients(model, value):
    """Error in FFR of a reduced model, measured in other patients, where the model's FFR is `value`."""
    mild, severe = ERROR_IN_OTHER_PATIENTS[model]
    return mild if value >= MILD_FFR else severe


def model_error(model, documents, lowest):
    """(error of a reduced model, difference above which two plans count as different), both in FFR.

    documents: [(path, document of ffr.json)] of this patient; lowest: the lowest FFR of the plans by the reduced model.
    Raises InputError for a document without the FFR of both models.
    """
    differences, estimates = [], []
    for path, document in documents:
        models = document.get("models", {})
        both = [models.get(name, {}).get("ffr") for name in ("3d", model)]
        if None in both:
            raise InputError("no 3D answer beside the reduced model's", path, model, "give an ffr.json of model 3d")
        differences.append(both[0] - both[1])
        estimate = models["3d"].get("error_estimate")
        estimates.append(error_in_other_patients(model, both[1]) if estimate is None else estimate)
    if not differences:
        return (error_in_other_patients(model, lowest),) * 2
    error = float(max(np.abs(differences).max(), max(estimates)))
    return error, float(max(np.ptp(differences), sum(sorted(estimates)[-2:]))) if len(differences) > 1 else error


def check_patient(path, answer, document):
    """Raises InputError unless `answer`, the document of ffr.json at `path`, has the probes of `document`.

    document: content of boundary.json. The distance of a probe in `answer` from its point there must equal its
    `shift_mm`.
    """
    given = {probe["name"]: np.array(probe["point_mm"], float) for probe in document["probes"]}
    try:
        distances = {
            probe["name"]: float(np.linalg.norm(np.array(probe["point_mm"], float) - given.pop(probe["name"])))
            - probe["shift_mm"]
            for probe in answer["probes"]
        }
    except (KeyError, TypeError, ValueError):
        distances = {}
    if not distances or given or not max(np.abs(list(distances.values()))) < COORDINATE_TOLERANCE_MM:
        raise InputError("an answer with other boundary values", path, distances, "give an ffr.json of this patient")


def plan_ffr(folder, document, settings, model):
    """{"ffr", "inlet_flow_m3_per_s", "cpu_seconds"} of one plan by the reduced model `model`.

    folder: output of the anatomy step for the plan's lumen; document: content of boundary.json. Raises InputError where
    files are missing or do not belong together.
    """
    folder = pathlib.Path(folder)
    for name in lumen_summary.ANATOMY_STEP_FILES:
        if not (folder / name).is_file():
            raise InputError("not a plan's lumen", folder / name, "missing", "run the anatomy step on the plan's lumen")
    tree = centreline.read(folder / "centreline.vtp")
    anatomy = lumen_summary.read(folder / "anatomy.json", "branches")
    ffr.check_probes(document["probes"], tree)
    sections = network_model.read_sections(folder / "sections.csv")
    lumen_summary.check_lengths(anatomy, tree, folder / "anatomy.json")
    network_model.check_sections(sections, tree, folder / "sections.csv")
    lumen = surface.read(folder / "lumen.vtp")
    centreline.check_ends(tree, lumen, folder / "centreline.vtp")
    extensions = extension.find_extensions(lumen, tree, settings)
    predictor = extended.ExtendedLumen(extensions, tree, anatomy, sections, document, settings).predictor()
    answer = predictor.answers()[model]
    predictor.destroy()
    if answer["ffr"] is None:
        raise InputError("the axisymmetric model has no answer", folder, answer["reason"], "rank by the network")
    flow = float(np.sum(answer["outlet_flows_m3_per_s"]))
    return {"ffr": answer["ffr"], "inlet_flow_m3_per_s": flow, "cpu_seconds": answer.get("cpu_seconds", 0.0)}


def rank(plans, document, settings, model, measured):
    """Table with COLUMNS, one row a plan, the highest FFR first.

    plans: {name: folder of the anatomy step}; document: content of boundary.json; measured: [(path, document of
    ffr.json)] of this patient. Raises InputError for a plan or an ffr.json of another patient.
    """
    for path, answer in measured:
        schema.validate(json_reader.Document(path, answer), schema.read("measured_ffr"))
        check_patient(path, answer, document)
    rows = []
    for name, folder in plans.items():
        try:
            rows.append({"plan": name, "model": model} | plan_ffr(folder, document, settings, model))
        except InputError as error:
            raise InputError(error.what, f"plan {name} ({folder}): {error.where}", error.value, error.remedy) from None
    error, least_difference = model_error(model, measured, min(row["ffr"] for row in rows))
    table = (
        pd.DataFrame(rows).assign(error=error).sort_values(["ffr", "plan"], ascending=[False, True], ignore_index=True)
    )
    table["rank"] = table["ffr"].rank(method="min", ascending=False).astype(int)
    table["as_good_as_best"] = table["ffr"].max() - table["ffr"] <= least_difference
    return table[list(COLUMNS)]

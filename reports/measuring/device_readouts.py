"""The parts of metrics.json that come from other files: patient, lesion, procedure, results of the deployment."""

from common.errors import InputError
from reports.inputs.reading import entry, number, read_json
from reports.measuring.stent_edges import stent_edges

# The engine warns by the same limits: OutcomeLimits in vci/results/readouts.hpp, which names their sources.
LEAST_EXPANSION = 0.6
LARGEST_MALAPPOSITION_MM = 0.4
DEPLOYMENT_KEYS = (
    "status",
    "seconds",
    "minimal_stent_area_mm2",
    "minimal_lumen_area_in_stent_mm2",
    "expansion_index",
    "recoil_percent",
    "foreshortening_percent",
    "straightening_deg",
    "maximal_malapposition_mm",
)
LESION_KEYS = (
    "name",
    "branch",
    "s_start_mm",
    "s_mla_mm",
    "s_end_mm",
    "mla_mm2",
    "mla_error_percent",
    "mld_mm",
    "reference_diameter_mm",
    "diameter_stenosis_percent",
    "area_stenosis_percent",
)
ML_PER_MIN = 6.0e7  # mL/min in one m3/s


def patient_summary(files, case):
    """The entry `patient` of metrics.json: pressures and inflow from boundary.json.

    case: content (dict) of the case's file, or None. From it come description, ventricular mass and blood pressures.
    """
    boundary = read_json(files.boundary, "flow boundary")
    patient = {
        "map_pa": number(boundary, "map_pa", files.boundary),
        "venous_pressure_pa": number(boundary, "venous_pressure_pa", files.boundary),
        "q_hyperaemic_ml_per_min": number(boundary, "q_hyperaemic_m3_per_s", files.boundary) * ML_PER_MIN,
    }
    source = boundary.get("flow_source")
    if source is not None:
        patient["flow_source"] = {key: source.get(key) for key in ("territory", "share", "by")}
    if case:
        patient["description"] = case["description"]
        given = case["patient"]
        patient.update({key: float(given[key]) for key in ("lvm_g", "sbp_mmhg", "dbp_mmhg") if key in given})
    return patient


def case_kind(files, case):
    """`synthetic` or `surface`, as the case's file (dict) says. Without one: synthetic if truth.json exists."""
    if case:
        return case["kind"]
    return "synthetic" if files.truth.exists() else "surface"


def lesion_summary(files):
    """The most severe lesion of the pre-PCI anatomy; None if the anatomy found none."""
    path = files.anatomy("pre") / "anatomy.json"
    lesions = entry(read_json(path, "anatomy"), "lesions", path)
    return {key: entry(lesions[0], key, path) for key in LESION_KEYS} if lesions else None


def reference_summary(files):
    """The vessel's healthy size and its lesions, as the planner found them. None if the case file gives the plan."""
    return read_json(files.scene, "workflow scene").get("reference")


GIVEN_STATES = ("pre", "post")  # states whose lumen the case gives; all other lumens are made from these


def lumen_warnings(files, states):
    """{state: [sentence]}: the warnings of `lumen process` on the given lumens, then those of the registration.

    Such a defect, for example a closed branch or another vessel after PCI, changes every result of the case.
    """
    warnings = {}
    for state in GIVEN_STATES:
        if state in states:
            repairs = read_json(files.anatomy(state) / "anatomy.json", "lumen process").get("repairs", [])
            warnings[state] = [f"{repair['what']}: {repair['detail']}" for repair in repairs if repair.get("warning")]
    if "post" in states:
        warnings["post"] += read_json(files.registration, "anatomy register").get("warnings", [])
    return {state: sentences for state, sentences in warnings.items() if sentences}


def procedure_summary(files):
    """The scene's steps: name, action, and for each device its size, place and pressure."""
    scene = read_json(files.scene, "workflow scene")
    catalogue = entry(scene, "devices", files.scene)
    steps = []
    for step in entry(scene, "procedure", files.scene):
        devices = []
        for use in entry(step, "devices", files.scene):
            key = entry(use, "device", files.scene)
            device = catalogue.get(key)
            if device is None:
                raise InputError("a device is not in the scene", files.scene, key, "repeat the plan")
            devices.append(
                {
                    "device": key,
                    "kind": entry(device, "kind", files.scene),
                    "nominal_diameter_mm": number(device, "nominal_diameter_mm", files.scene),
                    "length_mm": number(device, "length_mm", files.scene),
                    "branch": entry(use, "branch", files.scene),
                    "centre_s_mm": number(use, "centre_s_mm", files.scene),
                    "pressure_bar": number(use, "pressure_bar", files.scene),
                }
            )
        steps.append({key: entry(step, key, files.scene) for key in ("name", "action")} | {"devices": devices})
    return steps


def deployment_summary(files):
    """The values DEPLOYMENT_KEYS of deployment.json, its worst stages, and the wall's stretch at the stents' edges.

    worst_residual and worst_max_penetration_mm are the largest values over all stages, None without stages. stent_edges
    is the result of the function of that name.
    """
    document = read_json(files.deployment, "vci deploy")
    stages = entry(document, "stages", files.deployment)
    summary = {key: document.get(key) for key in DEPLOYMENT_KEYS}
    for key in ("residual", "max_penetration_mm"):
        values = [number(stage, key, files.deployment) for stage in stages]
        summary[f"worst_{key}"] = max(values) if values else None
    summary["stent_edges"] = stent_edges(files, entry(document, "stents", files.deployment))
    return summary

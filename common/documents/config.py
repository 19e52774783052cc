"""Reads the study's configuration, checks it against its schemas and fills in defaults.

The loaders raise InputError for a value that is not allowed. Its message names file, line, key, value and what is
allowed.
"""

import pathlib

from common.documents import schema, yaml_reader
from common.errors import InputError

ENDS_REMEDY = {
    "contours": "z_from says which end is proximal",
    "ct": "ct.inlet_mm and ct.outlets_mm say where they are",
}
LUMEN_SOURCES = ("path", "contours", "ct")
# The hyperaemic flow of a whole heart is 582 +- 138 mL/min, that is about 10 mL/s (flow/inflow.md).
# So a value below LEAST_INFLOW_ML_PER_MIN was probably given in mL/s or L/min, and a message proposes these units.
LEAST_INFLOW_ML_PER_MIN, MOST_INFLOW_ML_PER_MIN = 10, 1000
INFLOW_UNITS = {"mL/s": 60.0, "L/min": 1000.0}
SECTIONS = ("anatomy", "deployment", "flow", "reference", "ct", "metrics")


def load(path, schema_name):
    """The YAML file `path` checked against config/schemas/<schema_name>.schema.yaml, with defaults filled in.

    Returns plain dicts and lists. Raises InputError for the first value that is not allowed.
    """
    return _load(path, schema_name).data


def load_section(path, name):
    """One section of the settings (dict), say `ct`, from a YAML or JSON file with only this section.

    Without a file (`path` None) every setting has its default.
    """
    return load(path, name) if path else schema.with_defaults({}, schema.read(name))


def load_study(path):
    """The content (dict) of config/study.yaml: the cohorts, and the sections of settings that SECTIONS lists."""
    return load(path, "study")


def load_case(path):
    """The content (dict) of config/cases/<case>.yaml: patient, plan, settings, and the vessel.

    A synthetic case has the key `vessel`, a real patient the key `lumen`. A real patient may also have `post`, the
    lumen after the procedure, and `measured`, the FFR by a pressure wire.
    """
    document = _load(path, "case")
    patient = document.data["patient"]
    if patient["dbp_mmhg"] >= patient["sbp_mmhg"]:
        remedy = f"below the systolic one, sbp_mmhg: {patient['sbp_mmhg']}; are they swapped?"
        _refuse(document, ("patient", "dbp_mmhg"), "diastolic blood pressure is not below the systolic", remedy)
    _check_flow(document)
    for key in ("lumen", "post"):
        if key in document.data:
            _check_lumen(document, key)
    if "registration" in document.data and "post" not in document.data:
        remedy = "give `post`, the lumen after the procedure"
        _refuse(document, ("registration",), "there is nothing to register", remedy)
    check_steps(document, "plan")
    return document.data


def check_steps(document, key):
    """Raises InputError for a step that inflates a wrong number of devices, or whose device has no place or two.

    document: a Document of yaml_reader or json_reader, already checked by its schema. key: where it has the plan.
    """
    for i, step in enumerate(listed_steps(document.data[key])):
        if step["action"] == "kissing" and len(step["devices"]) != 2:
            remedy = "name two, or call the step a postdilatation"
            _refuse(document, (key, i, "devices"), "kissing inflates two balloons side by side", remedy)
        if step["action"] != "kissing" and len(step["devices"]) != 1:
            remedy = "give each device a step of its own"
            _refuse(document, (key, i, "devices"), "only kissing inflates two devices at once", remedy)
        for j, device in enumerate(step["devices"]):
            if ("centre_s_mm" in device) == ("lesion" in device):
                remedy = "give either centre_s_mm or lesion"
                _refuse(document, (key, i, "devices", j), "a device is placed by one of two keys", remedy)


def _check_flow(document):
    """Refuses a patient whose coronary flow cannot be computed.

    The flow follows from the left ventricular mass, a measured inflow in mL/min, or a cardiac output with a territory.
    """
    patient, inflow = document.data["patient"], "hyperaemic_inflow_ml_per_min"
    flows = ("lvm_g", inflow, "cardiac_output_l_per_min")
    if not any(key in patient for key in flows):
        what = "lvm_g is missing (left ventricular mass in g), and so is a flow"
        _refuse(document, ("patient",), what, f"give one of {', '.join(flows)}")
    if inflow in patient:
        if patient[inflow] < LEAST_INFLOW_ML_PER_MIN:
            what = "a hyperaemic flow too small for a coronary artery"
            readings = [
                f"{unit}, that is {factor * patient[inflow]:g}"
                for unit, factor in INFLOW_UNITS.items()
                if LEAST_INFLOW_ML_PER_MIN <= factor * patient[inflow] <= MOST_INFLOW_ML_PER_MIN
            ]
            remedy = "give mL/min" + "".join(f"; if it is in {reading}" for reading in readings)
            _refuse(document, ("patient", inflow), what, remedy)
    elif "cardiac_output_l_per_min" in patient and patient.get("territory", "whole") == "whole":
        what = "a cardiac output is shared out by territory"
        remedy = "give patient.territory: left, lad, lcx, rca or a share"
        _refuse(document, ("patient", "cardiac_output_l_per_min"), what, remedy)


def _check_lumen(document, key):
    """Refuses a lumen (`lumen` or `post`) that is not given in exactly one of LUMEN_SOURCES.

    Only a surface or mask file (`path`) may have keys that name its ends and its label.
    """
    lumen = document.data[key]
    sources = [source for source in LUMEN_SOURCES if source in lumen]
    if len(sources) != 1:
        _refuse(document, (key,), "a lumen is given in one way", f"one of the keys {', '.join(LUMEN_SOURCES)}")
    if "path" in lumen:
        return
    for name in ("inlet_point_mm", "outlet_points_mm", "label"):
        if name in lumen:
            remedy = "leave the key out; " + ENDS_REMEDY[sources[0]]
            _refuse(document, (key, name), f"{sources[0]} knows its ends", remedy)
    if sources == ["ct"] and lumen["units"] != "mm":
        _refuse(document, (key, "units"), "CT volumes are in mm", "units: mm, and points in mm")


def listed_steps(plan):
    """The steps that a case's `plan` lists; an empty list if the study is to propose a plan."""
    return plan if isinstance(plan, list) else []


def load_device(path):
    """The checked content (dict) of config/devices/<family>.yaml. Its key `kind` is balloon or stent."""
    kind = yaml_reader.read(path).data
    kind = kind.get("kind") if isinstance(kind, dict) else None
    document = _load(path, kind if kind in ("balloon", "stent") else "device")
    (_check_balloon if kind == "balloon" else _check_stent)(document)
    return document.data


def load_devices(folder):
    """All device families in a folder, {name: family}.

    Each stent family names the balloon family that delivers it. That family must be in the folder, and have every
    diameter and length of the stents. Raises InputError.
    """
    files = sorted(pathlib.Path(folder).glob("*.yaml"))
    if not files:
        raise InputError("no device families", folder, "no file *.yaml", "give a folder like config/devices")
    families = {file.stem: load_device(file) for file in files}
    for file in files:
        family = families[file.stem]
        if family["kind"] != "stent":
            continue
        document = yaml_reader.read(file)
        balloon = families.get(family["delivery_balloon"], {})
        if balloon.get("kind") != "balloon":
            names = ", ".join(name for name, other in families.items() if other["kind"] == "balloon")
            _refuse(document, ("delivery_balloon",), "no such balloon family", f"known balloons: {names}")
        for sizes in ("diameters_mm", "lengths_mm"):
            missing = sorted(set(family[sizes]) - set(balloon[sizes]))
            if missing:
                _refuse(
                    document,
                    (sizes,),
                    f"the delivery balloon has no {missing}",
                    f"add them to {family['delivery_balloon']}",
                )
    return families


def balloon_family(families, family):
    """Name of the balloon family that inflates a device: its own, or a stent's delivery balloon.

    families: {name: family}, as load_devices() returns them. family: name of the device's family.
    """
    document = families[family]
    return document["delivery_balloon"] if document["kind"] == "stent" else family


def resolve_settings(study, case):
    """Settings of a case, {section: values}: those of the study, overridden by the case's own `settings`.

    study, case: contents (dict) of study.yaml and of the case file.
    """
    return {section: _deep_merge(study[section], case["settings"].get(section, {})) for section in SECTIONS}


def _load(path, schema_name):
    document = yaml_reader.read(path)
    if not isinstance(document.data, dict):
        raise InputError("not a group of keys", path, document.data, "write `key: value` lines")
    rules = schema.read(schema_name)
    schema.validate(document, rules)
    document.data = schema.with_defaults(document.data, rules)
    return document


def _deep_merge(base, top):
    merged = dict(base)
    for key, value in top.items():
        merged[key] = (
            _deep_merge(base[key], value) if isinstance(value, dict) and isinstance(base.get(key), dict) else value
        )
    return merged


def _refuse(document, path, what, remedy):
    value = document.data
    for key in path:
        value = value[key]
    raise InputError(what, document.where(path), value, remedy)


def _strictly_increasing(values):
    return all(a < b for a, b in zip(values, values[1:]))


def _check_balloon(document):
    family, chart = document.data, document.data["chart"]
    for path in (("diameters_mm",), ("lengths_mm",), ("chart", "pressure_bar"), ("chart", "diameter_percent")):
        values = chart[path[1]] if len(path) == 2 else family[path[0]]
        if not _strictly_increasing(values):
            _refuse(document, path, "values do not rise", "list them from small to large, each once")
    if len(chart["pressure_bar"]) != len(chart["diameter_percent"]):
        _refuse(
            document,
            ("chart", "diameter_percent"),
            "chart columns differ in length",
            "one percentage for each pressure",
        )
    nominal = family["nominal_pressure_bar"]
    if dict(zip(chart["pressure_bar"], chart["diameter_percent"])).get(nominal) != 100:
        _refuse(document, ("chart",), "chart is not 100 % at nominal pressure", f"give 100 at {nominal} bar")
    if not nominal < family["rated_burst_pressure_bar"] <= chart["pressure_bar"][-1]:
        remedy = f"between nominal ({nominal} bar) and the chart's end ({chart['pressure_bar'][-1]} bar)"
        _refuse(document, ("rated_burst_pressure_bar",), "rated burst pressure out of place", remedy)
    if family["crimped_diameter_mm"] >= family["diameters_mm"][0]:
        _refuse(
            document,
            ("crimped_diameter_mm",),
            "crimped balloon is wider than the smallest size",
            "give the crossing profile",
        )


def _check_stent(document):
    family = document.data
    for path in (("diameters_mm",), ("lengths_mm",)):
        if not _strictly_increasing(family[path[0]]):
            _refuse(document, path, "values do not rise", "list them from small to large, each once")
    limits = [design["up_to_diameter_mm"] for design in family["designs"]]
    if not _strictly_increasing(limits) or limits[-1] != family["diameters_mm"][-1]:
        _refuse(
            document,
            ("designs",),
            "designs do not cover the diameters",
            "rising up_to_diameter_mm, the last the largest diameter",
        )
    for i, design in enumerate(family["designs"]):
        if design["maximal_diameter_mm"] <= design["up_to_diameter_mm"]:
            _refuse(
                document,
                ("designs", i, "maximal_diameter_mm"),
                "not above the design's sizes",
                "give its expansion limit",
            )

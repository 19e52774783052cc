"""The manifest that ships with a release: results that a study must reproduce on another machine, and the comparison.

Surfaces, deployments and meshes must have the same bits. Areas and curvature need only agree within RELATIVE_TOLERANCE,
and FFR within its error estimate. They come from a library of linear algebra, whose order of summation depends on the
processor. The key `tolerances` of the manifest is for human readers only; the comparison does not use it.
"""

import hashlib
import json
import pathlib
import re

from common.documents import schema
from common.documents.json_reader import read
from common.errors import ComputationError
from common.files import sha256, write_json
from workflow.provenance import product_files

SCHEMA = "vci-manifest-1"
# Kinds of result files that must have the same bits: {kind: pattern of the path in a case's folder}. The first pattern
# that fits a path gives its kind.
SAME_BITS = {
    "settings": r"settings/.*\.json",
    "vessel": r"source/.*\.(vtp|json)",
    "anatomy": r"anatomy/.*\.(vtp|csv|json)",
    "deployment": r"(vci|rc)/.*\.(vtp|stl|csv|json)",
    "mesh": r"flow/(pre|vci|rc)/mesh.*",
}
RELATIVE_TOLERANCE = {"mean_area_mm2": 0.002, "minimum_area_mm2": 0.002, "mean_curvature_per_mm": 0.002}
# Endings of JSON keys whose values differ from run to run.
VARYING_KEY_ENDINGS = ("seconds", "timings_s", "peak_memory_mib", "path")


def write_manifest(study, out):
    """Writes the manifest `out` of a finished study (folder of results), with the cases of its provenance.json."""
    write_json(out, build_manifest(study))


def build_manifest(study):
    """The manifest's document for a folder of results. Raises InputError if a file is missing."""
    study = pathlib.Path(study)
    provenance = read(study / "study" / "provenance.json", "vci-provenance-1").data
    software = provenance["software"]
    return {
        "schema": SCHEMA,
        "made_on": {
            "system": software["system"],
            "processor": provenance["processor"],
            "environment": provenance["environment"],
            "packages": software["packages"],
        },
        "tolerances": {
            **{kind: "same bits" for kind in SAME_BITS},
            "ffr": "its error_estimate",
            **{key: f"{share:g} of the value" for key, share in RELATIVE_TOLERANCE.items()},
        },
        "cases": {case: _case_entry(study / "cases" / case) for case in provenance["cases"]},
    }


def read_manifest(path):
    """The document of the manifest at `path`. Raises InputError if it is none."""
    remedy = "give a manifest of config/manifests, or one of `workflow manifest`"
    document = read(path, SCHEMA, remedy)
    schema.validate(document, schema.read("manifest"), "a manifest", remedy)
    return document.data


def differences(expected, found):
    """(number of comparisons, messages) of two manifests' documents: `expected` ships, `found` is of this study.

    Each message names a difference: its case, the product or number, and both values.
    """
    compared, messages = 0, []
    for case, expected_case in expected["cases"].items():
        if case not in found["cases"]:
            messages.append(f"{case}: not in this study")
            continue
        count, case_messages = _case_differences(expected_case, found["cases"][case])
        compared += count
        messages += [f"{case}: {message}" for message in case_messages]
    return compared, messages


def verify(manifest, study):
    """Compares a finished study (folder of results) with a manifest that ships; returns the number of comparisons.

    Raises ComputationError, which lists the differences, or InputError for a file that cannot be read.
    """
    expected, found = read_manifest(manifest), build_manifest(study)
    compared, messages = differences(expected, found)
    if messages:
        shipped, present = expected["made_on"], found["made_on"]
        environment_differences = [
            f"{name} {version} here, {shipped['packages'].get(name, 'none')} there"
            for name, version in present["packages"].items()
            if shipped["packages"].get(name) != version
        ]
        environment_differences += [
            f"{key}: {present[key] or 'none'} here, {shipped[key] or 'none'} there"
            for key in ("system", "processor", "environment")
            if present[key] != shipped[key]
        ]
        lines = "\n          ".join(messages + [f"(not compared: {line})" for line in environment_differences])
        remedy = "the first line that differs comes first in the flow of files; see docs/workflow.md, "
        remedy += "The same results on another machine"
        raise ComputationError(f"{len(messages)} of {compared} comparisons differ", study, lines, remedy)
    return compared


def product_digest(file):
    """SHA-256 of a product. Keys of a JSON file that differ between runs, such as seconds, are left out."""
    if file.suffix != ".json":
        return sha256(file)
    kept = _without_varying_keys(read(file, "JSON").data)
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()


def _without_varying_keys(value):
    if isinstance(value, dict):
        return {
            key: _without_varying_keys(inner) for key, inner in value.items() if not key.endswith(VARYING_KEY_ENDINGS)
        }
    return [_without_varying_keys(inner) for inner in value] if isinstance(value, list) else value


def _case_entry(folder):
    same = {kind: {} for kind in SAME_BITS}
    for file in product_files(folder):
        name = str(file.relative_to(folder))
        kind = next((kind for kind, pattern in SAME_BITS.items() if re.fullmatch(pattern, name)), None)
        if kind:
            same[kind][name] = product_digest(file)
    states = read(folder / "metrics.json", "vci-metrics-1").data["states"]
    return {"same": same, "numbers": {state: _compared_numbers(document) for state, document in states.items()}}


def _compared_numbers(state):
    """The numbers of a state in metrics.json that are compared; FFR and its error estimate only if it has a flow."""
    numbers = {
        "mean_area_mm2": state["area"]["mean_mm2"],
        "minimum_area_mm2": state["area"]["minimum_mm2"],
        "mean_curvature_per_mm": state["curvature"]["mean_per_mm"],
    }
    if state["ffr"]:
        numbers |= {"ffr": state["ffr"]["distal"], "ffr_error_estimate": state["ffr"]["error_estimate"]}
    return numbers


def _case_differences(expected, found):
    compared, messages = 0, []
    for kind, files in expected["same"].items():
        others = found["same"][kind]
        for name in files | others:
            compared += 1
            if name not in files or name not in others:
                messages.append(f"{kind}: {name} is {'not there' if name in files else 'not in the manifest'}")
            elif files[name] != others[name]:
                messages.append(f"{kind}: {name} has other bits ({others[name][:12]}, not {files[name][:12]})")
    for state, numbers in expected["numbers"].items():
        others = found["numbers"].get(state)
        if others is None:
            compared += 1
            messages.append(f"state {state} is not there")
            continue
        for key, value in numbers.items():
            if key == "ffr_error_estimate":
                continue
            compared += 1
            message = _number_difference(key, value, others.get(key), numbers)
            messages += [f"{state}: {message}"] if message else []
    return compared, messages


def _number_difference(key, value, other, numbers):
    """How a number differs, or None if it agrees. An FFR without an error estimate must be equal."""
    if other is None:
        return f"{key} is not there"
    allowed = numbers["ffr_error_estimate"] or 0.0 if key == "ffr" else RELATIVE_TOLERANCE[key] * abs(value)
    if abs(other - value) <= allowed:
        return None
    return f"{key} {other:.6g}, not {value:.6g} within {allowed:.2g}"

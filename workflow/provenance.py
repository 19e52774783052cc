"""How the results of a study were made: hashes of inputs and products, versions, seeds, and every command."""

import os
import pathlib

from common.errors import InputError
from common.files import sha256, write_json
from common.machine import machine
from common.documents.json_reader import read

SCHEMA = "vci-provenance-1"
CASE_ENTRIES = {
    "settings",
    "source",
    "anatomy",
    "vci",
    "flow",
    "metrics.json",
    "plans",
    "sensitivity",
}  # files and folders of every case, beside the folders of its states
CT_ENTRIES = {"ct", "ct_pre", "half_maximum"}
# environment variables that may change the last bits of a number
ENVIRONMENT_VARIABLES = ("GLIBC_TUNABLES", "NPY_DISABLE_CPU_FEATURES", "OMP_NUM_THREADS", "OPENBLAS_CORETYPE")


def write_provenance(configuration, cases, results, programs, software, out):
    """Writes `out` (JSON) for the finished `cases` of a `Configuration`.

    results: root of the products. programs: the compiled programs and modules. software: software.json of the same run.
    Raises InputError for a case that is not finished, or whose log holds no command.
    """
    document = {
        "schema": SCHEMA,
        "software": read(software, "vci-software-1").data,
        "processor": machine()["processor"],
        "environment": {name: os.environ[name] for name in ENVIRONMENT_VARIABLES if name in os.environ},
        "programs": {pathlib.Path(program).name: sha256(program) for program in programs},
        "study": _file_hashes([configuration.folder / "study.yaml"]),
        "cases": {case: _case_entry(configuration, case, pathlib.Path(results) / "cases" / case) for case in cases},
    }
    write_json(out, document)


def product_files(folder):
    """The products in a case's folder, sorted: files of the case and of the states that metrics.json lists.

    Logs, benchmarks and files left by an earlier run with other states are left out. Raises InputError if metrics.json
    is missing.
    """
    folder = pathlib.Path(folder)
    metrics = folder / "metrics.json"
    if not metrics.is_file():
        raise InputError("case is not finished", metrics, "no such file", f"make study CASES={folder.name}")
    states = set(read(metrics, "vci-metrics-1").data["states"])
    return [
        file for file in sorted(folder.rglob("*")) if file.is_file() and _is_product(file.relative_to(folder), states)
    ]


def _is_product(path, states):
    """Whether a path, relative to a case's folder, is a product of a case that has these states."""
    if path.name.startswith("."):
        return False  # left by a step that was killed
    if path.parts[0] == "flow" and len(path.parts) > 2:
        return path.parts[1] in states
    return path.parts[0] in CASE_ENTRIES | states | (CT_ENTRIES if "ct" in states else set())


def _case_entry(configuration, case, folder):
    products = product_files(folder)
    inputs = [
        configuration.case_file(case),
        *configuration.device_files(case),
        *_user_files(configuration, case),
    ]
    return {
        "inputs": _file_hashes(inputs),
        "seeds": dict(_find_seeds({**configuration.cases[case], "settings": configuration.settings(case)})),
        "commands": _read_commands(folder / "logs"),
        "products": {str(file.relative_to(folder)): sha256(file) for file in products},
    }


def _user_files(configuration, case):
    """The user's surfaces, caps, volumes and tables that a case names."""
    found = []
    for key in ("lumen", "post"):
        if "path" in configuration.cases[case].get(key, {}):
            found.append(configuration.lumen_file(case, key))
        found += configuration.cap_files(case, key)
        found += [*configuration.ct_files(case, key).values(), *configuration.contour_files(case, key).values()]
    return found


def _file_hashes(files):
    """{file: SHA-256}. A folder, such as a DICOM series, is replaced by its files."""
    files = [
        inner for file in map(pathlib.Path, files) for inner in (sorted(file.rglob("*")) if file.is_dir() else [file])
    ]
    return {str(file): sha256(file) for file in files if file.is_file()}


def _find_seeds(value, where=""):
    """(dotted key, seed) of every key `seed` in nested dicts and lists."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        if key == "seed":
            yield f"{where}{key}", inner
        yield from _find_seeds(inner, f"{where}{key}.")


def _read_commands(logs):
    """{log: command} of a case's steps. workflow/run.sh writes the command as the first line of the log."""
    found = {}
    for log in sorted(logs.rglob("*.log")):
        with open(log, errors="replace") as stream:
            first = stream.readline()
        if not first:  # the log of a rule that does not use run.sh, such as `settings`
            continue
        if not first.startswith("$ "):
            raise InputError(
                "log without its command", log, first.strip()[:80], "run the step again (snakemake --force)"
            )
        found[str(log.relative_to(logs))] = first[2:].rstrip("\n")
    return found

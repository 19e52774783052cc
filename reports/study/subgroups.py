"""Tables of a cohort of randomly drawn patients: agreement by subgroup, and why patients failed."""

import pathlib

import pandas as pd

from common.documents import config
from common.errors import InputError, error_sentence
from reports.inputs.reading import read_json
from reports.study.agreement import agreement_table

SMALL_OSTIUM_MM, SEVERE_PERCENT = 4.0, 70  # limits between the subgroups: diameter at the ostium, diameter stenosis
FAILURE_COLUMNS = ["step", "reason", "patients", "example"]


def patient_files(cohort, cases):
    """{case: (its case file, its folder of results)} of all patients of a drawn cohort.

    cohort: the folder of `workflow cohort`, which holds the patients in shards; cases: results/cases.
    """
    cohort, cases = pathlib.Path(cohort), pathlib.Path(cases)
    files = sorted(cohort.glob("shards/*/cases/*.yaml"))
    if not files:
        raise InputError(
            "no patients", cohort, "no file shards/*/cases/*.yaml", "give a folder made by `workflow cohort`"
        )
    return {file.stem: (file, cases / file.stem) for file in files}


def patient_subgroups(case):
    """The subgroups {name: value} of a drawn patient, from its case file's content."""
    vessel = case["vessel"]
    lesion = vessel["lesions"][0]
    severe = lesion["diameter_stenosis_percent"] >= SEVERE_PERCENT
    small = vessel["main"]["ostial_diameter_mm"] < SMALL_OSTIUM_MM
    return {
        "all": "all",
        "artery": vessel["artery"],
        "lesion": lesion["shape"],
        "plaque": lesion["plaque"],
        "calcium": "some" if "calcium" in lesion else "none",
        "stenosis": f"{SEVERE_PERCENT} % and more" if severe else f"below {SEVERE_PERCENT} %",
        "ostium": f"below {SMALL_OSTIUM_MM:g} mm" if small else f"{SMALL_OSTIUM_MM:g} mm and more",
    }


def subgroup_tables(patients):
    """(agreement by subgroup, failures by step and reason) as DataFrames. patients: result of patient_files."""
    groups, failures = {}, {}
    for name, (file, folder) in patients.items():
        if (folder / "metrics.json").is_file():
            document = read_json(folder / "metrics.json", "reports metrics")
            for group in patient_subgroups(config.load_case(file)).items():
                groups.setdefault(group, []).append(document)
        else:
            failures.setdefault(failure_reason(folder), []).append(name)
    tables = []
    for (group, value), documents in sorted(groups.items(), key=lambda item: (item[0][0] != "all", item[0])):
        table = agreement_table(documents)
        table.insert(0, "subgroup", group)
        table.insert(1, "value", value)
        tables.append(table.drop(columns=[name for name in table if name.startswith("published")]))
    rows = [(*key, len(names), names[0]) for key, names in sorted(failures.items(), key=lambda item: -len(item[1]))]
    agreement = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
    return agreement, pd.DataFrame(rows, columns=FAILURE_COLUMNS)


def failure_reason(folder):
    """The (step, reason) at which a patient failed, from the newest log with an error; ("", "not run") without logs."""
    logs = sorted(folder.rglob("logs/**/*.log"), key=lambda file: file.stat().st_mtime, reverse=True)
    for log in logs:
        reason = error_sentence(log.read_text(errors="replace"))
        if reason:
            return str(log.relative_to(folder / "logs").with_suffix("")), reason
    if not logs:
        return "", "not run"
    return str(logs[0].relative_to(folder / "logs").with_suffix("")), "stopped without a message"

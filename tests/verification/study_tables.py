"""Tables of docs/nine-patients.md from the results of `make study`.

    /usr/bin/python3 tests/verification/study_tables.py results

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`; where its file is not there the table stays.
"""

import csv
import json
import pathlib
import sys

import numpy as np
import pandas as pd

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).resolve().parents[2])]

from page_tables import Page, markdown  # noqa: E402
from study_reference import throats, truth_errors  # noqa: E402

from reports.__main__ import read_metrics  # noqa: E402
from reports.page.digits import signed_decimals  # noqa: E402
from reports.study.agreement import published_results  # noqa: E402
from reports.study.nearer import nearer_table  # noqa: E402

STATES_AFTER = ("reference", "vci", "rc")
DIGITS = {"ffr": 3, "mean_area": 2, "minimum_area": 2, "mean_curvature": 3}
PUBLISHED_DIGITS = published_results()["decimals"]  # as many as the source prints
QUANTITY_NAMES = {"ffr": "FFR", "mean_area": "mean area, mm2", "minimum_area": "smallest area, mm2"}
QUANTITY_NAMES |= {"mean_curvature": "mean curvature, 1/mm"}
COMPARISON_NAMES = {
    "vci_minus_reference": "VCI, method",
    "rc_minus_reference": "radius correction, method",
    "ct_vci_minus_vci": "VCI, imaging before",
    "ct_rc_minus_rc": "radius correction, imaging before",
    "ct_minus_reference": "imaging after",
    "ct_vci_minus_ct": "VCI, all together",
    "ct_rc_minus_ct": "radius correction, all together",
}


def read_rows(results, name):
    """Rows of a table of results/study; None where it is not there."""
    path = results / "study" / f"{name}.csv"
    if not path.is_file():
        return None
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def format_number(text, digits, sign=""):
    """A number as the page writes it; empty where there is none."""
    return f"{float(text):{sign}.{digits}f}" if text else ""


def format_small(text, least):
    """A difference as the report's page writes it: `least` decimals, or more if two significant digits need them."""
    return signed_decimals(float(text), least).replace("−", "-")


def format_published(mean, sd):
    """A published mean and its ± with the digits of the source, such as -0.02 ± 0.05; empty where there is none."""
    return " ± ".join(format_number(text, PUBLISHED_DIGITS) for text in (mean, sd) if text)


def patients(results):
    """Markdown with a row a patient: FFR before and after, areas after."""
    rows = read_rows(results, "cohort")
    if rows is None:
        return None
    headings = ["patient", "FFR before", *(f"FFR, {state}" for state in STATES_AFTER)]
    headings += [f"{area}, {state}" for area in ("mean area", "smallest") for state in STATES_AFTER] + [
        "expansion index"
    ]
    table = []
    for row in rows:
        line = [row["case"], format_number(row["pre_ffr_distal"], 3)]
        line += [format_number(row[f"{state}_ffr_distal"], 3) for state in STATES_AFTER]
        line += [
            format_number(row[f"{state}_{area}_area_mm2"], 2) for area in ("mean", "minimum") for state in STATES_AFTER
        ]
        table.append([*line, format_number(row["deployment_expansion_index"], 2)])
    return markdown(headings, table)


def spread(results):
    """Markdown: mean and SD over the patients of FFR, mean area and curvature in each state."""
    rows = read_rows(results, "cohort")
    if rows is None:
        return None
    data = pd.DataFrame(rows).apply(pd.to_numeric, errors="coerce")
    kinds = {"FFR": ("ffr_distal", 3), "mean area, mm2": ("mean_area_mm2", 1)}
    kinds |= {"smallest area, mm2": ("minimum_area_mm2", 1), "mean curvature, 1/mm": ("mean_curvature_per_mm", 3)}
    states = [state for state in ("pre", *STATES_AFTER, "ct", "ct_vci") if f"{state}_ffr_distal" in data]
    table = []
    for words, (column, digits) in kinds.items():
        found = [data[f"{state}_{column}"].dropna() for state in states]
        means = [f"{one.mean():.{digits}f}" if len(one) else "" for one in found]
        deviations = [f" ± {one.std():.{digits}f}" if len(one) > 1 else "" for one in found]
        table.append([words, *(mean + deviation for mean, deviation in zip(means, deviations))])
    return markdown(["over the patients", *states], table)


def straightening(results):
    """Markdown: mean curvature before and after in each patient, and by what share of it each vessel is less bent."""
    rows = read_rows(results, "cohort")
    if rows is None:
        return None
    table, losses = [], {state: [] for state in STATES_AFTER}
    for row in rows:
        before, *after = (row[f"{state}_mean_curvature_per_mm"] for state in ("pre", *STATES_AFTER))
        line = [row["case"], *(format_number(text, DIGITS["mean_curvature"]) for text in (before, *after))]
        for state, text in zip(STATES_AFTER, after):
            loss = 100 * (1 - float(text) / float(before)) if text else None
            line.append("" if loss is None else f"{loss:.0f}")
            losses[state] += [] if loss is None else [loss]
        table.append(line)
    means = [
        f"{np.mean(found):.0f} ± {np.std(found, ddof=1):.0f}" if len(found) > 1 else "" for found in losses.values()
    ]
    table.append(["all", "", "", "", "", *means])
    headings = ["patient", "before, 1/mm", *(f"{state}, 1/mm" for state in STATES_AFTER)]
    return markdown([*headings, *(f"{state}: less by, %" for state in STATES_AFTER)], table)


def half_maximum(results):
    """`agreement` of the lumens that were found in the CT at half maximum."""
    return agreement(results, "half_maximum")


def agreement(results, name="agreement"):
    """Markdown: bias and SD of each comparison over the included patients, with the published one."""
    rows = read_rows(results, name)
    if rows is None:
        return None
    table = []
    for row in rows:
        if row["patients"] != "included" or row["comparison"] not in COMPARISON_NAMES:
            continue
        digits = DIGITS[row["quantity"]]
        published = format_published(row["published_bias"], row["published_sd"])
        low, high = (row[f"loa_{end}"] and format_small(row[f"loa_{end}"], digits) for end in ("lower", "upper"))
        line = [
            QUANTITY_NAMES[row["quantity"]],
            COMPARISON_NAMES[row["comparison"]],
            row["n"],
            format_small(row["bias"], digits),
        ]
        table.append([*line, format_number(row["sd"], digits + 1), f"{low} to {high}" if low else "", published])
    return markdown(["quantity", "error", "n", "bias", "SD", "limits of agreement", "published"], table)


def nearer(results):
    """Markdown: whether VCI or radius correction is nearer to the truth."""
    rows = read_rows(results, "nearer")
    return None if rows is None else nearer_markdown(rows)


def nearer_half_maximum(results):
    """The rows of `nearer` judged by CT, for the lumens that were found in the CT at half maximum."""
    found = sorted(results.glob("cases/*/half_maximum/metrics.json"))
    if not found:
        return None
    table = nearer_table(read_metrics(found))
    text = table[table["truth"] == "ct"].astype(object).where(table.notna(), "").astype(str)
    return nearer_markdown(text.to_dict("records"))


def nearer_markdown(rows):
    """Markdown of rows of nearer.csv (dicts of texts), of the included patients alone."""
    table = []
    for row in rows:
        if row["patients"] == "included":
            digits = DIGITS[row["quantity"]] + 1
            line = [QUANTITY_NAMES[row["quantity"]], row["truth"], format_number(row["error_vci"], digits)]
            line += [format_number(row["error_rc"], digits), f"{row['patients_vci_nearer']} of {row['n']}", row["ties"]]
            table.append([*line, format_number(row["p"], 3), row["vci_is"]])
    headings = ["quantity", "truth", "error of VCI", "error of radius correction", "VCI nearer", "ties", "p", "VCI is"]
    return markdown(headings, table)


def seconds(results):
    """Markdown: seconds of a deployment by stage and step, beside the published ones."""
    rows = read_rows(results, "seconds")
    if rows is None:
        return None
    table = []
    for row in rows:
        own = f"{float(row['mean_s']):.2f}" + (f" ± {float(row['sd_s']):.2f}" if row["sd_s"] else "")
        published = format_published(row["published_mean_s"], row["published_sd_s"])
        table.append([row["by"], row["name"], row["n"], own, published])
    return markdown(["by", "name", "n", "seconds", "published"], table)


def plans(results):
    """Markdown: FFR of the best plans by the calibrated network and in three dimensions; None before any was solved."""
    table = []
    for flow in sorted(results.glob("cases/*/plans/*/flow/ffr.json")):
        folder, solution = flow.parents[1], json.loads(flow.read_text())
        with (folder.parent / "ranking.csv").open(newline="") as file:
            ranked = {row["plan"]: row for row in csv.DictReader(file)}
        row, planned, found = ranked[folder.name], ranked["planned"], solution["ffr"]
        line = [
            flow.parents[3].name,
            row["rank"],
            row["plan"],
            row["procedure"],
            f"{float(row['balloon_to_artery']):.2f}",
        ]
        line += [f"{float(one['ffr']):.4f}" for one in (planned, row)] + [f"{float(row['ffr_error']):.4f}"]
        table.append([*line, f"{found:.4f}", f"{solution['error_estimate']['ffr']:.4f}"])
    if not table:
        return None
    table.sort(key=lambda line: (line[0], int(line[1])))
    headings = [
        "patient",
        "rank",
        "plan",
        "procedure",
        "balloon to artery",
        "FFR as planned",
        "FFR, network",
        "its error",
    ]
    return markdown([*headings, "FFR, 3D", "its estimate"], table)


def read_sensitivity(results, name):
    """A table of results/cases/*/sensitivity with the column `case` first; None where no case has it."""
    found = sorted(results.glob(f"cases/*/sensitivity/{name}.csv"))
    if not found:
        return None
    return pd.concat([pd.read_csv(path).assign(case=path.parts[-3]) for path in found], ignore_index=True)


def format_interval(row, digits):
    """`lower to upper` of an interval's row."""
    return f"{row.lower:.{digits}f} to {row.upper:.{digits}f}"


def intervals(results):
    """Markdown with a row a patient: FFR before and after, and the 95 % intervals over all inputs of the flow."""
    data = read_sensitivity(results, "flow_intervals")
    if data is None:
        return None
    table = []
    for case, rows in data[data["quantity"] == "ffr"].groupby("case"):
        line = [case]
        for state in ("pre", "vci"):
            row = rows[rows["state"] == state].iloc[0]
            line += [f"{row.planned:.3f}", format_interval(row, 3), f"{row.upper - row.lower:.3f}"]
        table.append(line)
    headings = ["patient"]
    headings += [f"{what} {when}" for when in ("before", "after") for what in ("FFR", "95 % interval", "width")]
    return markdown(headings, table)


def flow_inputs(results):
    """Markdown with a row for each input of the flow: the change of FFR over its range, mean and largest."""
    data = read_sensitivity(results, "flow")
    if data is None:
        return None
    data["low_change"], data["high_change"] = (data[end] - data["at_planned"] for end in ("at_low", "at_high"))
    data["size"] = data[["low_change", "high_change"]].abs().max(axis=1)
    table = []
    for name in data["input"].unique():
        rows = data[data["input"] == name]
        line = [rows["words"].iloc[0]]
        for state in ("pre", "vci"):
            one = rows[rows["state"] == state]
            line += [f"{one[f'{end}_change'].mean():+.4f}" for end in ("low", "high")] + [f"{one['size'].max():.4f}"]
        table.append((data.loc[rows.index, "size"].mean(), line))
    table.sort(key=lambda entry: -entry[0])
    headings = ["input"] + [
        f"{what}, {when}" for when in ("before", "after") for what in ("at the low end", "at the high end", "largest")
    ]
    return markdown(headings, [line for _, line in table])


def deployment_inputs(results):
    """Markdown with a row for each patient and input of the deployment: FFR after PCI and smallest stent area.

    Only patients whose `sensitivity/deployment.csv` was asked for.
    """
    data, limits = (read_sensitivity(results, name) for name in ("deployment", "deployment_intervals"))
    if data is None or limits is None:
        return None
    table = []
    for (case, name), rows in data.groupby(["case", "input"], sort=False):
        line = [case, rows["words"].iloc[0], f"{rows['low'].iloc[0]:g} to {rows['high'].iloc[0]:g}"]
        line[-1] += f" {rows['unit'].iloc[0]}"
        for quantity, digits in (("ffr", 4), ("minimal_stent_area_mm2", 2)):
            row = rows[rows["quantity"] == quantity].iloc[0]
            values = [row[end] for end in ("at_low", "at_planned", "at_high")]
            line.append(" / ".join("none" if np.isnan(value) else f"{value:.{digits}f}" for value in values))
        table.append(line)
    for case, rows in limits.groupby("case", sort=False):
        by_quantity = {row.quantity: row for row in rows.itertuples()}
        line = [case, "all of them and the inputs of the flow", "95 % interval"]
        line += [format_interval(by_quantity["ffr"], 4), format_interval(by_quantity["minimal_stent_area_mm2"], 2)]
        table.append(line)
    table.sort(key=lambda line: line[0])
    return markdown(["patient", "input", "range", "FFR after PCI", "smallest stent area, mm2"], table)


def cost(results):
    """Markdown: seconds by kind of step over all patients. Each step uses one core.

    They are wall time: Snakemake samples processor time, and misses the end of a step and its finished children. Steps
    whatif/<plan>/... are those of `make best-plans`, which are no part of the study.
    """
    rows = read_rows(results, "timings")
    if rows is None:
        return None
    data = pd.DataFrame([row for row in rows if row["source"] == "workflow"])
    data = data[~data["step"].str.fullmatch("whatif/.+/.+")]
    data["kind"] = data["step"].str.split("/").str[-1]
    for column in ("seconds", "peak_memory_mib"):
        data[column] = pd.to_numeric(data[column], errors="coerce")
    found = data.groupby("kind").agg(runs=("seconds", "size"), total=("seconds", "sum"), largest=("seconds", "max"))
    found["memory"] = data.groupby("kind")["peak_memory_mib"].max()
    found = found.sort_values("total", ascending=False)
    table = [
        [kind, f"{row.runs:.0f}", f"{row.total:.0f}", f"{row.largest:.0f}", f"{row.memory:.0f}"]
        for kind, row in found.head(10).iterrows()
    ]
    table.append(["all steps", f"{found.runs.sum():.0f}", f"{found.total.sum():.0f}", "", f"{found.memory.max():.0f}"])
    return markdown(["step", "runs", "seconds", "longest, s", "peak memory, MiB"], table)


TABLE_FUNCTIONS = {"patients": patients, "spread": spread, "agreement": agreement, "nearer": nearer, "seconds": seconds}
TABLE_FUNCTIONS |= {"half_maximum": half_maximum, "cost": cost, "plans": plans, "straightening": straightening}
TABLE_FUNCTIONS |= {
    "intervals": intervals,
    "flow_inputs": flow_inputs,
    "deployment_inputs": deployment_inputs,
    "throats": throats,
    "truth_errors": truth_errors,
    "nearer_half_maximum": nearer_half_maximum,
}
PAGE = Page("docs/nine-patients.md", {}, {}, TABLE_FUNCTIONS)

if __name__ == "__main__":
    PAGE.main()

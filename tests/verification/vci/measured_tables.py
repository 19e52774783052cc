"""Tables of vci/measured.md from the benchmarks' CSV files, and from contrast.csv of a study.

    /usr/bin/python3 tests/verification/vci/measured_tables.py results

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`. NAME is the folder of a benchmark, a cohort
of PREFIXES, or another key of TABLE_FUNCTIONS. A table stays as it is if it was not run. Below the tables of a cohort
stands the revision of the run.
"""

import functools
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[up]) for up in (1, 3)]

from page_tables import Page, markdown, read_columns  # noqa: E402

from common.documents.json_reader import read  # noqa: E402
from reports.study.agreement import published_results  # noqa: E402
from vci.benchmarks.published import NOT_COMPARED  # noqa: E402

# benchmark: (the file of its results, {column of the file: heading on the page})
TABLES = {
    "deployment_speed": (
        "medians.csv",
        {
            "edge_mm": "edge, mm",
            "residual_tolerance": "tolerance",
            "precision": "solves",
            "wall": "wall",
            "cases": "balanced",
            "steps": "steps",
            "cpu_seconds": "CPU s",
            "mean_csa_error_percent": "error of mean area, %",
            "mla_error_percent": "of minimal area, %",
            "microseconds_per_vertex_step": "microseconds per vertex and step",
            "peak_memory_mib": "MiB",
        },
    ),
    "deployment_baseline": (
        "levels.csv",
        {
            "case": "scene",
            "error_percent": "wanted, %",
            "contact": "textbook's contact",
            "default_edge_mm": "default: edge, mm",
            "default_cpu_seconds": "CPU s",
            "default_error_percent": "error, %",
            "textbook_edge_mm": "textbook: edge, mm",
            "textbook_step_ms": "step, ms",
            "textbook_stop_mm_per_ms": "stop, mm/ms",
            "textbook_cpu_seconds": "CPU s",
            "textbook_error_percent": "error, %",
            "times": "times",
        },
    ),
    "deployment_baseline_patients": (
        "patients.csv",
        {
            "case": "patient",
            "scheme": "scheme",
            "outcome": "outcome",
            "reason": "reason",
            "steps": "steps",
            "cpu_seconds": "CPU s",
            "times": "times the default",
            "max_penetration_mm": "deepest, mm",
            "mean_csa_error_percent": "error of mean area, %",
            "mla_error_percent": "of smallest area, %",
        },
    ),
    "deployment_sensitivity": (
        "sensitivity.csv",
        {
            "setting": "setting",
            "value": "value, mm",
            "case": "scene",
            "mean_csa_change_percent": "mean area, %",
            "mla_change_percent": "minimal area, %",
            "steps": "steps",
            "cpu_seconds": "CPU s",
        },
    ),
    "deployment_coarse_walls": (
        "summary.csv",
        {
            "wall_edge_mm": "wall, mm",
            "device_edge_mm": "devices, mm",
            "balanced": "balanced",
            "median_cpu_seconds": "median CPU s",
            "largest_cpu_seconds": "worst",
            "median_mean_csa_error_percent": "median error of mean area, %",
            "largest_mean_csa_error_percent": "worst, %",
            "median_mla_error_percent": "of smallest area, %",
            "largest_mla_error_percent": "its worst, %",
        },
    ),
    "deployment_calcium_strength": (
        "strength.csv",
        {
            "youngs_modulus_mpa": "MPa",
            "yield_strain": "yield strain",
            "hardening": "hardening",
            "strength_mpa": "strength, MPa",
            "expansion_90_percent": "expansion at 90 degrees, %",
            "expansion_180_percent": "180",
            "expansion_270_percent": "270",
            "change_percent": "change by 180 degrees, %",
            "spread_percent": "spread over first steps, %",
            "refused": "refused",
        },
    ),
    "deployment_against_published": (
        "published.csv",
        {
            "bench": "bench",
            "quantity": "quantity",
            "unit": "unit",
            "published": "published",
            "engine": "engine",
            "truth": "truth",
        },
    ),
    "deployment_hard_cases": (
        "hard_cases.csv",
        {
            "case": "case",
            "outcome": "outcome",
            "mean_penetration_mm": "mean penetration, mm",
            "worst_penetration_mm": "worst, mm",
            "within_limits": "within limits",
            "steps": "steps",
            "cpu_seconds": "CPU s",
            "minimal_area_mm2": "minimal area, mm2",
        },
    ),
}
FIRST_STEPS = {  # columns of first_steps.csv: their headings
    "case": "case",
    "refused": "refused",
    "folded": "wall folded",
    "fewest_steps": "fewest steps",
    "most_steps": "most",
    "worst_penetration_mm": "deepest, mm",
    "mean_area_spread_percent": "spread of mean area, %",
    "minimal_area_spread_percent": "of smallest area, %",
}
DIGITS = {
    "max_penetration_mm": ".3f",
    "mean_area_spread_percent": ".2f",
    "minimal_area_spread_percent": ".2f",
    "youngs_modulus_mpa": ".0f",
    "strength_mpa": ".1f",
    "expansion_90_percent": ".0f",
    "expansion_180_percent": ".0f",
    "expansion_270_percent": ".0f",
    "change_percent": "+.1f",
    "spread_percent": ".1f",
    "median_cpu_seconds": ".1f",
    "largest_cpu_seconds": ".1f",
    "median_mean_csa_error_percent": ".1f",
    "largest_mean_csa_error_percent": "+.1f",
    "median_mla_error_percent": ".1f",
    "largest_mla_error_percent": "+.1f",
    "steps": ".0f",
    "cpu_seconds": ".2f",
    "microseconds_per_vertex_step": ".1f",
    "peak_memory_mib": ".0f",
    "mean_csa_error_percent": ".1f",
    "mla_error_percent": ".1f",
    "default_cpu_seconds": ".2f",
    "default_error_percent": "+.1f",
    "textbook_cpu_seconds": ".1f",
    "textbook_error_percent": "+.1f",
    "times": ".1f",
    "mean_csa_change_percent": "+.2f",
    "mla_change_percent": "+.2f",
    "mean_penetration_mm": ".4f",
    "worst_penetration_mm": ".3f",
    "minimal_area_mm2": ".1f",
}
PREFIXES = {"contrast": "contrast_", "pressures": "pressure_"}  # cohort: first part of the names of its cases
# quantity of contrast.csv: its heading, and the format of its errors
CONTRAST_ERRORS = {
    "area_profile": ("rms of the area along the stent, mm2", ".2f"),
    "mean_area": ("mean area, mm2", "+.2f"),
    "minimum_area": ("smallest area, mm2", "+.2f"),
    "ffr": ("FFR", "+.4f"),
    "mean_curvature": ("mean curvature, 1/mm", "+.3f"),
}
CONTRAST_HEADINGS = ["case", "truth: mean and smallest area, mm2"]
CONTRAST_HEADINGS += [f"{heading}: VCI, radius correction (stent alone)" for heading, _ in CONTRAST_ERRORS.values()]
EXAMPLE_HEADINGS = ["case", "FFR after PCI", "radius correction, stent alone", "VCI"]
EXAMPLE_HEADINGS += ["error of radius correction", "error of VCI"]


def contrast_rows(results, cohort):
    """{case without the cohort's prefix: {quantity: row}} of contrast.csv in a folder of results; empty if not run.

    A row is a dict of strings. Raises InputError if the file has other columns than today's.
    """
    path, prefix, cases = results / "study" / "contrast.csv", PREFIXES[cohort], {}
    if path.is_file():
        for row in read_columns(path, ["case", "quantity", "value", "error_vci", "error_rc", "error_rc_stent"]):
            if row["case"].startswith(prefix):
                cases.setdefault(row["case"].removeprefix(prefix), {})[row["quantity"]] = row
    return cases


def errors_of_both_methods(results, cohort):
    """Markdown with a row for each case of a cohort, and the run's revision; None if contrast.csv has no such case.

    A cell has the errors of VCI and of radius correction by the largest balloon. In parentheses follows the error of
    radius correction by the stents alone, if the case has that reading.
    """
    rows = []
    for case, found in contrast_rows(results, cohort).items():
        areas = [f"{float(found[name]['value']):.2f}" for name in ("mean_area", "minimum_area")]
        row = [f"`{case}`", ", ".join(areas)]
        for quantity, (_, digits) in CONTRAST_ERRORS.items():
            errors = found.get(quantity, {})
            vci, largest, alone = (
                f"{float(errors[column]):{digits}}" if errors.get(column) else ""
                for column in ("error_vci", "error_rc", "error_rc_stent")
            )
            readings = " ".join(filter(None, [largest, f"({alone})" if alone else ""]))
            row.append(", ".join(filter(None, [vci, readings])))
        rows.append(row)
    return f"{markdown(CONTRAST_HEADINGS, rows)}\n{run_note(results)}\n" if rows else None


def example_of_the_source(results):
    """Markdown: FFR by radius correction of the stent alone, by VCI and after PCI, in the source and in the cases.

    A case of the cohort `contrast` has a row if it has that reading. None if contrast.csv has no such case.
    """
    rows = []
    for case, found in contrast_rows(results, "contrast").items():
        ffr = found.get("ffr", {})
        if ffr.get("error_rc_stent"):
            after, *errors = (float(ffr[column]) for column in ("value", "error_rc_stent", "error_vci"))
            rows.append(example_row(f"`{case}`", after, errors, 4))
    if not rows:
        return None
    example = published_results()["example"]
    after, *predicted = (example["ffr"][key] for key in ("after", "rc_stent", "vci"))
    source = example_row(f"Lyu et al., figure {example['figure']}", after, [found - after for found in predicted], 2)
    return f"{markdown(EXAMPLE_HEADINGS, [source, *rows])}\n{run_note(results)}\n"


def example_row(name, after, errors, digits):
    """Cells of a row of the example: FFR `after` PCI, and both predictions with their `errors` (a list of two)."""
    predicted = [f"{after + error:.{digits}f}" for error in errors]
    return [name, f"{after:.{digits}f}", *predicted, *(f"{error:+.{digits}f}" for error in errors)]


def run_note(results):
    """A sentence with the revision of the study in a folder of results. Raises InputError for a damaged file."""
    file = results / "study" / "provenance.json"
    if not file.is_file():
        return "The revision of this run was not written down."
    software = read(file, "vci-provenance-1").data["software"]
    changed = ", with changes that were not committed" if software["modified"] else ""
    return f"Run of revision {software['revision'][:8]}{changed}."


def not_compared(results):
    """Markdown: published measurements without a figure of ours, from NOT_COMPARED. `results` is not used."""
    rows = [[entry.measured, entry.reason, entry.source] for entry in NOT_COMPARED]
    return markdown(["published", "why there is no figure of ours", "source"], rows)


def differences_by_first_step(results):
    """Markdown of first_steps.csv of the hard cases; None if they were not run with other first steps."""
    path = results / "benchmarks" / "deployment_hard_cases" / "first_steps.csv"
    return PAGE.table(path, FIRST_STEPS) if path.is_file() else None


TABLE_FUNCTIONS = {cohort: functools.partial(errors_of_both_methods, cohort=cohort) for cohort in PREFIXES}
TABLE_FUNCTIONS |= {"first_steps": differences_by_first_step, "contrast_example": example_of_the_source}
TABLE_FUNCTIONS["not_compared"] = not_compared
PAGE = Page("vci", TABLES, DIGITS, TABLE_FUNCTIONS)

if __name__ == "__main__":
    PAGE.main()

"""Compares a finished study with the manifest of a system that has other versions of the libraries.

CGAL and gmsh make other surfaces and meshes on another Debian, so the files' bits differ. The patient's results must
agree: areas and curvature within RELATIVE_TOLERANCE, FFR within the sum of both error estimates.
"""

import pathlib

from common.errors import ComputationError
from common.files import replacing
from workflow.manifest import build_manifest, read_manifest

RELATIVE_TOLERANCE = {
    "mean_area_mm2": 0.01,
    "minimum_area_mm2": 0.02,
    "mean_curvature_per_mm": 0.05,
}  # shares of the value
QUANTITY_NAMES = {
    "mean_area_mm2": "mean area (mm²)",
    "minimum_area_mm2": "smallest area (mm²)",
    "mean_curvature_per_mm": "mean curvature (1/mm)",
    "ffr": "FFR",
}


def write_agreement(manifest, study, out):
    """Writes the page `out` of the comparison; returns the number of numbers compared.

    manifest: file config/manifests/<cohort>.json, which gives the cohort's name; study: folder of results. Raises
    InputError if a file cannot be read. Raises ComputationError, after writing the page, if a number differs by more
    than is allowed.
    """
    expected, found = read_manifest(manifest), build_manifest(study)
    cohort = pathlib.Path(manifest).stem
    rows = compare_numbers(expected, found)
    with replacing(out) as partial:
        partial.write_text(markdown_page(cohort, expected, found, rows))
    deviating = [row for row in rows if not row["within"]]
    if deviating:
        lines = "\n          ".join(
            f"{row['case']}: {row['state']}: {row['key']} {_format_value(row, 'found')}" for row in deviating
        )
        raise ComputationError(
            f"{len(deviating)} of {len(rows)} numbers differ by more than is allowed", out, lines, "see the page"
        )
    return len(rows)


def compare_numbers(expected, found):
    """A row for each number of two manifests' documents.

    Its keys are case, state, key, expected, found, difference, allowed and within. The difference is absolute for FFR
    and relative to `expected` for all other numbers. If the number is missing, `found` and `difference` are None and
    `within` is False.
    """
    rows = []
    for case, wanted in expected["cases"].items():
        states = found["cases"].get(case, {"numbers": {}})["numbers"]
        for state, numbers in wanted["numbers"].items():
            others = states.get(state, {})
            estimates = sum(one.get("ffr_error_estimate") or 0.0 for one in (numbers, others))
            for key in (key for key in QUANTITY_NAMES if key in numbers):
                value, other, allowed = numbers[key], others.get(key), RELATIVE_TOLERANCE.get(key, estimates)
                difference = (
                    None if other is None else (other - value) / (abs(value) if key in RELATIVE_TOLERANCE else 1.0)
                )
                row = {
                    "case": case,
                    "state": state,
                    "key": key,
                    "expected": value,
                    "found": other,
                    "difference": difference,
                }
                rows.append(
                    {**row, "allowed": allowed, "within": difference is not None and abs(difference) <= allowed}
                )
    return rows


def markdown_page(cohort, expected, found, rows):
    """The comparison as Markdown. expected, found: documents of both manifests. rows: result of `compare_numbers`."""
    shipped, present = expected["made_on"], found["made_on"]
    shipped_system, this_system = _short_system_name(shipped["system"]), _short_system_name(present["system"])
    deviating = [row for row in rows if not row["within"]]
    lines = [
        f"# The {cohort} cohort on {this_system} and {shipped_system}",
        "",
        "Do newer libraries change the results? Other versions of CGAL, gmsh, FEniCSx and VTK make other meshes from "
        f"the same vessel. This page compares the cases of the {cohort} cohort on both systems.",
        "`python3 -m workflow agreement` "
        f"wrote it on {this_system}. The numbers of {shipped_system} are those of the manifest that ships.",
        "",
        f"Of {len(rows)} numbers {len(rows) - len(deviating)} agree as far as is asked: areas within "
        f"{RELATIVE_TOLERANCE['mean_area_mm2']:.0%} (mean) and "
        f"{RELATIVE_TOLERANCE['minimum_area_mm2']:.0%} (smallest), "
        f"mean curvature within {RELATIVE_TOLERANCE['mean_curvature_per_mm']:.0%}, "
        "FFR within both error estimates together.",
        "",
        "## Largest differences",
        "The row of each quantity that differs most. Differences are relative, those of FFR absolute.",
        "",
        f"| | where | {shipped_system} | {this_system} | difference | allowed |",
        "| --- | --- | --- | --- | --- | --- |",
        *(
            _largest_difference_row([row for row in rows if row["key"] == key])
            for key in QUANTITY_NAMES
            if any(r["key"] == key for r in rows)
        ),
        "",
        "## All numbers",
        "Areas and curvature are over the treated segment, FFR is past the lesion. [design.md](design.md#states) lists "
        "the states. A difference in bold is larger than allowed.",
        "",
        f"| case | state | | {shipped_system} | {this_system} | difference | allowed |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        *(_table_row(row) for row in rows),
        "",
        "## Files of the same bits",
        "How many files are identical on both systems? Those that depend on a mesh are not expected to be.",
        "",
        "| kind | files | the same bits |",
        "| --- | --- | --- |",
        *_identical_file_rows(expected, found),
        "",
        "## Versions that differ",
        "The packages of which the two systems have other versions.",
        "",
        f"| package | {shipped_system} | {this_system} |",
        "| --- | --- | --- |",
    ]
    names = sorted(shipped["packages"].keys() | present["packages"].keys())
    pairs = [(name, shipped["packages"].get(name, "none"), present["packages"].get(name, "none")) for name in names]
    lines += [f"| `{name}` | {one} | {other} |" for name, one, other in pairs if one != other]
    return "\n".join(lines) + "\n"


def _short_system_name(system):
    """Name of the operating system without "GNU/Linux" and the release's nickname."""
    return system.replace("GNU/Linux ", "").partition(" (")[0]


def _format_value(row, key):
    if row[key] is None:
        return "missing"
    return f"{row[key]:.4f}" if row["key"] in ("ffr", "mean_curvature_per_mm") else f"{row[key]:.3f}"


def _number_cells(row):
    """The last cells of a row's line: expected, found, difference and allowed difference."""
    number_format = "{:+.4f}" if row["key"] == "ffr" else "{:+.2%}"
    difference = "missing" if row["difference"] is None else number_format.format(row["difference"])
    bold = "" if row["within"] else "**"
    allowed = number_format.format(row["allowed"]).lstrip("+")
    return f"{_format_value(row, 'expected')} | {_format_value(row, 'found')} | {bold}{difference}{bold} | {allowed}"


def _table_row(row):
    return f"| {row['case']} | {row['state']} | {QUANTITY_NAMES[row['key']]} | {_number_cells(row)} |"


def _largest_difference_row(rows):
    """The table line of the row with the largest difference."""
    row = max(rows, key=lambda row: float("inf") if row["difference"] is None else abs(row["difference"]))
    return f"| {QUANTITY_NAMES[row['key']]} | {row['case']}, {row['state']} | {_number_cells(row)} |"


def _identical_file_rows(expected, found):
    """A table line for each kind of product: the number of files, and how many of them have the same bits."""
    lines = []
    kinds = next(iter(expected["cases"].values()))["same"]
    for kind in kinds:
        pairs = [
            (digest, found["cases"].get(case, {"same": {}})["same"].get(kind, {}).get(name))
            for case, wanted in expected["cases"].items()
            for name, digest in wanted["same"][kind].items()
        ]
        lines.append(f"| {kind} | {len(pairs)} | {sum(one == other for one, other in pairs)} |")
    return lines

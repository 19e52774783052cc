"""Compares a finished study with the manifest of a system that has other versions of the libraries.

CGAL and gmsh make other surfaces and meshes on another Debian, so the files' bits differ. The patient's results must
agree: areas and curvature within ALLOWED, FFR within the sum of both error estimates.
"""

import pathlib

from common.errors import ComputationError
from common.files import replacing
from common.documents.json_reader import read
from workflow.manifest import SCHEMA, manifest_of

ALLOWED = {"mean_area_mm2": 0.01, "minimum_area_mm2": 0.02, "mean_curvature_per_mm": 0.05}  # shares of the value
NAMES = {
    "mean_area_mm2": "mean area (mm²)",
    "minimum_area_mm2": "smallest area (mm²)",
    "mean_curvature_per_mm": "mean curvature (1/mm)",
    "ffr": "FFR",
}


def write_agreement(manifest, study, out):
    """Writes the page `out` of the comparison; returns the number of numbers compared.

    manifest: file config/manifests/<cohort>.json, whose name is that of the cohort; study: folder of results. Raises
    InputError if a file cannot be read. Raises ComputationError, after writing the page, if a number differs by more
    than is allowed.
    """
    expected, found = read(manifest, SCHEMA).data, manifest_of(study)
    cohort = pathlib.Path(manifest).stem
    rows = compared(expected, found)
    with replacing(out) as partial:
        partial.write_text(page(cohort, expected, found, rows))
    beyond = [row for row in rows if not row["within"]]
    if beyond:
        lines = "\n          ".join(
            f"{row['case']}: {row['state']}: {row['key']} {_value(row, 'found')}" for row in beyond
        )
        raise ComputationError(
            f"{len(beyond)} of {len(rows)} numbers differ by more than is allowed", out, lines, "see the page"
        )
    return len(rows)


def compared(expected, found):
    """A row {case, state, key, expected, found, off, allowed, within} for each number of two manifests' documents.

    off: the difference. It is absolute for FFR and relative to `expected` for all other numbers. If the number is
    missing, `found` and `off` are None and `within` is False.
    """
    rows = []
    for case, wanted in expected["cases"].items():
        states = found["cases"].get(case, {"numbers": {}})["numbers"]
        for state, numbers in wanted["numbers"].items():
            others = states.get(state, {})
            estimates = sum(one.get("ffr_error_estimate") or 0.0 for one in (numbers, others))
            for key in (key for key in NAMES if key in numbers):
                value, other, allowed = numbers[key], others.get(key), ALLOWED.get(key, estimates)
                off = None if other is None else (other - value) / (abs(value) if key in ALLOWED else 1.0)
                row = {"case": case, "state": state, "key": key, "expected": value, "found": other, "off": off}
                rows.append({**row, "allowed": allowed, "within": off is not None and abs(off) <= allowed})
    return rows


def page(cohort, expected, found, rows):
    """The comparison as Markdown. cohort: its name; expected, found: as for `compared`, whose result is `rows`."""
    before, now = expected["made_on"], found["made_on"]
    there, here = before["system"], now["system"]
    off = [row for row in rows if not row["within"]]
    lines = [
        f"# The {cohort} cohort on {_short(here)} and {_short(there)}",
        "",
        f"Written by `python3 -m workflow agreement` on {_short(here)}; {_short(there)} is the manifest that ships.",
        f"Of {len(rows)} numbers {len(rows) - len(off)} agree as far as is asked: areas within "
        f"{ALLOWED['mean_area_mm2']:.0%} (mean) and {ALLOWED['minimum_area_mm2']:.0%} (smallest), "
        f"mean curvature within {ALLOWED['mean_curvature_per_mm']:.0%}, FFR within both error estimates together.",
        "",
        "## Largest differences",
        f"| | where | {_short(there)} | {_short(here)} | difference | allowed |",
        "| --- | --- | --- | --- | --- | --- |",
        *(_largest([row for row in rows if row["key"] == key]) for key in NAMES if any(r["key"] == key for r in rows)),
        "",
        "## All numbers",
        "Over the treated segment, and FFR past the lesion. Bold is further off than allowed.",
        "",
        f"| case | state | | {_short(there)} | {_short(here)} | difference | allowed |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        *(_row(row) for row in rows),
        "",
        "## Files of the same bits",
        "| kind | files | the same bits |",
        "| --- | --- | --- |",
        *_bits(expected, found),
        "",
        "## Versions that differ",
        f"| package | {_short(there)} | {_short(here)} |",
        "| --- | --- | --- |",
    ]
    names = sorted(before["packages"].keys() | now["packages"].keys())
    pairs = [(name, before["packages"].get(name, "none"), now["packages"].get(name, "none")) for name in names]
    lines += [f"| `{name}` | {one} | {other} |" for name, one, other in pairs if one != other]
    return "\n".join(lines) + "\n"


def _short(system):
    """Name of the operating system without "GNU/Linux" and the release's nickname."""
    return system.replace("GNU/Linux ", "").partition(" (")[0]


def _value(row, which):
    if row[which] is None:
        return "missing"
    return f"{row[which]:.4f}" if row["key"] in ("ffr", "mean_curvature_per_mm") else f"{row[which]:.3f}"


def _numbers(row):
    """The last cells of a row's line: expected, found, difference and allowed difference."""
    size = "{:+.4f}" if row["key"] == "ffr" else "{:+.2%}"
    off = "missing" if row["off"] is None else size.format(row["off"])
    mark = "" if row["within"] else "**"
    allowed = size.format(row["allowed"]).lstrip("+")
    return f"{_value(row, 'expected')} | {_value(row, 'found')} | {mark}{off}{mark} | {allowed}"


def _row(row):
    return f"| {row['case']} | {row['state']} | {NAMES[row['key']]} | {_numbers(row)} |"


def _largest(rows):
    """The table line of the row with the largest difference."""
    row = max(rows, key=lambda row: float("inf") if row["off"] is None else abs(row["off"]))
    return f"| {NAMES[row['key']]} | {row['case']}, {row['state']} | {_numbers(row)} |"


def _bits(expected, found):
    """A table line for each kind of product: the number of files, and of those with the same bits."""
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

"""Builds the report, one HTML file, from the study's files and jinja2 templates."""

import json
import pathlib

import jinja2

from common.files import replacing, sha256
from reports.study.agreement import published_results
from reports.study.bland_altman import sample_sd
from reports.study.differences import COHORT_ROW_NAME
from reports.study.inclusion import patient_groups
from reports.study.nearer import FEWEST_PATIENTS, SIGNIFICANCE_LEVEL
from reports.study.tables import study_table
from reports.inputs.case_files import PREDICTED_FROM_CT, STATES
from reports.figures.style import COLOURS, ERROR_LABELS, LABELS, SHORT_LABELS
from reports.page.agreement import MOST_DIGITS, agreement_groups, contrast_rows, excluded_patients
from reports.page.assets import TEMPLATE_FOLDER, image_uri, optional_image, script_text, three_script, three_version
from reports.page.benchmarks import read_benchmarks
from reports.page.case_context import case_context
from reports.page.digits import decimals
from reports.page.evidence import evidence_rows, read_test_results
from reports.page.geometry import colour_table
from reports.inputs.reading import read_json
from reports.whatif.tables import records

TABLES = ("agreement", "contrast", "differences", "half_maximum", "nearer", "patients", "seconds", "timings")
MISSING = "–"
LOW_MARK = "▼"  # marks an FFR after PCI below reports.selection.patients.LOW_FFR_AFTER
OCCLUDED_CODE = "occluded_by_voxels"


def build_report(
    cases,
    study_dir,
    figures_dir,
    out,
    junit=(),
    software=None,
    cohort="",
    benchmark_dir=None,
    provenance=None,
    failed=(),
    three=pathlib.Path("build/three.min.js"),
):
    """Writes the report of the CaseFiles `cases` to `out`. Raises InputError if a file is missing.

    failed: entries of failed.json (workflow.failed), of cases that have no result. three: file of three.js, the library
    of the 3D viewer.
    """
    contexts = [case_context(files, figures_dir) for files in cases]
    tables = {name: records(study_table(study_dir, name)) for name in TABLES}
    agreement, patients = tables["agreement"], tables["patients"]
    differences, seconds = tables["differences"], tables["seconds"]
    by_group = agreement_groups(agreement, tables["nearer"], tables["half_maximum"])
    for context in contexts:
        context["timings"] = [row for row in tables["timings"] if row["case"] == context["name"]]
    page = (
        environment()
        .get_template("index.html.j2")
        .render(
            cohort=cohort,
            cases=contexts,
            failed=failed,
            summary=summary(contexts),
            agreement=by_group,
            excluded_patients=excluded_patients(patients),
            errors={kind: ERROR_LABELS[kind] for kind in ERROR_LABELS if kind in [row["error"] for row in agreement]},
            imaging=imaging_warnings(contexts),
            lumen_warnings=lumen_warnings(contexts),
            plan_remarks=plan_remarks(contexts),
            flow_warnings=[{"case": c["name"], "id": c["id"], **row} for c in contexts for row in c["flow_warnings"]],
            agreement_figure=optional_image(figures_dir / "agreement.svg") if agreement else None,
            nearer_level=SIGNIFICANCE_LEVEL,
            nearer_fewest=FEWEST_PATIENTS,
            contrast=contrast_rows(tables["contrast"], contexts),
            differences=differences,
            differences_figure=optional_image(figures_dir / "differences.svg") if differences else None,
            cohort_name=COHORT_ROW_NAME,
            patients=patients,
            low_mark=LOW_MARK,
            inclusion=image_uri(figures_dir / "inclusion.svg"),
            seconds=seconds,
            seconds_figure=image_uri(figures_dir / "seconds.svg") if seconds else None,
            scatter=image_uri(figures_dir / "ffr_before_after.svg"),
            published=published_results(),
            evidence=evidence_rows(read_test_results(junit)),
            benchmarks=read_benchmarks(benchmark_dir),
            software=read_json(software, "reports software") if software else None,
            provenance=provenance_summary(provenance) if provenance else None,
            states=STATES,
            states_shown=[state for state in STATES if any(state in c["metrics"]["states"] for c in contexts)],
            labels=LABELS,
            short=SHORT_LABELS,
            from_ct=PREDICTED_FROM_CT,
            colours=COLOURS,
            viewer=script_json({"cases": {c["id"]: c["viewer"] for c in contexts}, "colours": colour_table()}),
            style=(TEMPLATE_FOLDER / "style.css").read_text(),
            three_version=three_version(),
            scripts=[
                three_script(three),
                *(script_text(TEMPLATE_FOLDER / name) for name in ("viewer.js", "stage.js", "page.js")),
            ],
        )
    )
    with replacing(out) as partial:
        partial.write_text(page)


def provenance_summary(path):
    """Summary of provenance.json for the page: its hash, and how many inputs, commands and products it lists."""
    cases = read_json(path, "workflow provenance")["cases"].values()
    counts = {key: sum(len(case[key]) for case in cases) for key in ("inputs", "commands", "products")}
    return {**counts, "sha256": sha256(path)}


def environment():
    """The jinja2 environment: undefined names raise, HTML is escaped."""
    env = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATE_FOLDER),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    env.filters.update(
        lower_first=lower_first,
        significant=significant,
        signed_significant=signed_significant,
        signed_decimals=signed_decimals,
    )
    env.filters.update(fixed=fixed, signed=signed, scientific=scientific, percent=percent)
    return env


def script_json(document):
    """A document as JSON that can stand inside <script>."""
    return json.dumps(document, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")


def summary(contexts):
    """Means over each group of patients, and counts over the cohort, for the first lines of the report."""
    seconds = [c["deployment"]["seconds"] for c in contexts if c["deployment"]]
    return {
        "count": len(contexts),
        "synthetic": sum(c["metrics"]["kind"] == "synthetic" for c in contexts),
        "with_reference": sum("reference" in c["metrics"]["states"] for c in contexts),
        "with_post": sum("post" in c["metrics"]["states"] for c in contexts),
        "measured": sum(c["metrics"]["measured"] is not None for c in contexts),
        "with_ct": sum("ct" in c["metrics"]["states"] for c in contexts),
        "means": {name: means(found) for name, found in patient_groups([c["metrics"] for c in contexts])},
        "seconds": mean_sd(seconds) if seconds else None,
    }


def means(documents):
    """{state: {n, ffr, area, minimum, curvature}}: number n of cases with the state, and (mean, sd) of each quantity.

    documents: content of metrics.json of each case.
    """
    found = {}
    for state in STATES:
        of_state = [document["states"][state] for document in documents if state in document["states"]]
        if of_state:
            found[state] = {
                "n": len(of_state),
                "ffr": mean_sd([entry["ffr"]["distal"] for entry in of_state if entry["ffr"] is not None]),
                "area": mean_sd([entry["area"]["mean_mm2"] for entry in of_state]),
                "minimum": mean_sd([entry["area"]["minimum_mm2"] for entry in of_state]),
                "curvature": mean_sd([entry["curvature"]["mean_per_mm"] for entry in of_state]),
            }
    return found


def imaging_warnings(contexts):
    """Warnings of the segmentations as rows {case, id, state, code, message}.

    Warnings of throats that are too narrow for the voxels come first.
    """
    rows = [
        {"case": c["name"], "id": c["id"], "state": state, "code": warning["code"], "message": warning["message"]}
        for c in contexts
        for state, found in c["metrics"]["imaging"].items()
        for warning in found["warnings"]
    ]
    return sorted(rows, key=lambda row: row["code"] != OCCLUDED_CODE)


def lumen_warnings(contexts):
    """Rows {case, id, state, message} of the warnings in the anatomies of given lumens."""
    return [
        {"case": c["name"], "id": c["id"], "state": state, "message": message}
        for c in contexts
        for state, found in c["metrics"]["lumen_warnings"].items()
        for message in found
    ]


def plan_remarks(contexts):
    """Rows {case, id, message} of the remarks on proposed plans."""
    return [
        {"case": c["name"], "id": c["id"], "message": message}
        for c in contexts
        for message in (c["metrics"]["plan_reference"] or {}).get("remarks", [])
    ]


def mean_sd(values):
    """(mean, sample standard deviation or None) of a list of numbers; (None, None) of none."""
    return (sum(values) / len(values), sample_sd(values)) if values else (None, None)


def lower_first(text):
    """A label for use within a sentence: the first letter small, unless the first word is in capitals."""
    return text if text[:2].isupper() else text[0].lower() + text[1:]


def fixed(value, digits=2):
    """A number with `digits` decimals. A dash if the value is missing; a text is returned as it is."""
    if value is None or isinstance(value, jinja2.Undefined):
        return MISSING
    return value if isinstance(value, str) else f"{value:,.{digits}f}"


def signed(value, digits=2):
    """A difference with its sign and `digits` decimals; a dash if it is missing. The minus is the character U+2212."""
    if value is None:
        return MISSING
    text = f"{abs(value):.{digits}f}"
    if float(text) == 0.0:
        return text
    return ("−" if value < 0 else "+") + text


def significant(value, digits=2):
    """A number with `digits` significant digits, never as a power of ten; a dash if it is missing."""
    return MISSING if value is None else f"{value:,.{decimals(value, digits)}f}"


def signed_significant(value, digits=2):
    """A difference with its sign and `digits` significant digits; a dash if it is missing."""
    return MISSING if value is None else signed(value, decimals(value, digits))


def signed_decimals(value, least):
    """A difference with its sign. It has `least` decimals, or more so that two significant digits are shown."""
    return MISSING if value is None else signed(value, max(least, min(MOST_DIGITS, decimals(value, 2) if value else 0)))


def scientific(value):
    """A small number, such as a residual, in the form 2.1e-06; a dash if it is missing."""
    return MISSING if value is None or isinstance(value, jinja2.Undefined) else f"{value:.1e}"


def percent(value, digits=1):
    """A number in per cent with `digits` decimals and the sign %; a dash if it is missing."""
    return MISSING if value is None else f"{value:.{digits}f} %"

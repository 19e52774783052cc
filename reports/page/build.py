"""Builds the report from the study's files and jinja2 templates: index, a page for each case, a page of benchmarks."""

import json
import pathlib

import jinja2
import markupsafe

from common.files import sha256
from common.patient.states import PREDICTED_FROM_CT, STATES
from reports.study.agreement import published_provenance, published_results
from reports.study.bland_altman import sample_sd
from reports.study.differences import COHORT_ROW_NAME
from reports.study.inclusion import patient_groups
from reports.study.nearer import FEWEST_PATIENTS, SIGNIFICANCE_LEVEL
from reports.study.tables import study_table
from reports.figures.style import ERROR_LABELS, LABELS, SHORT_LABELS
from reports.page.agreement import agreement_groups, contrast_rows, excluded_patients
from reports.page.benchmarks import read_benchmarks
from reports.page.case_context import case_context
from reports.page.check import Page
from reports.page.data_files import write_case_data, write_study_data
from reports.page.digits import FILTERS
from reports.page.evidence import evidence_context
from reports.page.folder import BENCHMARKS, INDEX, TEMPLATE_FOLDER, case_page, report_folder, three_version
from reports.page.geometry import colour_tables
from reports.page.source_map import source_map_rows
from reports.page.sources import selection, source_of
from reports.page.verdict.lines import verdict
from reports.inputs.reading import read_failed, read_json
from reports.whatif.tables import records

TABLES = ("agreement", "contrast", "differences", "half_maximum", "nearer", "patients", "seconds", "timings")
LOW_MARK = "▼"  # marks an FFR after PCI below reports.selection.patients.LOW_FFR_AFTER
NARROW_FOR_VOXELS = "occluded_by_voxels"  # code of the warning that a throat is too narrow for the voxels


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
    failed=None,
    three=pathlib.Path("build/three.min.js"),
):
    """Writes the report of the CaseFiles `cases` into the folder `out`. Raises InputError if a file is missing.

    failed: failed.json (workflow.failed) with the cases that have no result, or None. three: file of three.js, the
    library of the 3D viewer.
    """
    failed_steps = read_failed(failed)
    with report_folder(out) as folder:
        contexts = [case_context(files, figures_dir, folder) for files in cases]
        benchmarks = read_benchmarks(benchmark_dir, folder)
        evidence = evidence_context(junit, benchmarks)
        write_study_data(folder, study_dir, software, failed_steps, evidence["rows"])
        for files, context in zip(cases, contexts):
            write_case_data(folder, files, context)
        folder.write_assets(three)
        pages = Pages(folder, contexts, benchmarks, selection(cohort, [files.case for files in cases], failed))
        pages.write_cases(records(study_table(study_dir, "timings")))
        pages.write_benchmarks()
        pages.write_index(  # last: it links to places on the other pages
            cohort=cohort,
            failed=failed_steps,
            evidence=evidence,
            software=read_json(software, "reports software") if software else None,
            provenance=provenance_summary(provenance) if provenance else None,
            **study_context(study_dir, figures_dir, folder, contexts, failed_steps),
        )


class Pages:
    """Writes the pages into a ReportFolder. contexts: case_context of each case. selection: from sources.selection.

    ids: {name of a page: ids of its elements} of the pages written so far.
    """

    def __init__(self, folder, contexts, benchmarks, selection):
        self.folder, self.contexts, self.benchmarks, self.selection = folder, contexts, benchmarks, selection
        self.environment, self.ids = environment(), {}
        self.shared = {
            "names": [context["name"] for context in contexts],
            "published": published_results(),
            "labels": LABELS,
            "short": SHORT_LABELS,
        }

    def write_index(self, **context):
        """Writes the first page, after all others. context: what its templates need beside the cases."""

        def find_sources(sections):
            return source_map_rows({**self.ids, INDEX: Page(sections).ids}, self.shared["names"])

        self._write(INDEX, "index.html.j2", index="", cases=self.contexts, find_sources=find_sources, **context)

    def write_cases(self, timings):
        """Writes a page for each case. timings: rows of timings.csv."""
        names = [None, *self.shared["names"], None]
        for context, before, after in zip(self.contexts, names, names[2:]):
            case = {**context, "timings": [row for row in timings if row["case"] == context["name"]]}
            viewer = {"cases": {case["id"]: case["viewer"]}, "colours": colour_tables()}
            more = {"before": before, "after": after, "viewer": script_json(viewer), "three_version": three_version()}
            self._write(case_page(case["name"]), "case_page.html.j2", case=case, **more)

    def write_benchmarks(self):
        """Writes the page of the benchmarks that were run."""
        self._write(BENCHMARKS, "benchmarks_page.html.j2", on_benchmarks=True, benchmarks=self.benchmarks)

    def _write(self, name, template, case=None, **context):
        """Renders and writes a page. name: its path below the folder. `root` leads from the page back to the folder."""
        root, of_source = "../" * name.count("/"), self.environment.get_template("source.html.j2")

        def source_line(source):
            return markupsafe.Markup(of_source.render(root=root, **source))

        def source(key):
            return source_line(source_of(key, self.folder.data_names, self.selection, case["name"] if case else ""))

        own = {"root": root, "index": f"{root}{INDEX}", "case": case, "on_benchmarks": False}
        own.update(source=source, source_line=source_line)
        text = self.environment.get_template(template).render({**own, **self.shared, **context})
        self.ids[name] = Page(text).ids
        self.folder.write(name, text)


def study_context(study_dir, figures_dir, folder, contexts, failed):
    """What the index shows from the study's tables and figures. contexts: case_context of each case.

    failed: entries of failed.json.
    """
    tables = {name: records(study_table(study_dir, name)) for name in TABLES}
    agreement, differences, seconds = tables["agreement"], tables["differences"], tables["seconds"]
    return {
        "summary": summary(contexts),
        "verdict": verdict(contexts, agreement, tables["nearer"], failed),
        "agreement": agreement_groups(agreement, tables["nearer"], tables["half_maximum"]),
        "excluded_patients": excluded_patients(tables["patients"]),
        "errors": {kind: ERROR_LABELS[kind] for kind in ERROR_LABELS if kind in [row["error"] for row in agreement]},
        "imaging": imaging_warnings(contexts),
        "lumen_warnings": lumen_warnings(contexts),
        "plan_remarks": plan_remarks(contexts),
        "flow_warnings": [{"case": c["name"], **row} for c in contexts for row in c["flow_warnings"]],
        "agreement_figure": folder.optional_picture(figures_dir / "agreement.svg") if agreement else None,
        "nearer_level": SIGNIFICANCE_LEVEL,
        "nearer_fewest": FEWEST_PATIENTS,
        "contrast": contrast_rows(tables["contrast"], contexts),
        "differences": differences,
        "differences_figure": folder.picture(figures_dir / "differences.svg") if differences else None,
        "cohort_name": COHORT_ROW_NAME,
        "patients": tables["patients"],
        "low_mark": LOW_MARK,
        "inclusion": folder.picture(figures_dir / "inclusion.svg"),
        "seconds": seconds,
        "seconds_figure": folder.picture(figures_dir / "seconds.svg") if seconds else None,
        "scatter": folder.picture(figures_dir / "ffr_before_after.svg"),
        "states": STATES,
        "states_shown": [state for state in STATES if any(state in c["metrics"]["states"] for c in contexts)],
        "from_ct": PREDICTED_FROM_CT,
    }


def provenance_summary(path):
    """Summary of provenance.json for the page: its hash, and how many inputs, commands and products it lists."""
    cases = read_json(path, "workflow provenance")["cases"].values()
    counts = {key: sum(len(case[key]) for case in cases) for key in ("inputs", "commands", "products")}
    return {**counts, "sha256": sha256(path)}


def environment():
    """The jinja2 environment: undefined names raise, HTML is escaped.

    Tests render single templates, outside a report. There are no files to name then, so `root` and the lines on sources
    are empty.
    """
    env = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATE_FOLDER),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    env.filters.update(FILTERS, case_page=case_page)
    env.globals.update(benchmarks_page=BENCHMARKS, published_from=published_provenance)
    env.globals.update(root="", source=lambda key: "", source_line=lambda source: "")
    return env


def script_json(document):
    """A document as JSON for a <script> element, which must not hold "</"."""
    return json.dumps(document, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")


def summary(contexts):
    """Means over each group of patients, and counts over the cohort, for the first lines of the report."""
    return {
        "count": len(contexts),
        "synthetic": sum(c["metrics"]["kind"] == "synthetic" for c in contexts),
        "with_reference": sum("reference" in c["metrics"]["states"] for c in contexts),
        "with_post": sum("post" in c["metrics"]["states"] for c in contexts),
        "measured": sum(c["metrics"]["measured"] is not None for c in contexts),
        "with_ct": sum("ct" in c["metrics"]["states"] for c in contexts),
        "means": {name: means(found) for name, found in patient_groups([c["metrics"] for c in contexts])},
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
    """Warnings of the segmentations as rows {case, state, code, message}.

    Warnings of throats that are too narrow for the voxels come first.
    """
    rows = [
        {"case": c["name"], "state": state, "code": warning["code"], "message": warning["message"]}
        for c in contexts
        for state, found in c["metrics"]["imaging"].items()
        for warning in found["warnings"]
    ]
    return sorted(rows, key=lambda row: row["code"] != NARROW_FOR_VOXELS)


def lumen_warnings(contexts):
    """Rows {case, state, message} of the warnings on the lumens that the cases give."""
    return [
        {"case": c["name"], "state": state, "message": message}
        for c in contexts
        for state, found in c["metrics"]["lumen_warnings"].items()
        for message in found
    ]


def plan_remarks(contexts):
    """Rows {case, message} of the remarks on proposed plans."""
    return [
        {"case": c["name"], "message": message}
        for c in contexts
        for message in (c["metrics"]["plan_reference"] or {}).get("remarks", [])
    ]


def mean_sd(values):
    """(mean, sample standard deviation or None) of a list of numbers; (None, None) for an empty list."""
    return (sum(values) / len(values), sample_sd(values)) if values else (None, None)

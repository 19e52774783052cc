"""Command line of the reports: `python3 -m reports COMMAND --help`."""

import argparse
import pathlib
import sys

from common.errors import InputError, guarded
from common.files import write_json, write_table
from common.patient.states import STATES
from reports.inputs.case_files import SEGMENTATION_ARMS, CaseFiles
from reports.inputs.reading import read_failed, read_json

REPOSITORY = pathlib.Path()  # commands run in the repository's folder


def case_files(args):
    """The CaseFiles of --case-dir folders, named after the folders."""
    return [CaseFiles(folder.resolve().name, folder) for folder in args.case_dir]


def read_metrics(paths):
    """The metrics documents at `paths`; InputError for a document of another kind or a case given twice."""
    documents = []
    for path in paths:
        document = read_json(path, "reports metrics")
        if document.get("schema") != "vci-metrics-1":
            raise InputError("not a metrics file", path, document.get("schema"), "give files made by `reports metrics`")
        if document["case"] in [other["case"] for other in documents]:
            raise InputError("a case is given twice", path, document["case"], "give each case once")
        documents.append(document)
    return documents


def run_metrics(args):
    from reports.measuring.metrics import case_metrics

    files = CaseFiles(args.case, args.case_dir, args.segmentation)
    write_json(args.out, case_metrics(files, args.margin_mm, args.stations, args.states, args.config))


def run_table(args):
    from reports.study.agreement import agreement_table
    from reports.study.cohort import cohort_table
    from reports.study.contrast import contrast_table
    from reports.study.nearer import nearer_table

    table_functions = {
        "agreement": agreement_table,
        "cohort": cohort_table,
        "nearer": nearer_table,
        "contrast": contrast_table,
    }
    write_table(args.out, table_functions[args.command](read_metrics(args.metrics)), digits=None)


def run_differences(args):
    from reports.study.differences import difference_table, station_table

    documents = read_metrics(args.metrics)
    write_table(args.stations, station_table(documents), digits=None)
    write_table(args.out, difference_table(documents), digits=None)


def run_patients(args):
    from common.documents.config import load_case
    from reports.selection.flow_chart import inclusion_figure
    from reports.selection.patients import inclusion_table, patients_table

    documents = read_metrics(args.metrics)
    configs = {path.stem: path for path in args.configs}
    missing = [document["case"] for document in documents if document["case"] not in configs]
    if missing:
        raise InputError("a case has no configuration", "--configs", missing, "give the case file of each metrics.json")
    table = patients_table(
        documents, {document["case"]: load_case(configs[document["case"]]) for document in documents}
    )
    states = {document["case"]: list(document["states"]) for document in documents}
    failed = dict.fromkeys(step["case"] for step in read_failed(args.failed))
    steps = inclusion_table(table, states, [case for case in failed if case not in states])
    write_table(args.out, table, digits=None)
    write_table(args.inclusion, steps, digits=None)
    inclusion_figure(steps, args.figures_dir)


def run_subgroups(args):
    from reports.study.subgroups import patient_files, subgroup_tables

    patients = patient_files(args.cohort, args.cases)
    agreement, failures = subgroup_tables(patients)
    write_table(args.out / "agreement.csv", agreement, digits=None)
    write_table(args.out / "failures.csv", failures, digits=None)
    print(f"{len(patients) - failures['patients'].sum()} of {len(patients)} patients finished; tables in {args.out}")


def run_timings(args):
    from reports.study.timings import timings_table

    write_table(args.out, timings_table(case_files(args)), digits=None)


def run_seconds(args):
    from reports.figures.seconds import seconds_figure
    from reports.inputs.reading import require_file
    from reports.study.seconds import read_timings, seconds_table

    timings = read_timings(require_file(args.timings, "reports timings"))
    write_table(args.out, seconds_table(timings), digits=None)
    seconds_figure(timings, args.figures_dir)


def run_figures(args):
    from reports.figures.case import case_figures
    from reports.figures.study import study_figures

    if not args.case_dir and not args.metrics:
        raise InputError("nothing to draw", "reports figures", "", "give --case-dir for cases, --metrics for the study")
    for files in case_files(args):
        case_figures(files, args.out_dir)
    if args.metrics:
        study_figures(read_metrics(args.metrics), args.out_dir)


def run_procedure(args):
    from reports.figures.procedure import procedure_figure

    procedure_figure(args.case, args.deployment, args.frames, args.out_dir)


def run_ct(args):
    from reports.figures.ct_slices import ct_figure

    for files in case_files(args):
        ct_figure(files, read_json(files.metrics, "reports metrics"), args.out_dir)


def run_sensitivity(args):
    from reports.whatif.tornado import sensitivity_figure

    for files in case_files(args):
        sensitivity_figure(files, args.out_dir)


def run_software(args):
    from reports.page.folder import three_version
    from reports.study.software import software_versions

    write_json(args.out, software_versions(REPOSITORY, {"three.js": three_version()}))


def run_report(args):
    from reports.page.build import build_report

    paths = args.study_dir, args.figures_dir, args.out
    metadata = args.software, args.cohort, args.benchmarks, args.provenance, args.failed
    build_report(case_files(args), *paths, args.junit, *metadata, args.three)


def run_numbers(args):
    from reports.record.numbers import report_numbers

    write_json(
        args.out, report_numbers(case_files(args), args.study_dir, args.cohort, args.junit, read_failed(args.failed))
    )


def run_crate(args):
    from reports.record.crate import crate
    from reports.study.software import git_output

    date = git_output(REPOSITORY, "show", "-s", "--format=%cI", "HEAD")
    write_json(args.out, crate(args.out.parent, args.cases, REPOSITORY / "CITATION.cff", date, args.cohort))


def run_check(args):
    from reports.page.check import check_report

    pages = check_report(args.report, args.screenshots)
    print(f"{args.report}: {len(pages)} pages, no console error, no missing file, no reference out of the folder")


def parser():
    """The argument parser; every command stores the function that runs it as `run`."""
    root = argparse.ArgumentParser(prog="reports", description=__doc__)
    commands = root.add_subparsers(dest="command", required=True, metavar="COMMAND")
    path = pathlib.Path

    command = commands.add_parser("metrics", help="area, curvature and FFR of a case's states -> metrics.json")
    command.add_argument("--case", required=True, help="the case's name")
    command.add_argument("--case-dir", required=True, type=path, help="results/cases/<case>")
    command.add_argument("--margin-mm", type=float, default=2.0, help="added at both ends of the stent (2)")
    command.add_argument("--stations", type=int, default=101, help="places along the segment (101; at least 50)")
    command.add_argument("--states", nargs="+", choices=STATES, help="only these (default: all with results)")
    command.add_argument("--config", type=path, help="config/cases/<case>.yaml, for the patient's measurements")
    command.add_argument(
        "--segmentation", choices=SEGMENTATION_ARMS, default="", help="another one of the CT (the study's own)"
    )
    command.add_argument("--out", required=True, type=path, help="metrics.json")
    command.set_defaults(run=run_metrics)

    for name, text in (
        ("agreement", "predictions against the reference, beside the published -> agreement.csv"),
        ("nearer", "whether VCI or radius correction is nearer to the lumen after PCI -> nearer.csv"),
        ("contrast", "by how much both methods miss the lumen after PCI, case by case -> contrast.csv"),
        ("cohort", "one row a case -> cohort.csv"),
    ):
        command = commands.add_parser(name, help=text)
        count = "*" if name == "agreement" else "+"  # agreement also makes half_maximum.csv: none without a CT
        command.add_argument("--metrics", required=True, nargs=count, type=path, help="metrics.json of each case")
        command.add_argument("--out", required=True, type=path, help="the CSV file")
        command.set_defaults(run=run_table)

    command = commands.add_parser(
        "differences", help="Diff^A and Diff^C by station, patient and cohort -> two CSV files"
    )
    command.add_argument("--metrics", required=True, nargs="+", type=path, help="metrics.json of each case")
    command.add_argument("--stations", required=True, type=path, help="the CSV file with a row a station")
    command.add_argument("--out", required=True, type=path, help="the CSV file with a row a patient, and the cohort's")
    command.set_defaults(run=run_differences)

    command = commands.add_parser("patients", help="the patients on one page, and who is included -> CSV and figure")
    command.add_argument("--metrics", required=True, nargs="+", type=path, help="metrics.json of each case")
    command.add_argument("--configs", required=True, nargs="+", type=path, help="config/cases/<case>.yaml of each case")
    command.add_argument("--inclusion", required=True, type=path, help="the CSV file with the steps of the inclusion")
    command.add_argument("--figures-dir", required=True, type=path, help="results/figures")
    command.add_argument("--failed", type=path, help="failed.json of `workflow failed`: cases that have no result")
    command.add_argument("--out", required=True, type=path, help="the CSV file with a row a patient")
    command.set_defaults(run=run_patients)

    command = commands.add_parser("subgroups", help="a drawn cohort: agreement by subgroup, failures by reason -> CSV")
    command.add_argument("--cohort", required=True, type=path, help="folder of `workflow cohort`")
    command.add_argument("--cases", type=path, default=path("results/cases"), help="results/cases")
    command.add_argument("--out", required=True, type=path, help="folder for agreement.csv and failures.csv")
    command.set_defaults(run=run_subgroups)

    command = commands.add_parser("timings", help="seconds and memory of each step -> timings.csv")
    command.add_argument("--case-dir", required=True, nargs="+", type=path, help="results/cases/<case>, of each case")
    command.add_argument("--out", required=True, type=path, help="the CSV file")
    command.set_defaults(run=run_timings)

    command = commands.add_parser("seconds", help="the virtual procedure's seconds by stage and step -> CSV and figure")
    command.add_argument("--timings", required=True, type=path, help="timings.csv")
    command.add_argument("--out", required=True, type=path, help="the CSV file")
    command.add_argument("--figures-dir", required=True, type=path, help="results/figures")
    command.set_defaults(run=run_seconds)

    command = commands.add_parser("figures", help="figures of cases and of the study -> SVG and PNG")
    command.add_argument("--case-dir", nargs="+", type=path, default=[], help="cases to draw (with their metrics.json)")
    command.add_argument("--metrics", nargs="+", type=path, default=[], help="metrics.json of the study's cases")
    command.add_argument("--out-dir", required=True, type=path, help="results/figures")
    command.set_defaults(run=run_figures)

    command = commands.add_parser("procedure", help="the steps of one procedure stage by stage -> SVG and PNG")
    command.add_argument("--case", required=True, help="the case's name")
    command.add_argument("--deployment", required=True, type=path, help="deployment.json")
    command.add_argument("--frames", required=True, type=path, help="the folder of `vci deploy --frames`")
    command.add_argument("--out-dir", required=True, type=path, help="results/figures")
    command.set_defaults(run=run_procedure)

    command = commands.add_parser("ct", help="slices of a case's CT with lumen and plaque -> SVG and PNG")
    command.add_argument("--case-dir", required=True, nargs="+", type=path, help="results/cases/<case>, of each case")
    command.add_argument("--out-dir", required=True, type=path, help="results/figures")
    command.set_defaults(run=run_ct)

    command = commands.add_parser("sensitivity", help="what a case's FFR and stent area hang on -> SVG and PNG")
    command.add_argument("--case-dir", required=True, nargs="+", type=path, help="results/cases/<case>, of each case")
    command.add_argument("--out-dir", required=True, type=path, help="results/figures")
    command.set_defaults(run=run_sensitivity)

    command = commands.add_parser("software", help="versions of what the study runs on, and git revision -> JSON")
    command.add_argument("--out", required=True, type=path, help="the JSON file")
    command.set_defaults(run=run_software)

    command = commands.add_parser("report", help="the whole study as pages: an index, and one a case")
    command.add_argument("--case-dir", required=True, nargs="+", type=path, help="results/cases/<case>, of each case")
    command.add_argument("--study-dir", required=True, type=path, help="results/study, with its CSV files")
    command.add_argument("--figures-dir", required=True, type=path, help="results/figures")
    command.add_argument("--cohort", default="", help="the cohort's name, for the summary")
    command.add_argument("--junit", nargs="*", type=path, default=[], help="test results (JUnit XML) for the evidence")
    command.add_argument("--software", type=path, help="JSON of `reports software`")
    command.add_argument("--provenance", type=path, help="JSON of `workflow provenance`")
    command.add_argument("--benchmarks", type=path, help="results/benchmarks, with a folder for each that was run")
    command.add_argument("--failed", type=path, help="failed.json of `workflow failed`: cases that have no result")
    command.add_argument("--three", type=path, default=path("build/three.min.js"), help="three.js (build/three.min.js)")
    command.add_argument("--out", required=True, type=path, help="the report's folder, results/report")
    command.set_defaults(run=run_report)

    command = commands.add_parser("numbers", help="the numbers of the study's tables in one file -> report.json")
    command.add_argument("--case-dir", required=True, nargs="+", type=path, help="results/cases/<case>, of each case")
    command.add_argument("--study-dir", required=True, type=path, help="results/study, with its CSV files")
    command.add_argument("--cohort", default="", help="the cohort's name")
    command.add_argument("--junit", nargs="*", type=path, default=[], help="test results (JUnit XML)")
    command.add_argument("--failed", type=path, help="failed.json of `workflow failed`: cases that have no result")
    command.add_argument("--out", required=True, type=path, help="results/report/report.json")
    command.set_defaults(run=run_numbers)

    command = commands.add_parser("crate", help="the finished study as a research object -> ro-crate-metadata.json")
    command.add_argument("--cases", required=True, nargs="+", help="names of the study's cases")
    command.add_argument("--cohort", default="", help="the cohort's name")
    command.add_argument(
        "--out", required=True, type=path, help="results/ro-crate-metadata.json, in the folder it tells of"
    )
    command.set_defaults(run=run_crate)

    command = commands.add_parser("check", help="open each page of a report in headless Chromium; fail on any error")
    command.add_argument("report", type=path, help="the report's index.html")
    command.add_argument("--screenshots", type=path, help="a folder for a picture of each page (PNG)")
    command.set_defaults(run=run_check)
    return root


@guarded
def main(arguments=None):
    """Runs one command. docs/design.md lists the exit codes."""
    args = parser().parse_args(arguments)
    args.run(args)


if __name__ == "__main__":
    sys.exit(main())

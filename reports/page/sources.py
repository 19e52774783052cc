"""The line under each figure and table of the report: its data, and the command that makes it again."""

import dataclasses
import shlex

from common.errors import InputError


@dataclasses.dataclass(frozen=True)
class Source:
    """Where a figure or table comes from. `{case}` stands for a case's name.

    target: the file to ask Snakemake for. data: files of the report's folder data/. note: words on data that are not
    CSV, or on a file that no rule writes.
    """

    target: str = ""
    data: tuple = ()
    note: str = ""


CASE = "results/cases/{case}"
SOURCES = {
    "verdict": Source("results/study/nearer.csv", ("cohort.csv", "agreement.csv", "nearer.csv")),
    "states_of_cohort": Source("results/study/cohort.csv", ("cohort.csv",)),
    "ffr_before_after": Source("results/figures/ffr_before_after.svg", ("cohort.csv",)),
    "seconds": Source("results/study/seconds.csv", ("seconds.csv",)),
    "seconds_figure": Source("results/figures/seconds.svg", ("timings.csv",)),
    "patients": Source("results/study/patients.csv", ("patients.csv",)),
    "inclusion": Source("results/figures/inclusion.svg", ("inclusion.csv",)),
    "agreement": Source("results/study/agreement.csv", ("agreement.csv",)),
    "agreement_figure": Source("results/figures/agreement.svg", ("cohort.csv", "agreement.csv")),
    "segmentations": Source("results/study/half_maximum.csv", ("agreement.csv", "half_maximum.csv")),
    "nearer": Source("results/study/nearer.csv", ("nearer.csv",)),
    "contrast": Source("results/study/contrast.csv", ("contrast.csv",)),
    "differences": Source("results/study/differences.csv", ("differences.csv",)),
    "differences_figure": Source("results/figures/differences.svg", ("differences_stations.csv",)),
    "failed": Source(data=("failed.csv",), note="written by <code>make study</code> when a step fails"),
    "evidence": Source(data=("evidence.csv",), note="made by <code>make test</code> before the report"),
    "software": Source("results/study/software.json", ("software.json",)),
    "source_map": Source(
        note="<code>reports/page/source_map.yaml</code> of the package, which has the tables of "
        "<code>docs/source-map.md</code>"
    ),
    "lumen": Source(
        "results/figures/{case}_lumen.svg", note=f"surfaces <code>{CASE}/&lt;state&gt;/anatomy/lumen.vtp</code>"
    ),
    "states": Source(f"{CASE}/metrics.json", ("{case}_states.csv", "{case}_differences.csv")),
    "wire": Source(f"{CASE}/metrics.json", ("{case}_states.csv",)),
    "pullback": Source("results/figures/{case}_pullback.svg", ("{case}_pullback.csv",)),
    "area": Source("results/figures/{case}_area.svg", ("{case}_profiles.csv",)),
    "curvature": Source("results/figures/{case}_curvature.svg", ("{case}_profiles.csv",)),
    "stations": Source("results/figures/{case}_stations.svg", ("{case}_profiles.csv",)),
    "plans": Source(f"{CASE}/plans/ranking.csv", ("{case}_plans.csv",)),
    "sensitivity": Source("results/figures/{case}_sensitivity.svg", ("{case}_sensitivity.csv", "{case}_intervals.csv")),
    "procedure": Source(
        "results/figures/{case}_procedure.svg", note=f"surfaces at each stage's end <code>{CASE}/vci/frames</code>"
    ),
    "plan": Source(f"{CASE}/vci/plan.png", ("{case}_plan.json",)),
    "ct": Source("results/figures/{case}_ct.svg", note=f"volumes <code>{CASE}/ct/&lt;state&gt;/ct.nii.gz</code>"),
    "stages": Source(f"{CASE}/vci/deployment.json", ("{case}_stages.csv",)),
    "flow": Source(f"{CASE}/metrics.json", ("{case}_flow.csv",)),
    "probes": Source(f"{CASE}/metrics.json", ("{case}_probes.csv",)),
    "timings": Source("results/study/timings.csv", ("timings.csv",)),
}


def source_of(name, data_names, selection, case=""):
    """{data, command, note} of the figure or table `name`, a key of SOURCES, for the line under it.

    data_names: the files of data/ that were written. selection: result of `selection`. Raises InputError if none of the
    files that should hold the data was written and there is no note.
    """
    source = SOURCES[name]
    data = [one for one in (file.format(case=case) for file in source.data) if one in data_names]
    if not data and not source.note:
        raise InputError("a figure or table has no data", name, source.data, "write them in reports/page/data_files.py")
    return {
        "data": data,
        "command": command(source.target.format(case=case), "{case}" not in source.target and selection),
        "note": source.note.format(case=case),
    }


def benchmark_source(path, data):
    """{data, command, note} of a benchmark's file, below results/benchmarks. data: names of its tables in data/."""
    return {"data": data, "command": command(f"results/benchmarks/{path.parent.name}/{path.name}", ""), "note": ""}


def command(target, options):
    """The command line that asks Snakemake for the file `target`; empty if there is no target."""
    return f"snakemake -j2 {target} {options or ''}".strip() if target else ""


def selection(cohort, cases, failed):
    """Snakemake's options that choose the cases of this report. Files of the whole study depend on them.

    cohort: its name; if empty, the names `cases` are used. failed: path of failed.json, or None.
    """
    chosen = f"cohort={cohort}" if cohort else f"cases={' '.join(cases)}"
    return shlex.join(["--config", chosen, *([f"failed={failed}"] if failed else [])])

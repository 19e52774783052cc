"""timings.csv: time and memory of each step, from Snakemake's benchmark files and the programs' own clocks."""

import pandas as pd

from common.patient.states import PREDICTED_FROM_CT, STATES
from reports.inputs.reading import number, read_json

COLUMNS = ["case", "step", "source", "seconds", "cpu_s", "peak_memory_mib"]
BENCHMARK_NUMBERS = ("s", "max_rss", "cpu_time")


def benchmark_rows(files):
    """Yields a row (dict) for each results/cases/<case>/benchmarks/**/*.tsv.

    If a step was repeated, its times are means and its memory is the largest.
    """
    folder = files.folder / "benchmarks"
    for path in sorted(folder.rglob("*.tsv")):
        table = read_benchmark(path)
        yield {
            "step": path.relative_to(folder).with_suffix("").as_posix(),
            "source": "workflow",
            "seconds": table["s"].mean(),
            "cpu_s": table["cpu_time"].mean(),
            "peak_memory_mib": table["max_rss"].max(),
        }


def read_benchmark(path):
    """DataFrame of a Snakemake benchmark file.

    A step too short to be sampled has "-" for its memory, and "-" or 0 for its processor time. These become NaN.
    """
    table = pd.read_csv(path, sep="\t", na_values=["-", "NA"])
    for name in BENCHMARK_NUMBERS:
        if name not in table.columns:
            table[name] = float("nan")
    table["cpu_time"] = table["cpu_time"].where(table["cpu_time"] > 0.0)
    return table


def program_rows(files):
    """Yields a row (dict) for each step that measures its own time: anatomy, deployment's stages, reference, flow."""
    for state in STATES:
        path = files.anatomy(state) / "anatomy.json"
        if path.exists():
            for step, seconds in sorted(read_json(path, "anatomy").get("timings_s", {}).items()):
                yield {"step": f"{state}/anatomy/{step}", "seconds": seconds}
    for name in ("vci", "rc", *PREDICTED_FROM_CT):
        path = files.folder / name / "deployment.json"
        if path.exists():
            document = read_json(path, "vci deploy")
            for stage in document.get("stages", []):
                yield {"step": f"{name}/{stage['step']}/{stage['stage']}", "seconds": number(stage, "seconds", path)}
            yield {"step": name, "seconds": number(document, "seconds", path)}
    path = files.folder / "reference" / "reference.json"
    if path.exists():
        yield {"step": "reference", "seconds": number(read_json(path, "reference"), "seconds", path)}
    for state in STATES:
        path = files.flow(state) / "ffr.json"
        if path.exists():
            document = read_json(path, "flow solve")
            yield {
                "step": f"{state}/flow",
                "seconds": number(document, "seconds", path),
                "peak_memory_mib": document.get("peak_memory_mib"),
            }


def timings_table(cases):
    """DataFrame of timings.csv for the CaseFiles `cases`."""
    rows = []
    for files in cases:
        rows += [{"case": files.case, **row} for row in benchmark_rows(files)]
        rows += [{"case": files.case, "source": "program", **row} for row in program_rows(files)]
    return pd.DataFrame(rows, columns=COLUMNS)

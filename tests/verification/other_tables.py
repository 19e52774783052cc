"""Tables of docs/other-patients.md from the results of `make study COHORT=real` and `make study CASES=culotte_lad`.

    /usr/bin/python3 tests/verification/other_tables.py results

A table stands between the lines `<!-- table: CASE -->` and `<!-- end -->`. A table stays as it is if its case is not in
the tables of the last run, `results/study`.
"""

import functools
import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

from page_tables import Page, markdown  # noqa: E402
from study_tables import format_number, read_rows  # noqa: E402

CASES = ("culotte_lad", "ivus_plaque", "ivus_stent")
STATES = ("pre", "vci", "rc", "rc_stent", "post")


def lumens(results, case):
    """Markdown with a row for each state of a case: FFR at each probe with its estimated error, and areas.

    results: folder with `cases` and `study`. The result is None if the case is not in study/cohort.csv. FFR is empty in
    a state without a flow.
    """
    row = next((row for row in read_rows(results, "cohort") or () if row["case"] == case), None)
    if row is None:
        return None
    states = [state for state in STATES if row.get(f"{state}_mean_area_mm2")]
    flows = {state: results / "cases" / case / "flow" / state / "ffr.json" for state in states}
    probes = {
        state: {probe["name"]: probe for probe in json.loads(file.read_text())["probes"]}
        for state, file in flows.items()
        if file.is_file()
    }
    names = list(dict.fromkeys(name for found in probes.values() for name in found))
    table = []
    for state in states:
        line = [state, *(format_probe(probes.get(state, {}).get(name)) for name in names)]
        line += [format_number(row[f"{state}_{area}_area_mm2"], 2) for area in ("mean", "minimum")]
        table.append(line)
    return markdown(["state", *(f"FFR, `{name}`" for name in names), "mean area, mm2", "smallest area, mm2"], table)


def format_probe(probe):
    """`FFR ± estimated error` of a probe of ffr.json. The estimate is left out if there is none, all if it is None."""
    if probe is None:
        return ""
    error = probe.get("error_estimate")
    return f"{probe['ffr']:.3f}" + ("" if error is None else f" ± {error:.4f}")


PAGE = Page("docs/other-patients.md", {}, {}, {case: functools.partial(lumens, case=case) for case in CASES})

if __name__ == "__main__":
    PAGE.main()

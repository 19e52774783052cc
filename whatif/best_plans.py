"""Which plans of a finished study are worth a flow in 3D: the best of each case by the calibrated network.

The study ranks all plans by the network alone, since a 3D flow takes as long as the flow of a state after PCI.
"""

import csv
import pathlib

from common.errors import InputError

PLANNED = "planned"  # the case's own plan; the study solves its flow as the state `vci`


def flows_of_best_plans(cases, results=pathlib.Path("results"), count=2):
    """Files plans/<plan>/flow/ffr.json of the `count` best plans of each case, as strings, in order of rank.

    cases: names; results: root of the products of a study. The case's own plan is left out where it is among the best.
    Plans that the engine refused have no rank. Raises InputError if a case has no ranking.
    """
    return [
        str(pathlib.Path(results) / "cases" / case / "plans" / plan / "flow" / "ffr.json")
        for case in cases
        for plan in _ranked(pathlib.Path(results) / "cases" / case / "plans" / "ranking.csv")[:count]
        if plan != PLANNED
    ]


def _ranked(path):
    """Names of the plans of ranking.csv that have a rank, the best first."""
    if not path.is_file():
        raise InputError("a case has no ranking of plans", path, "missing", "run `make study` first")
    with path.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["rank"]]
    return [row["plan"] for row in sorted(rows, key=lambda row: int(row["rank"]))]

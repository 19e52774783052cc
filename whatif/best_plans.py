"""The plans of a finished study that are worth a flow in three dimensions: the best of each case.

The study ranks all plans by the calibrated 1D network alone, since a 3D flow of every plan would take too long.
"""

import csv
import pathlib

from common.errors import InputError

PLANNED = "planned"  # the case's own plan; the study solves its flow as the state `vci`


def flows_of_best_plans(results=pathlib.Path("results"), count=2):
    """Files plans/<plan>/flow/ffr.json of the `count` best plans of each case, as strings, in order of case and rank.

    results: root of the products of a study. The case's own plan is left out if it is among the best. Plans that the
    engine refused have no rank. Raises InputError if no case has a ranking.
    """
    rankings = sorted(pathlib.Path(results).glob("cases/*/plans/ranking.csv"))
    if not rankings:
        raise InputError("no case has a ranking of plans", "--results", str(results), "run `make study` first")
    return [
        str(ranking.parent / row["plan"] / "flow" / "ffr.json")
        for ranking in rankings
        for row in _ranked(ranking)[:count]
        if row["plan"] != PLANNED
    ]


def _ranked(path):
    """Rows of ranking.csv that have a rank, the best first."""
    with path.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["rank"]]
    return sorted(rows, key=lambda row: int(row["rank"]))

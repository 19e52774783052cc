"""Reads the tables that `python3 -m whatif` writes into a case's folder."""

import pandas as pd

from reports.inputs.reading import existing, read_json

STATES = {"pre": "before PCI", "vci": "after the planned PCI"}
QUANTITIES = {"ffr": "FFR", "minimal_stent_area_mm2": "smallest stent area (mm²)"}
SOURCES = ("flow", "deployment")


def ranking(folder):
    """Rows of plans/ranking.csv of a case's folder, None if a field is empty; [] without the file.

    `ffr_3d` is filled in for plans whose flow was solved in three dimensions.
    """
    path = folder / "plans" / "ranking.csv"
    rows = records(pd.read_csv(path)) if path.is_file() else []
    for row in rows:
        solved = folder / "plans" / row["plan"] / "flow" / "ffr.json"
        if solved.is_file():
            row["ffr_3d"] = read_json(solved, "flow solve")["ffr"]
    return rows


def tornado(folder):
    """DataFrame of sensitivity/flow.csv, which must exist, and of deployment.csv if it exists."""
    existing(folder / "sensitivity" / "flow.csv", "whatif flow")
    return pd.concat(_found(folder, ""), ignore_index=True)


def intervals(folder):
    """{source: DataFrame} of the Latin hypercubes of a case: `flow`, and `deployment` if it was run."""
    return dict(zip(_sources(folder), _found(folder, "_intervals")))


def _sources(folder):
    return [source for source in SOURCES if (folder / "sensitivity" / f"{source}.csv").is_file()]


def _found(folder, kind):
    return [
        pd.read_csv(folder / "sensitivity" / f"{source}{kind}.csv", keep_default_na=True).assign(source=source)
        for source in _sources(folder)
    ]


def records(table):
    """A DataFrame's rows as dicts, None if a field is empty."""
    return [{key: None if pd.isna(value) else value for key, value in row.items()} for row in table.to_dict("records")]


def range_in_words(row):
    """The range of an input in words: "-20 to +20 %", "0.5 to 2 times"."""
    signed = row["planned"] == 0
    low, high = (f"{row[end]:+.3g}".replace("-", "−") if signed else f"{row[end]:.3g}" for end in ("low", "high"))
    unit = row["unit"] if isinstance(row["unit"], str) else ""
    return f"{low} to {high} {unit}".strip()

"""Reads the tables that `python3 -m whatif` writes into a case's folder."""

import sys

import pandas as pd

from common.files import sha256
from reports.inputs.reading import existing, read_json

STATES = {"pre": "before PCI", "vci": "after the planned PCI"}
QUANTITIES = {"ffr": "FFR", "minimal_stent_area_mm2": "smallest stent area (mm²)"}
SOURCES = ("flow", "deployment")


def ranking(folder):
    """Rows (dicts) of plans/ranking.csv in a case's folder, with None for an empty field; [] without the file.

    `ffr_3d` is filled in for plans whose flow was solved in 3D. Snakemake repeats such a flow only if it is asked for
    by name, so it may be out of date. It is used only if it was made from the present lumen and boundary.json.
    """
    path = folder / "plans" / "ranking.csv"
    rows = records(pd.read_csv(path)) if path.is_file() else []
    for row in rows:
        solved = folder / "plans" / row["plan"] / "flow" / "ffr.json"
        if not solved.is_file():
            continue
        answer, mesh = read_json(solved, "flow solve"), read_json(solved.with_name("mesh.json"), "flow mesh")
        made_from = {"mesh_sha256": mesh["file_sha256"], "boundary_sha256": sha256(folder / "flow" / "boundary.json")}
        if answer.get("made_from") == made_from and mesh["made_from_sha256"] == row["lumen_sha256"]:
            row["ffr_3d"] = answer["ffr"]
        else:
            _left_out(solved)
    return rows


def tornado(folder):
    """Rows of sensitivity/flow.csv, which must exist, and of sensitivity/deployment.csv if that may be used.

    A DataFrame, whose column `source` says from which file a row is.
    """
    existing(folder / "sensitivity" / "flow.csv", "whatif flow")
    return pd.concat(_found(folder, ""), ignore_index=True)


def intervals(folder):
    """{source: DataFrame} of the intervals by a case's Latin hypercube samples.

    source: `flow`, and `deployment` if its table may be used (see _sources).
    """
    return dict(zip(_sources(folder), _found(folder, "_intervals")))


def _sources(folder):
    """Those of SOURCES whose table may be used.

    Snakemake repeats deployment.csv only if it is asked for by name. So the table is used only if its FFR with all
    inputs as planned is also in flow.csv.
    """
    files = {source: folder / "sensitivity" / f"{source}.csv" for source in SOURCES}
    found = {source: _planned_ffr(path) for source, path in files.items() if path.is_file()}
    if "deployment" in found and not found["deployment"] <= found.get("flow", set()):
        _left_out(files["deployment"])
        del found["deployment"]
    return list(found)


def _planned_ffr(path):
    """Set of (state, FFR with all inputs as planned) in a table of `whatif`."""
    table = pd.read_csv(path)
    return set(table.loc[table["quantity"] == "ffr", ["state", "at_planned"]].itertuples(index=False, name=None))


def _left_out(path):
    said = "of an earlier lumen, procedure or boundary.json, left out; ask Snakemake for it again"
    print(f"{path}: {said}", file=sys.stderr)


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

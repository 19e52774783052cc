"""Reads the tables that `python3 -m whatif` writes into a case's folder."""

import sys

import pandas as pd

from common.files import sha256
from reports.inputs.reading import require_file, read_json

STATE_LABELS = {"pre": "before PCI", "vci": "after the planned PCI"}
QUANTITY_LABELS = {"ffr": "FFR", "minimal_stent_area_mm2": "smallest stent area (mm²)"}
SOURCES = ("flow", "deployment")


def read_ranking(folder):
    """Rows (dicts) of plans/ranking.csv in a case's folder, with None for an empty field; [] without the file.

    `ffr_3d` is filled in for plans whose flow was solved in 3D. Snakemake repeats such a flow only if it is asked for
    by name, so it may be out of date. It is used only if it was made from the present lumen and boundary.json.
    """
    path = folder / "plans" / "ranking.csv"
    rows = records(pd.read_csv(path)) if path.is_file() else []
    for row in rows:
        flow_file = folder / "plans" / row["plan"] / "flow" / "ffr.json"
        if not flow_file.is_file():
            continue
        solution, mesh = read_json(flow_file, "flow solve"), read_json(flow_file.with_name("mesh.json"), "flow mesh")
        made_from = {"mesh_sha256": mesh["file_sha256"], "boundary_sha256": sha256(folder / "flow" / "boundary.json")}
        if solution.get("made_from") == made_from and mesh["made_from_sha256"] == row["lumen_sha256"]:
            row["ffr_3d"] = solution["ffr"]
        else:
            _warn_outdated(flow_file)
    return rows


def read_sensitivity(folder):
    """DataFrame of sensitivity/flow.csv, and of sensitivity/deployment.csv if it may be used (see _usable_sources).

    The column `source` says from which file a row comes. Raises InputError if flow.csv is missing.
    """
    require_file(folder / "sensitivity" / "flow.csv", "whatif flow")
    return pd.concat(_read_tables(folder, ""), ignore_index=True)


def read_intervals(folder):
    """{source: DataFrame} of a case's intervals, which come from Latin hypercube samples.

    source: `flow`, and `deployment` if its table may be used (see _usable_sources).
    """
    return dict(zip(_usable_sources(folder), _read_tables(folder, "_intervals")))


def _usable_sources(folder):
    """Those of SOURCES whose table may be used.

    Snakemake repeats deployment.csv only if it is asked for by name, so it may be out of date. It is used only if its
    FFR with all inputs as planned stands in flow.csv too.
    """
    files = {source: folder / "sensitivity" / f"{source}.csv" for source in SOURCES}
    found = {source: _read_planned_ffrs(path) for source, path in files.items() if path.is_file()}
    if "deployment" in found and not found["deployment"] <= found.get("flow", set()):
        _warn_outdated(files["deployment"])
        del found["deployment"]
    return list(found)


def _read_planned_ffrs(path):
    """Set of (state, FFR with all inputs as planned) in a table of `whatif`."""
    table = pd.read_csv(path)
    return set(table.loc[table["quantity"] == "ffr", ["state", "at_planned"]].itertuples(index=False, name=None))


def _warn_outdated(path):
    said = "of an earlier lumen, procedure or boundary.json, left out; ask Snakemake for it again"
    print(f"{path}: {said}", file=sys.stderr)


def _read_tables(folder, kind):
    return [
        pd.read_csv(folder / "sensitivity" / f"{source}{kind}.csv", keep_default_na=True).assign(source=source)
        for source in _usable_sources(folder)
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

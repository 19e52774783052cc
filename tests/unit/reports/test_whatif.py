"""Other plans and the sensitivity of a case: read, drawn, and on the page."""

import json

import pandas as pd
import pytest

from common.files import sha256
from reports.__main__ import main
from reports.inputs.case_files import CaseFiles
from reports.whatif.page_context import planner_context
from reports.whatif.tables import range_in_words, read_ranking, read_sensitivity
from reports.whatif.tornado import interval_of_most_inputs, panel_rows
from whatif.plans import COLUMNS as RANKING
from whatif.sampling import COLUMNS, INTERVAL_COLUMNS

FLOW = [
    ("vci", "ffr", "mass", "left ventricular mass", "%", -20, 0, 20, 0.95, 0.94, 0.93),
    ("vci", "ffr", "split", "exponent of the split", "", 2, 2.55, 3, 0.941, 0.94, 0.938),
    ("pre", "ffr", "mass", "left ventricular mass", "%", -20, 0, 20, 0.75, 0.70, None),
]
AREA = [
    ("vci", "minimal_stent_area_mm2", "wall", "stiffness of the wall", "times", 0.5, 1, 2, 6.1, 6.0, 5.4),
    ("vci", "ffr", "wall", "stiffness of the wall", "times", 0.5, 1, 2, 0.941, 0.94, 0.937),
]
NARROW, WIDE = ("vci", "ffr", 0.94, 0.92, 0.96, 128, 0, 6), ("vci", "ffr", 0.94, 0.91, 0.965, 15, 1, 10)


@pytest.fixture
def folder(tmp_path):
    """A case's folder with the sensitivity to the flow alone."""
    (tmp_path / "sensitivity").mkdir()
    write(tmp_path, "flow", FLOW, [NARROW])
    return tmp_path


def write(folder, source, rows, intervals):
    pd.DataFrame(rows, columns=COLUMNS).to_csv(folder / "sensitivity" / f"{source}.csv", index=False)
    path = folder / "sensitivity" / f"{source}_intervals.csv"
    pd.DataFrame(intervals, columns=INTERVAL_COLUMNS).to_csv(path, index=False)


def test_bars_are_sorted_by_what_they_move_and_one_end_may_be_missing(folder):
    table = read_sensitivity(folder)
    assert panel_rows(table, "vci", "ffr")["input"].tolist() == ["split", "mass"]
    assert panel_rows(table, "pre", "ffr")["swing"].tolist() == pytest.approx([0.05])


def test_ranges_in_words():
    rows = pd.DataFrame(FLOW[:2] + AREA[:1], columns=COLUMNS).to_dict("records")
    assert [range_in_words(row) for row in rows] == ["−20 to +20 %", "2 to 3", "0.5 to 2 times"]


def test_the_interval_is_that_of_most_inputs(folder):
    assert (
        interval_of_most_inputs({"flow": pd.DataFrame([NARROW], columns=INTERVAL_COLUMNS)}, "vci", "ffr")["lower"]
        == 0.92
    )
    both = {key: pd.DataFrame([row], columns=INTERVAL_COLUMNS) for key, row in (("flow", NARROW), ("deployment", WIDE))}
    assert interval_of_most_inputs(both, "vci", "ffr")["lower"] == 0.91
    assert interval_of_most_inputs(both, "pre", "ffr") is None


def test_the_figure_is_drawn_with_and_without_the_deployment(folder, tmp_path):
    main(["sensitivity", "--case-dir", str(folder), "--out-dir", str(tmp_path / "without")])
    write(folder, "deployment", AREA, [WIDE])
    main(["sensitivity", "--case-dir", str(folder), "--out-dir", str(tmp_path / "with")])
    name = CaseFiles(folder.name, folder).case
    texts = [(tmp_path / kind / f"{name}_sensitivity.svg").read_text() for kind in ("without", "with")]
    assert ["stiffness of the wall" in text for text in texts] == [False, True]


def solve(folder, lumen="aa"):
    """Writes the three-dimensional flow of the plan `planned` and the case's boundary.json. Returns the latter."""
    flow, boundary = folder / "plans" / "planned" / "flow", folder / "flow" / "boundary.json"
    for path in (flow, boundary.parent):
        path.mkdir(parents=True, exist_ok=True)
    boundary.write_text("{}")
    made_from = {"mesh_sha256": "bb", "boundary_sha256": sha256(boundary)}
    (flow / "mesh.json").write_text(json.dumps({"made_from_sha256": lumen, "file_sha256": "bb"}))
    (flow / "ffr.json").write_text(json.dumps({"ffr": 0.943, "made_from": made_from}))
    return boundary


def test_a_flow_of_an_earlier_lumen_or_boundary_is_left_out(folder, capsys):
    (folder / "plans").mkdir()
    rows = [{"plan": "planned", "ffr": 0.94, "lumen_sha256": "aa"}]
    pd.DataFrame(rows).reindex(columns=RANKING).to_csv(folder / "plans" / "ranking.csv", index=False)
    boundary = solve(folder)
    assert read_ranking(folder)[0]["ffr_3d"] == 0.943 and not capsys.readouterr().err
    boundary.write_text('{"map_pa": 12000}')
    assert read_ranking(folder)[0]["ffr_3d"] is None and "ask Snakemake for it again" in capsys.readouterr().err
    solve(folder, lumen="cc")
    assert read_ranking(folder)[0]["ffr_3d"] is None


def test_a_varied_deployment_of_an_earlier_answer_is_left_out(folder, capsys):
    write(folder, "deployment", AREA, [WIDE])
    assert planner_context(folder)["deployment_varied"]
    write(folder, "flow", [(*row[:-2], row[-2] - 0.001, row[-1]) for row in FLOW], [NARROW])
    assert not planner_context(folder)["deployment_varied"]
    assert "deployment.csv: of an earlier" in capsys.readouterr().err


def test_every_state_has_a_range_but_the_text_names_two(folder):
    write(folder, "flow", FLOW, [NARROW, ("rc", "ffr", 0.945, 0.925, 0.962, 128, 0, 6)])
    found = planner_context(folder)
    assert found["ffr_ranges"] == {"vci": (0.92, 0.96), "rc": (0.925, 0.962)}
    assert [row["name"] for row in found["intervals"]] == ["FFR after the planned PCI"]


def test_what_the_page_says(folder):
    assert planner_context(folder)["plans"] == [] and not planner_context(folder)["deployment_varied"]
    write(folder, "deployment", AREA, [WIDE])
    (folder / "plans").mkdir()
    rows = [{"rank": 1, "plan": "planned", "ffr": 0.94, "ffr_error": 0.002}, {"plan": "longer", "status": "no"}]
    pd.DataFrame(rows).assign(lumen_sha256="aa").reindex(columns=RANKING).to_csv(
        folder / "plans" / "ranking.csv", index=False
    )
    solve(folder)
    found = planner_context(folder)
    assert [row["ffr_3d"] for row in found["plans"]] == [0.943, None]
    assert [row["ffr"] for row in found["plans"]] == [0.94, None] and found["plans_error"] == 0.002
    assert found["ffr_ranges"] == {"vci": (0.91, 0.965)}, "that of most inputs"
    assert [row["samples"] for row in found["intervals"]] == [128, 15] and found["deployment_varied"]

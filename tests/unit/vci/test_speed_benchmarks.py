"""The deployment's benchmarks: settings, reference runs, refusals, levels of error, tables of the page."""

import argparse
import csv
import importlib.util
import json
import pathlib
import signal

import pytest

from common.errors import InputError
from vci.benchmarks import baseline, benchmark, hard_cases
from vci.benchmarks.programs import run_program

ROOT = pathlib.Path(__file__).resolve().parents[3]
SPEC = importlib.util.spec_from_file_location(
    "vci_measured_tables", ROOT / "tests" / "verification" / "vci" / "measured_tables.py"
)
measured_tables = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(measured_tables)


def options(**changes):
    usual = {"edges": [0.8, 0.4], "tolerances": [3e-3, 1e-2], "precisions": ["single", "double"]}
    usual |= {"walls": ["membrane", "mass-spring"], "varied_at": 0.4, "build": pathlib.Path(), "out": pathlib.Path()}
    return argparse.Namespace(**usual | changes)


def test_all_but_the_first_values_are_run_at_one_edge():
    assert benchmark.benchmark_settings(options()) == [
        (0.8, 3e-3, "single", "membrane"),
        (0.4, 3e-3, "single", "membrane"),
        (0.4, 1e-2, "single", "membrane"),
        (0.4, 3e-3, "double", "membrane"),
        (0.4, 3e-3, "single", "mass-spring"),
    ]


def rows_with(monkeypatch, refused):
    """Rows of a case in which the settings (edge, tolerance) in `refused` find no balance. Mean areas are 10 + edge."""

    def fake_row(_programs, case, setting, _folder):
        row = {"case": case} | dict(zip(benchmark.SETTING_COLUMNS, setting))
        if setting[:2] in refused:
            return row | {"outcome": "refused", "reason": "no balance"}
        return row | {"outcome": "balanced", "mean_csa_mm2": 10 + setting[0], "mla_mm2": 5.0, "cpu_seconds": 1.0}

    monkeypatch.setattr(benchmark, "deployment_row", fake_row)
    return benchmark.run_case(options(), "straight")


def test_errors_are_against_the_finest_run_that_balances_and_say_which(monkeypatch):
    rows = rows_with(monkeypatch, [])
    assert rows[-1]["edge_mm"] == 0.4 and rows[-1]["residual_tolerance"] == 3e-4
    assert rows[0]["mean_csa_error_percent"] == pytest.approx(100 * (10.8 / 10.4 - 1))
    assert {r["reference"] for r in rows} == {"0.4 mm, 0.0003"}
    rows = rows_with(monkeypatch, [(0.4, 3e-4)])
    assert {r.get("reference") for r in rows} == {"0.8 mm, 0.0003", None}
    assert [r["reason"] for r in rows if r["outcome"] == "refused"] == ["no balance"]
    rows = rows_with(monkeypatch, [(0.4, 3e-4), (0.8, 3e-4), (0.4, 3e-3)])
    assert rows[0]["reference"] == "0.4 mm, 0.01", "the finest row there is"
    rows = rows_with(monkeypatch, [(e, t) for e in (0.8, 0.4) for t in (3e-3, 1e-2, 3e-4)])
    assert not any("mean_csa_error_percent" in r for r in rows)
    assert [m["cases"] for m in benchmark.median_rows(rows)] == [0] * 7


def row(scheme, cpu, error, **more):
    key = benchmark.ERROR_COLUMNS[0]
    found = {} if error is None else {key: error}
    return {"case": "straight", "scheme": scheme, "edge_mm": 1.0, "cpu_seconds": cpu} | found | more


def test_a_level_of_error_has_the_cheapest_row_of_each_scheme_within_it():
    facets, smooth = baseline.TEXTBOOK_SCHEMES
    rows = [row("default", 0.5, -2.0), row("default", 2.0, 0.2), row("reference", 20.0, 0.0)]
    rows += [row(smooth, 8.0, 4.0, velocity_stop_mm_per_ms=0.01, fixed_step_ms=0.01), row(smooth, 60.0, None)]
    rows += [row(smooth, 20.0, 2.5, velocity_stop_mm_per_ms=0.001, fixed_step_ms=0.003)]
    rows += [row(facets, 30.0, -0.9, velocity_stop_mm_per_ms=0.01, fixed_step_ms=0.01)]
    table = baseline.level_rows(rows)
    assert [r["times"] for r in table if r["contact"] == "facets"] == [60, 60, 15]
    five, three, one = [r for r in table if r["contact"] == "smooth"]
    assert (five["times"], three["times"]) == (16, 40)
    assert (three["textbook_step_ms"], three["textbook_stop_mm_per_ms"]) == (0.003, 0.001)
    assert one["default_cpu_seconds"] == 2.0 and "times" not in one
    assert one["textbook_edge_mm"] == "not reached" and one["textbook_cpu_seconds"] == 88.0
    assert one["textbook_error_percent"] == 2.5


def test_the_textbook_scheme_runs_with_contact_to_facets_and_to_the_smooth_surface():
    runs = list(baseline.scheme_runs([1.0]))
    for scheme, (surface, wanted) in baseline.TEXTBOOK_SCHEMES.items():
        numerics = [settings["numerics"] for name, _, _, settings in runs if name == scheme]
        assert len(numerics) == len(wanted) and {n["integration"] for n in numerics} == {"textbook"}
        assert {n["contact_surface"] for n in numerics} == {surface}


def test_a_run_is_stopped_once_its_budget_is_used_up():
    code, _, cpu = run_program(["/usr/bin/python3", "-c", "while True: pass"], budget=1)
    assert code == -signal.SIGXCPU and cpu > 0


def test_tables_of_the_page_are_those_of_the_files(tmp_path):
    folder = tmp_path / "benchmarks" / "deployment_baseline"
    folder.mkdir(parents=True)
    line = dict.fromkeys(baseline.LEVEL_COLUMNS, "") | {
        "case": "straight",
        "times": "16.24",
        "textbook_edge_mm": "not reached",
    }
    with (folder / "levels.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, baseline.LEVEL_COLUMNS)
        writer.writeheader()
        writer.writerow(line)
    text = "<!-- table: deployment_baseline -->\nold\n<!-- end -->\n"
    lines = measured_tables.PAGE.filled(text, tmp_path).splitlines()
    assert lines[3].startswith("| straight |") and lines[3].endswith("| 16.2 |") and "not reached" in lines[3]
    assert measured_tables.PAGE.filled(text, tmp_path / "none") == text
    with pytest.raises(InputError, match="no such table"):
        measured_tables.PAGE.filled(text.replace("baseline", "other"), tmp_path)


def test_the_page_names_tables_that_there_are():
    places = measured_tables.PAGE.names((ROOT / "vci" / "measured.md").read_text())
    assert places and places <= set(measured_tables.TABLES) | set(measured_tables.TABLE_FUNCTIONS)


def deployment(areas, steps, depth, warnings=()):
    """The parts of a deployment.json from which the columns of first_steps.csv are made."""
    stages = [{"steps": count, "max_penetration_mm": depth} for count in steps]
    profile = [{"s_mm": k, "area_mm2": area} for k, area in enumerate(areas)]
    return {"csa_profile": profile, "stages": stages, "warnings": list(warnings)}


def test_runs_of_other_first_steps_are_compared_by_their_areas():
    """A null section (area None) is left out; the means of 4 and 6, and of 4.2 and 6, differ by 2 %."""
    found = hard_cases.differences(
        [deployment([4, 6, None], [10, 5], 0.01), deployment([4.2, 6, None], [20], 0.03, ["the wall is folded: 3"])]
    )
    assert found["mean_area_spread_percent"] == pytest.approx(2)
    assert found["minimal_area_spread_percent"] == pytest.approx(5)
    assert (found["fewest_steps"], found["most_steps"], found["folded"]) == (15, 20, 1)
    assert found["worst_penetration_mm"] == 0.03


def test_table_of_first_steps_is_written_where_they_were_run(tmp_path):
    assert measured_tables.differences_by_first_step(tmp_path) is None
    folder = tmp_path / "benchmarks" / "deployment_hard_cases"
    folder.mkdir(parents=True)
    (folder / "first_steps.csv").write_text(f"{hard_cases.FIRST_STEP_COLUMNS}\ncurve,5,1,0,120,130,0.02,0.123,1.5\n")
    assert "| curve | 1 | 0 | 120 | 130 | 0.020 | 0.12 | 1.50 |" in measured_tables.differences_by_first_step(tmp_path)


def test_a_patient_is_run_by_each_scheme_on_the_mesh_of_its_study(monkeypatch, tmp_path):
    case, scenes = tmp_path / "cases" / "lad01", []
    (case / "vci").mkdir(parents=True)
    study_scene = {"lumen": "../anatomy/lumen.vtp", "centreline": "../anatomy/centreline.vtp", "procedure": []}
    (case / "vci" / "scene.json").write_text(json.dumps(study_scene | {"numerics": {"device_edge_mm": 0.45}}))
    found = [{"cpu_seconds": 10.0, "mean_csa_mm2": 9.9, "mla_mm2": 5.0}, {"cpu_seconds": 700.0}]
    found += [{"cpu_seconds": 300.0, "mean_csa_mm2": 10.1, "mla_mm2": 5.5}]
    found += [{"cpu_seconds": 30.0, "mean_csa_mm2": 10.0, "mla_mm2": 5.0}]

    def fake_outcome(_program, scene, budget):
        scenes.append(json.loads(scene.read_text()))
        assert (scene.parent / scenes[-1]["lumen"]).resolve() == case / "anatomy" / "lumen.vtp" and budget == 60
        outcome = found[len(scenes) - 1]
        return {"outcome": "balanced" if "mla_mm2" in outcome else "stopped"} | outcome

    monkeypatch.setattr(baseline, "run_outcome", fake_outcome)
    rows = baseline.run_case(argparse.Namespace(out=tmp_path / "out", build=pathlib.Path(), budget=60), case)
    assert [r["scheme"] for r in rows] == ["default", *baseline.TEXTBOOK_SCHEMES, "reference"]
    assert [r["times"] for r in rows] == [1, 70, 30, 3]
    assert rows[2]["mla_error_percent"] == pytest.approx(10) and "mla_error_percent" not in rows[1]
    assert [s["numerics"].get("contact_surface") for s in scenes] == [None, "facets", "smooth", None]
    assert [s["numerics"].get("integration") for s in scenes] == [None, "textbook", "textbook", None]
    assert scenes[3]["numerics"] == {"device_edge_mm": 0.45, "residual_tolerance": 3e-4}

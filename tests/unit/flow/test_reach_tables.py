"""tests/verification/flow/reach_tables.py: what was aimed at and found, and what each mesh of the sequence costs."""

import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests" / "verification" / "flow"), str(ROOT / "tests" / "verification")]

import reach_tables  # noqa: E402


def _answer(seconds, estimate=0.004, meshes=(), mesh="mesh.msh", memory=1000.0):
    return {
        "cpu_seconds": seconds,
        "error_estimate": None if estimate is None else {"ffr": estimate},
        "meshes": list(meshes),
        "mesh": mesh,
        "peak_memory_mib": memory,
    }


def _rows(table):
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]


ANSWERS = [
    ("lad01", "pre", _answer(120.0, 0.0051)),
    ("lad02", "pre", _answer(119.0)),
    ("lad01", "vci", _answer(40.1, None)),
    ("lad02", "vci", _answer(39.9, memory=2862.0)),
]


def test_a_limit_is_reached_by_what_just_meets_it_and_missed_by_what_exceeds_it():
    rows = {
        line[0] + str(place): line[1:] for place, line in enumerate(_rows(reach_tables.reach(ROOT / "none", ANSWERS)))
    }
    assert rows["a state before PCI in at most 120 CPU s0"] == ["yes", "at most 120 CPU s (lad01)"]
    assert rows["a state before PCI with an estimate within 0.0051"] == ["in 1 of 2", "at most 0.0051 (lad01)"]
    assert rows["a state after PCI in at most 40 CPU s2"] == ["in 1 of 2", "at most 40.1 CPU s (lad01 vci)"]
    assert rows["a state after PCI with an estimate within 0.0053"] == [
        "in 1 of 2",
        "at most 0.004 (lad02 vci), not known in lad01 vci",
    ]
    assert rows["`flow solve` of all states in at most 35 CPU min4"] == ["yes", "5.32 CPU min, 4 states"]
    assert rows["at most 3 GB5"] == ["in 3 of 4", "at most 3 GB (lad02 vci)"]


def test_the_benchmarks_that_were_run_have_rows(tmp_path):
    folder = tmp_path / "benchmarks"
    for name, file, text in (
        (
            "flow_hard_cases",
            "hard_cases.csv",
            "case,error,cpu_s\nsingle_62,-0.0002,8\nsingle_90,0.0011,5\neccentric_62,,63\n",
        ),
        (
            "flow_tree_against_openfoam",
            "tree.csv",
            "state,cells,difference\na pre,20786,+0.0087\na vci,15170,-0.0004\n",
        ),
        ("flow_fda_jet", "jet.csv", 'row,within\naxisymmetric,7 of 9\n"3 rings, eps 0.0065",4 of 9\n'),
    ):
        (folder / name).mkdir(parents=True)
        (folder / name / file).write_text(text)
    rows = _rows(reach_tables.reach(tmp_path, ANSWERS))[6:-1]
    assert [row[1] for row in rows] == ["in 1 of 2", "no", "yes", "no"]
    assert rows[0][2] == "at most 0.0011 (single_90)" and rows[2][2] == "at most 0.0087 (a pre, 20786 cells)"
    assert rows[3][2] == "at 4 of 9 places"


def test_the_lines_are_those_of_the_folder():
    ((_, reached, found),) = reach_tables.aim_for_lines()
    lines = int(found.split()[0])
    assert lines > len((ROOT / "flow" / "adaptive.py").read_text().splitlines())
    assert reached == ("yes" if lines <= 6000 else "no")


def test_each_mesh_has_its_share_and_the_last_row_what_is_left():
    coarse = {"mesh": "mesh_coarsest.msh", "status": "converged", "factorizations": 7, "cpu_seconds": 10.0}
    failed = {"mesh": "mesh_coarse.msh", "status": "no flow", "factorizations": 5}
    fine = {"mesh": "mesh.msh", "status": "converged", "factorizations": 3, "cpu_seconds": 60.0}
    answers = [("a", "pre", _answer(90.0, meshes=[coarse, failed, fine])), ("a", "vci", _answer(10.0, meshes=[coarse]))]
    answers[1][2]["mesh"] = "mesh_coarsest.msh"
    assert _rows(reach_tables.meshes(answers)) == [
        ["2", "2", "1", "0", "14", "20", "20"],
        ["3", "1", "0", "1", "5", "0", "0"],
        ["4", "1", "1", "0", "3", "60", "60"],
        ["failed solves, files", "", "", "", "", "20", "20"],
    ]


def test_the_reduced_models_are_told_apart_by_their_own_ffr():
    def answer(ffr, axisymmetric, network=None):
        return {"ffr": ffr, "models": {"axisymmetric": {"ffr": axisymmetric}, "network": {"ffr": network}, "3d": {}}}

    answers = [("a", "pre", answer(0.7, 0.8, 0.75)), ("a", "vci", answer(0.9, 0.92)), ("a", "rc", answer(0.9, 0.89))]
    answers.append(("b", "vci", answer(0.95, 0.951, 0.949)))
    assert _rows(reach_tables.reduced_models(answers)) == [
        ["the model's FFR is below 0.85", "+0.1000 (a pre)", "+0.0500 (a pre)"],
        ["it is not", "+0.0200 (a vci)", "-0.0010 (b vci)"],
        ["range within one patient after PCI", "0.0000 to 0.0300 (a)", "0.0000 to 0.0000 (b)"],
    ]


@pytest.mark.parametrize("table", [lambda: reach_tables.reach(ROOT / "none", []), lambda: reach_tables.meshes([])])
def test_without_a_study_there_is_no_table(table):
    assert table() is None

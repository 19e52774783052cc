"""Metrics of tubes against their exact area, curvature and pressure; states carried; bad files refused."""

import json

import numpy as np
import pytest

from common.errors import ComputationError, InputError
from flow.solvers import solved_mesh
from reports.measuring import profiles
from reports.inputs.case_files import CaseFiles
from reports.inputs.reading import read_failed
from reports.measuring.metrics import case_metrics


def metrics_of(folder, **options):
    return case_metrics(CaseFiles("tube", folder), **options)


def rigid(angle_deg, shift):
    """Rotation about (1, 2, 2) / 3 by an angle, then a shift: (4, 4)."""
    x, y, z = np.array([1.0, 2.0, 2.0]) / 3.0
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(angle_deg)
    move = np.eye(4)
    move[:3, :3] += np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    move[:3, 3] = shift
    return move


def test_values_of_a_tube(make_case, tube):
    document = metrics_of(make_case())
    s = np.linspace(10.0, 32.0, 20001)
    for state, entry in document["states"].items():
        area = np.pi * tube(state).radii(s) ** 2
        assert entry["area"]["mean_mm2"] == pytest.approx(area.mean(), rel=2e-3)
        assert entry["area"]["minimum_mm2"] == pytest.approx(area.min(), rel=2e-3)
        assert entry["curvature"]["mean_per_mm"] == pytest.approx(0.1, rel=1e-5)
        assert entry["curvature"]["mean_surveyed_per_mm"] == pytest.approx(0.1)
        assert entry["ffr"]["past_segment"] == pytest.approx(tube(state).pressure(32.0) / 12444.0, abs=1e-6)
        assert entry["ffr"]["distal"] == pytest.approx(tube(state).pressure(37.0) / 12444.0, abs=1e-9)
        assert len(entry["ffr"]["profile"]) == document["stations"]["used"] == 101


def test_the_walls_stretch_at_the_edges_of_the_stent_is_kept(make_case):
    rows = metrics_of(make_case())["deployment"]["stent_edges"]
    assert [(row["end"], row["largest_stretch"], row["beyond_limit"]) for row in rows] == [
        ("proximal", 1.0, False),
        ("distal", 1.0, False),
    ]


def test_differences_between_states(make_case):
    document = metrics_of(make_case())
    a, b = (np.array(document["states"][state]["area"]["profile_mm2"]) for state in ("vci", "reference"))
    row = document["differences"]["vci_minus_reference"]["area_mm2"]
    assert row["bias"] == pytest.approx(np.mean(a - b)) and row["bias"] > 0.1
    assert row["rmse"] ** 2 == pytest.approx(row["bias"] ** 2 + row["sd"] ** 2)


def test_a_moved_case_has_the_same_metrics(make_case):
    move = rigid(73.0, [40.0, -25.0, 60.0])
    still = metrics_of(make_case("still"))
    moved = metrics_of(make_case("moved", moves={state: move for state in still["states"]}))
    for state, entry in still["states"].items():
        other = moved["states"][state]
        assert other["s_mm"] == pytest.approx(entry["s_mm"], abs=1e-9)
        assert other["area"]["profile_mm2"] == pytest.approx(entry["area"]["profile_mm2"], rel=1e-9)
        assert other["curvature"]["profile_per_mm"] == pytest.approx(entry["curvature"]["profile_per_mm"], rel=1e-6)
        assert other["ffr"]["profile"] == pytest.approx(entry["ffr"]["profile"], rel=1e-9)


def test_a_state_slid_along_its_axis_is_measured_where_the_segment_was(make_case):
    """Turning the bent tube about its centre of curvature slides it 0.5 mm along itself."""
    angle, big = -0.05, 10.0
    move = np.eye(4)
    move[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    move[:3, 3] = np.array([0, big, 0]) - move[:3, :3] @ [0, big, 0]
    entry = metrics_of(make_case(moves={"vci": move}))["states"]["vci"]["segment"]
    assert entry["s_start_mm"] == pytest.approx(10.5, abs=2e-3)
    assert entry["s_end_mm"] == pytest.approx(32.5, abs=2e-3)


def test_a_state_somewhere_else_is_refused(make_case):
    with pytest.raises(ComputationError, match="off the axis"):
        metrics_of(make_case(moves={"vci": rigid(0.0, [0.0, 0.0, 9.0])}))


def test_a_case_without_reference_has_no_differences(make_case):
    document = metrics_of(make_case(states=("pre", "vci")))
    assert list(document["states"]) == ["pre", "vci"]
    assert document["differences"] == {} and document["kind"] == "surface"


def test_the_kind_is_the_cases_own_not_that_of_what_lies_about(make_case, repo_root):
    folder = make_case()
    for name, kind in (("real_artery", "surface"), ("quick_focal", "synthetic")):
        document = metrics_of(folder, config=repo_root / "config" / "cases" / f"{name}.yaml")
        assert document["kind"] == kind


def test_end_sections_are_left_out_in_all_states_alike(make_case):
    folder = make_case()
    path = folder / "vci" / "anatomy" / "sections.csv"
    lines = path.read_text().splitlines()
    lines = [
        line.replace(",ok", ",end") if k and float(line.split(",")[2]) > 26.6 else line for k, line in enumerate(lines)
    ]
    path.write_text("\n".join(lines) + "\n")
    document = metrics_of(folder)
    assert document["stations"]["used"] == 76  # relative positions up to (26.5 - 10) / 22 = 0.75
    for entry in document["states"].values():
        assert len(entry["area"]["profile_mm2"]) == 76 and entry["s_mm"][-1] == pytest.approx(26.5)


def test_refuses_a_list_of_failed_steps_that_is_none(tmp_path):
    assert read_failed(None) == []
    (tmp_path / "failed.json").write_text('{"failed": [{"case": "a", "step": "plan"}]}')
    with pytest.raises(InputError, match=r"(?s)not a list of failed steps.*failed\[1\]: key exit_code is missing"):
        read_failed(tmp_path / "failed.json")


def test_refuses_a_segment_without_enough_sections(make_case):
    folder = make_case()
    path = folder / "anatomy" / "sections.csv"
    lines = path.read_text().splitlines()
    lines = [
        line.replace(",ok", ",end") if k and float(line.split(",")[2]) > 15 else line for k, line in enumerate(lines)
    ]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(ComputationError, match="too few stations"):
        metrics_of(folder)


@pytest.mark.parametrize(
    "name",
    [
        "vci/scene.json",
        "vci/deployment.json",
        "flow/boundary.json",
        "anatomy/anatomy.json",
        "rc/anatomy/centreline.vtp",
        "flow/reference/pullback.csv",
        "vci/anatomy/sections.csv",
    ],
)
def test_a_missing_file_is_named(make_case, name):
    folder = make_case()
    (folder / name).unlink()
    with pytest.raises(InputError, match="missing") as refusal:
        metrics_of(folder)
    assert name in str(refusal.value) and "remedy" in str(refusal.value)


@pytest.mark.parametrize("name, column", [("vci/anatomy/sections.csv", 9), ("flow/rc/pullback.csv", 7)])
@pytest.mark.parametrize("bad", ["nan", "", "inf", "wide"])
def test_what_is_not_a_number_is_refused_with_its_row(make_case, name, column, bad):
    folder = make_case()
    lines = (folder / name).read_text().splitlines()
    fields = lines[60].split(",")
    fields[column] = bad
    lines[60] = ",".join(fields)
    (folder / name).write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match="row 61"):
        metrics_of(folder)


@pytest.mark.parametrize("number", ["NaN", "-Infinity", "1e999"])
def test_a_number_in_json_that_is_not_finite_is_refused(make_case, number):
    folder = make_case()
    path = folder / "flow" / "vci" / "ffr.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"note": "its value"}).replace('"its value"', number))
    with pytest.raises(InputError, match="(?s)not finite.*key note.*repeat: flow solve"):
        metrics_of(folder)


def test_a_solution_that_did_not_converge_is_refused(make_case):
    folder = make_case()
    path = folder / "flow" / "vci" / "ffr.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"status": "stalled"}))
    with pytest.raises(InputError, match="not converged"):
        metrics_of(folder)


def test_every_answer_of_the_flow_solver_is_read(make_case):
    assert profiles.ACCEPTED_STATUSES == solved_mesh.STATUSES
    folder = make_case()
    path = folder / "flow" / "vci" / "ffr.json"
    for status in solved_mesh.STATUSES:
        path.write_text(json.dumps(json.loads(path.read_text()) | {"status": status}))
        assert metrics_of(folder)["states"]["vci"]["ffr"]["distal"] > 0


@pytest.mark.parametrize("options", [{"margin_mm": -1.0}, {"stations": 20}, {"states": ["vci"]}])
def test_bad_options_are_refused(make_case, options):
    with pytest.raises(InputError):
        metrics_of(make_case(), **options)


def test_a_pull_back_with_its_own_zero_is_found_by_position(make_case):
    folder = make_case()
    before = metrics_of(folder)["states"]["vci"]["ffr"]["profile"]
    path = folder / "flow" / "vci" / "pullback.csv"
    lines = [line.split(",") for line in path.read_text().splitlines()]
    for fields in lines[1:]:
        fields[2] = repr(float(fields[2]) + 6.5)  # s_mm from the end of an inlet extension
    path.write_text("\n".join(",".join(fields) for fields in lines) + "\n")
    assert metrics_of(folder)["states"]["vci"]["ffr"]["profile"] == pytest.approx(before, abs=1e-12)


def test_a_ct_left_from_before_does_not_enter_where_it_is_not_asked_for(make_case):
    folder = make_case(states=("pre", "vci", "rc", "reference", "ct", "ct_vci"))
    with_ct = metrics_of(folder)
    assert list(with_ct["imaging"]) == ["pre", "reference"] and "ct_minus_reference" in with_ct["differences"]
    without = metrics_of(folder, states=("pre", "vci", "rc", "reference"))
    assert without["imaging"] == {} and list(without["differences"]) == ["vci_minus_reference", "rc_minus_reference"]


def test_what_the_anatomy_and_a_proposed_plan_warn_of_is_kept(make_case):
    """Repairs without a warning are left out. Only lumens that are given have warnings."""
    metrics = metrics_of(make_case())
    assert metrics["lumen_warnings"] == {"pre": ["stub left closed: at (1, 2, 3)"]}
    assert metrics["plan_reference"]["remarks"] == ["lesion1 narrows the diameter by 49.8 % only"]

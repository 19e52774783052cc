"""Plans ranked by the reduced models: the order of the plans, the model's error, and refusals."""

import json

import pandas as pd
import pytest

import tubes
from common.errors import InputError
from flow import __main__ as command_line
from flow.reduced import answer as reduced_answer, ranking
from flow import settings as settings_module

LENGTH, RADIUS = 30.0, 1.4
LEFT = {"small": 0.1, "large": 0.65, "middle": 0.35}  # narrowing that each plan leaves


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Lumens of three plans, one folder each, and the patient's boundary.json."""
    top = tmp_path_factory.mktemp("plans")
    for name, reduction in LEFT.items():
        radius = tubes.lesion(RADIUS, reduction, 15.0, 10.0)
        tubes.write_case(top / name, tubes.tube(LENGTH, radius, 0.6), [tubes.centre_branch(LENGTH, radius)])
    patient = ["--lvm-g", "60", "--sbp-mmhg", "120", "--dbp-mmhg", "80"]
    anatomy = ["--anatomy", str(top / "small" / "anatomy.json")]
    command_line.main(["boundary", *anatomy, *patient, "--out", str(top / "boundary.json")])
    return top


def _rank(folder, *more):
    command = ["rank", *(f"{name}={folder / name}" for name in LEFT), "--boundary", str(folder / "boundary.json")]
    command_line.main([*command, "--out", str(folder / "ranking.csv"), *more])
    return pd.read_csv(folder / "ranking.csv")


@pytest.mark.parametrize("model", ["axisymmetric", "network"])
def test_the_least_narrowing_is_the_best(folder, model):
    table = _rank(folder, "--model", model)
    assert list(table["plan"]) == ["small", "middle", "large"] and list(table["rank"]) == [1, 2, 3]
    assert table["ffr"].is_monotonic_decreasing
    assert (table["error"] == ranking.error_in_other_patients(model, table["ffr"].min())).all() and (
        table["model"] == model
    ).all()
    assert list(table["as_good_as_best"])[0] and not list(table["as_good_as_best"])[-1]


def _shifted(folder, by_mm=0.3, recorded_mm=0.3):
    """The probes of the boundary values as they are after projection on a centreline that lies `by_mm` aside."""
    probes = json.loads((folder / "boundary.json").read_text())["probes"]
    x, y, z = (list(axis) for axis in zip(*(probe["point_mm"] for probe in probes)))
    return [probe | {"point_mm": [x[k], y[k] + by_mm, z[k]], "shift_mm": recorded_mm} for k, probe in enumerate(probes)]


@pytest.mark.slow
def test_3d_answers_of_the_patient_set_the_error(folder):
    measured = []
    for number, three_d in enumerate((0.88, 0.875)):
        models = {"3d": {"ffr": three_d, "error_estimate": 0.001}}
        models |= {"axisymmetric": {"ffr": 0.9}, "network": {"ffr": 0.95}}
        path = folder / f"ffr{number}.json"
        path.write_text(json.dumps({"models": models, "probes": _shifted(folder)}))
        measured.append(str(path))
    one = _rank(folder, "--measured", measured[0])
    assert one["error"].to_numpy() == pytest.approx(0.02)
    assert list(one["as_good_as_best"]) == [True, True, False]
    two = _rank(folder, "--measured", *measured)
    assert two["error"].to_numpy() == pytest.approx(0.025)
    assert list(two["as_good_as_best"]) == [True, False, False]  # the two answers differ by .005 only
    assert list(two["ffr"]) == list(one["ffr"])


def _measured(*answers):
    """Result of model_error for a network with an FFR of .9 and 3D answers (FFR, error estimate)."""
    return ranking.model_error(
        "network",
        [
            (f"{k}.json", {"models": {"3d": {"ffr": ffr, "error_estimate": estimate}, "network": {"ffr": 0.9}}})
            for k, (ffr, estimate) in enumerate(answers)
        ],
        0.9,
    )


def test_no_plans_are_told_apart_by_less_than_the_3d_answers_are_known_to():
    assert _measured((0.88, 0.001), (0.88, 0.002)) == pytest.approx((0.02, 0.003))
    assert _measured((0.88, 0.001), (0.88, 0.002), (0.88, 0.004)) == pytest.approx((0.02, 0.006))
    assert _measured((0.9, 0.002)) == pytest.approx((0.002, 0.002))
    unknown = ranking.error_in_other_patients("network", 0.9)
    assert _measured((0.88, 0.001), (0.88, None)) == pytest.approx((unknown, unknown + 0.001))


def test_what_was_measured_elsewhere_is_no_less_in_severe_disease():
    for model, (mild, severe) in ranking.ERROR_IN_OTHER_PATIENTS.items():
        assert mild <= severe and ranking.model_error(model, [], 0.9) == (mild, mild)
        assert ranking.model_error(model, [], 0.8) == (severe, severe)


def test_an_answer_alone_says_the_same_of_its_error_as_a_ranking(capsys):
    for model, (mild, severe) in ranking.ERROR_IN_OTHER_PATIENTS.items():
        (said,) = reduced_answer.unknown_error_warning(model)
        assert f"up to {max(mild, severe):.2f} above the 3D model" in said
    measured = {"axisymmetric": (0.8025, 0.7063), "network": (0.7519, 0.7063)}  # lad01 before the intervention
    for model, (value, three_d) in measured.items():
        assert ranking.error_in_other_patients(model, value) >= value - three_d


@pytest.mark.slow
def test_a_plan_is_answered_with_the_extensions_that_its_mesh_would_get(tmp_path):
    radius = tubes.lesion(RADIUS, 0.65, 9.0, 8.0)  # ends 2 mm before the outlet
    tubes.write_case(tmp_path / "near", tubes.tube(15.0, radius, 0.6), [tubes.centre_branch(15.0, radius)])
    near = tmp_path / "near"
    document = tubes.boundary_document([tubes.centre_branch(15.0, radius)], [2e-6], [5e9], 14.0, 0.004)
    (near / "boundary.json").write_text(json.dumps(document))
    line, mesh = ["--centreline", str(near / "centreline.vtp")], str(near / "mesh.msh")
    command_line.main(["mesh", str(near / "lumen.vtp"), *line, "--out", mesh, "--rings", "2"])
    solve = ["solve", mesh, *line, "--boundary", str(near / "boundary.json"), "--out", str(near)]
    command_line.main([*solve, "--model", "axisymmetric"])
    answer = json.loads((near / "ffr.json").read_text())
    assert answer["extensions"]["ends"]
    for model in ("axisymmetric", "network"):
        found = ranking.plan_ffr(near, document, settings_module.make(), model)
        assert found["ffr"] == pytest.approx(answer["models"][model]["ffr"], abs=1e-9)


def test_an_answer_of_another_patient_says_nothing_of_this_one(folder, capfd):
    models = {"3d": {"ffr": 0.88, "error_estimate": 0.001}, "axisymmetric": {"ffr": 0.9}, "network": {"ffr": 0.95}}
    path = folder / "other.json"
    for probes in (_shifted(folder, 0.3, 0.2), _shifted(folder)[:1], [], [{"name": "distal"}]):
        path.write_text(json.dumps({"models": models, "probes": probes}))
        with pytest.raises(SystemExit):
            _rank(folder, "--measured", str(path))
        assert "other boundary values" in capfd.readouterr().err


@pytest.mark.parametrize(
    "models, words",
    [
        ([], ["key models"]),
        ({"3d": 5, "axisymmetric": {"ffr": 0.9}}, ["models.3d", "5"]),
        ({"3d": {"ffr": "x"}, "axisymmetric": {"ffr": 0.9}}, ["models.3d.ffr", "a number"]),
        ({"3d": {"ffr": 0.9, "error_estimate": "x"}, "axisymmetric": {"ffr": 0.9}}, ["models.3d.error_estimate"]),
        ({"3d": {"ffr": 0.9}, "axisymmetric": {"ffr": [0.9]}}, ["models.axisymmetric.ffr"]),
    ],
)
def test_an_answer_of_other_content_is_refused_in_plain_words(folder, capfd, models, words):
    path = folder / "bad.json"
    path.write_text(json.dumps({"models": models, "probes": _shifted(folder)}))
    with pytest.raises(SystemExit) as ended:
        _rank(folder, "--measured", str(path))
    said = capfd.readouterr().err
    assert ended.value.code == 2 and all(word in said for word in [str(path), *words]), said


def test_an_answer_without_the_3d_model_says_nothing_of_the_error():
    with pytest.raises(InputError, match="no 3D answer"):
        ranking.model_error("network", [("ffr.json", {"models": {"network": {"ffr": 0.9}}})], 0.9)


def test_a_plan_with_the_sections_of_another_is_refused(folder, tmp_path):
    """If the sections were accepted, the plan's FFR would be that of the other plan."""
    for name in ("lumen.vtp", "centreline.vtp", "anatomy.json"):
        (tmp_path / name).write_bytes((folder / "small" / name).read_bytes())
    (tmp_path / "sections.csv").write_bytes((folder / "large" / "sections.csv").read_bytes())
    document = json.loads((folder / "boundary.json").read_text())
    with pytest.raises(InputError, match="cross-sections of another lumen"):
        ranking.plan_ffr(tmp_path, document, settings_module.make(), "network")


@pytest.mark.parametrize("plans", [["small"], ["a=small", "a=large"], ["a=nowhere"]])
def test_bad_plans_are_refused(folder, plans, capfd):
    plans = [plan.replace("=", f"={folder}/") for plan in plans]
    with pytest.raises(SystemExit) as ended:
        command_line.main(
            ["rank", *plans, "--boundary", str(folder / "boundary.json"), "--out", str(folder / "refused.csv")]
        )
    assert ended.value.code == 2 and not (folder / "refused.csv").exists()
    assert "plan" in capfd.readouterr().err

"""The benches that compare with published figures: devices, plans, outcomes and slopes."""

import dataclasses
import pathlib

import numpy as np
import pytest

from common import vtp
from common.documents.config import load_case, load_devices
from vci.benchmarks import bench_cases, published, scenes
from vci.benchmarks.bench_cases import CaseOutcome
from vci.benchmarks.device_shapes import ring_diameters

ROOT = pathlib.Path(__file__).resolve().parents[3]
FIGURES = ("below_chart_percent", "area_of_chart_percent", "short_of_chart_mm", "recoil_mm", "gain_mm")
FIGURES += ("expansion_percent",)  # of bench_cases.stenting_figures


def write_tube(path, radii, around=16, spacing=0.5):
    """Writes an open tube with these ring radii (mm) as the file of a device. Returns the path."""
    angle = 2 * np.pi * np.arange(around) / around
    rings = [[r * np.cos(a), r * np.sin(a), spacing * k] for k, r in enumerate(radii) for a in angle]
    path.parent.mkdir(parents=True, exist_ok=True)
    vtp.write(path, scenes.polydata(np.array(rings), scenes.Tube._triangles(len(radii), around)))
    return path


def test_diameters_along_a_device(tmp_path):
    along, figures = ring_diameters(write_tube(tmp_path / "stent.vtp", [1.5, 1.0, 1.0, 1.0, 1.4]))
    assert figures == pytest.approx([3.0, 2.0, 2.0, 2.0, 2.8])
    assert along == pytest.approx([-1.0, -0.5, 0.0, 0.5, 1.0])


def test_entries_of_the_catalogue_make_a_scene():
    families = load_devices(ROOT / "config" / "devices")
    balloon = published.catalogue_entry(families, "non_compliant", 3.0, 15)
    assert balloon["chart"]["diameter_mm"][5] == pytest.approx(3.0) and "source" not in balloon
    stent = published.catalogue_entry(families, "des", 3.0, 18)
    assert (stent["maximal_diameter_mm"], stent["crowns"], stent["balloon"]) == (4.4, 8, "delivery")


@pytest.fixture
def stented(tmp_path):
    """A CaseOutcome with engine and truth: a stent on a balloon of 3.0 mm at 11 bar, then a balloon of 3.3 mm."""
    write_tube(tmp_path / "engine/devices/stent_balloon.vtp", [0.5, 1.3, 1.4, 1.3, 0.5], spacing=2.0)
    chart = {"pressure_bar": [5, 11, 16], "diameter_mm": [2.9, 3.0, 3.1]}
    devices = {"b": {"kind": "balloon", "chart": chart}, "s": {"kind": "stent", "balloon": "b", "length_mm": 5}}
    devices["post"] = {"kind": "balloon", "chart": {"pressure_bar": [10, 20], "diameter_mm": [3.2, 3.4]}}
    procedure = [
        {"name": "stent", "action": "stent", "devices": [{"device": "s", "pressure_bar": 11}]},
        {"name": "post", "action": "postdilatation", "devices": [{"device": "post", "pressure_bar": 15}]},
    ]
    area = np.pi / 4 * 2.64**2
    stent = {"minimal_stent_area_mm2": area, "expansion_index": 0.8}
    engine = {"minimal_stent_area_mm2": area, "csa_profile_before": [{"area_mm2": np.pi}, {"area_mm2": 1.0}]}
    engine["csa_profile"] = [{"area_mm2": area}, {"area_mm2": None}]  # the second plane lies in a side branch
    engine["stents"] = [stent | {"inflated_diameter_mm": 3.1, "final_diameter_mm": 2.9}]
    steps = [{"step": "stent", "inflated_radius_mm": 1.2, "radius_mm": 1.1}]
    steps += [{"step": "post", "inflated_radius_mm": 1.5, "radius_mm": 1.4}]
    narrow = {"radius_before_mm": 0.8, "area_mm2": 1.21 * area}
    slices = [{"stented": True, "history": steps} | narrow, {"stented": False, "history": []}]
    truth = {"minimal_lumen_area_in_stent_mm2": 1.1 * area, "slices": slices}
    return CaseOutcome(tmp_path, {"devices": devices, "procedure": procedure}, engine, truth)


def test_distances_from_the_chart(stented):
    figures = bench_cases.stenting_figures(stented)
    assert figures["engine"]["below_chart_percent"] == pytest.approx(20.0)
    assert figures["truth"]["below_chart_percent"] == pytest.approx(100 * (1 - 0.8 * 1.1**0.5))
    assert figures["engine"]["area_of_chart_percent"] == pytest.approx(64.0)
    assert figures["truth"]["area_of_chart_percent"] == pytest.approx(64.0 * 1.1)
    assert [figures[model]["expansion_percent"] for model in ("engine", "truth")] == pytest.approx([80, 88])
    assert all(set(values) == set(FIGURES) for values in figures.values())
    assert figures["engine"]["recoil_mm"] == pytest.approx(0.2) and figures["truth"]["recoil_mm"] == pytest.approx(0.2)
    assert figures["engine"]["short_of_chart_mm"] == pytest.approx(3.0 - 2.6), "the cylinder's rings, not its cones'"
    assert figures["truth"]["short_of_chart_mm"] == pytest.approx(3.0 - 2.4)
    gains = [figures[model]["gain_mm"] for model in ("engine", "truth")]
    assert gains == pytest.approx([2.64 - 2.0, 1.1 * 2.64 - 1.6])


def test_slopes_are_those_of_the_runs(monkeypatch, tmp_path):
    """Expansion falls by 6 % per 180 degrees and 2 % per 5 mm in the engine, twice that in the truth; one run fails."""

    def fake_run(path, folder, build):
        _, arc, length = folder.name.split("_")
        if (arc, length) == ("90", "5"):
            return CaseOutcome(folder, refusal="too hard")
        return CaseOutcome(folder, engine={"at": (float(arc), float(length))})

    def fake_figures(outcome):
        arc, length = outcome.engine["at"]
        lost = 6 * arc / 180 + 2 * length / 5
        return {"engine": {"expansion_percent": 90 - lost}, "truth": {"expansion_percent": 95 - 2 * lost}}

    monkeypatch.setattr(bench_cases, "run_engine_and_truth", fake_run)
    monkeypatch.setattr(bench_cases, "stenting_figures", fake_figures)
    rows = {row["quantity"]: row for row in published.calcium_slopes(tmp_path, tmp_path)}
    arc = rows["change of expansion by 180 degrees of arc"]
    assert (arc["engine"], arc["truth"], arc["n"]) == ("-6.00", "-12.00", 5) and "1 of 6 refused" in arc["remark"]
    assert rows["change of expansion by 5 mm of length"]["engine"] == "-2.00"
    assert "engine" not in rows["change of expansion by 0.5 mm of thickness"]


def test_the_cases_of_the_benches_are_valid(tmp_path):
    case = load_case(published.calcified_case(tmp_path / "case.yaml", 270, 10, published.STENTING_PLAN))
    assert case["vessel"]["lesions"][0]["calcium"]["arc_deg"] == 270 and len(case["plan"]) == 3


def test_a_refused_case_says_why(tmp_path, capsys):
    (tmp_path / "case.yaml").write_text("kind: synthetic\n")
    outcome = bench_cases.run_engine_and_truth(tmp_path / "case.yaml", tmp_path / "case", tmp_path)
    assert outcome.engine is None and outcome.refusal
    assert outcome.refusal in capsys.readouterr().err


def test_mean_and_standard_deviation_as_text():
    assert published.mean_sd([10.0, 20.0]) == "15 (7.1)" and published.mean_sd([3.0]) == "-"


def test_the_share_of_patients_below_eighty_percent(monkeypatch, tmp_path):
    expansions = iter([70, 79, 81, 90])

    def fake_figures(outcome):
        figures = dict.fromkeys(FIGURES, 1.0) | {"expansion_percent": next(expansions)}
        return {"engine": figures, "truth": figures | {"expansion_percent": 85}}

    for k in range(4):
        (tmp_path / f"patient{k}.yaml").touch()
    monkeypatch.setattr(published, "run_program", lambda command: None)
    outcome = CaseOutcome(tmp_path, engine={"stents": []})
    monkeypatch.setattr(bench_cases, "run_engine_and_truth", lambda *_: outcome)
    monkeypatch.setattr(bench_cases, "stenting_figures", fake_figures)
    row = {row["quantity"]: row for row in published.drawn_cohort(tmp_path, tmp_path, 4, 1)}
    found = row["patients with a smallest area below 80 % of the healthy one"]
    assert (found["engine"], found["truth"], found["published"], found["n"]) == ("50", "0", "34.6", 4)


@pytest.fixture
def rows_without_engine(monkeypatch, tmp_path):
    """The rows of all benches, as they are written when every stent is 3.0 mm wide and every figure is 80."""
    figures = dict.fromkeys(FIGURES, 80.0)
    outcome = CaseOutcome(tmp_path, engine={"stents": []})
    diameters = np.array([-1.0, 0.0, 1.0]), np.full(3, 3.0)
    monkeypatch.setattr(published, "stent_diameters", lambda *arguments: diameters)
    monkeypatch.setattr(published, "ring_diameters", lambda path: diameters)
    monkeypatch.setattr(published, "run_program", lambda command: None)
    monkeypatch.setattr(bench_cases, "run_engine_and_truth", lambda *arguments: outcome)
    monkeypatch.setattr(bench_cases, "stenting_figures", lambda outcome: {"engine": figures, "truth": figures})
    balloon = {"inflated_mm": 2.9, "final_mm": 2.5}
    monkeypatch.setattr(bench_cases, "balloon_figures", lambda outcome: {"engine": balloon, "truth": balloon})
    (tmp_path / "drawn").mkdir()
    for k in range(2):
        (tmp_path / "drawn" / f"patient{k}.yaml").touch()
    families = load_devices(ROOT / "config" / "devices")
    return list(published.all_rows(tmp_path, tmp_path, families, drawn=2, seed=1))


def test_every_published_measurement_has_a_row_or_a_reason(rows_without_engine):
    """Fourteen sources were read. None may be left out without a word."""
    compared = {row["source"] for row in rows_without_engine if row.get("engine")} - {published.NO_SOURCE}
    explained = {entry.source for entry in published.NOT_COMPARED}
    assert len(published.SOURCES) == 14
    assert compared | explained == set(published.SOURCES)
    assert explained - compared == {published.MARTIN, published.KITAHARA}


def test_a_row_without_our_figure_gives_the_reason(rows_without_engine):
    """No row stands empty: it has a figure of ours, or its remark is that of NOT_COMPARED."""
    empty = [row for row in rows_without_engine if not row.get("engine")]
    assert [row["quantity"] for row in empty] == ["change of expansion by 0.5 mm of thickness"]
    assert published.THICKNESS.reason in empty[0]["remark"]


def test_rows_have_the_columns_of_the_table(rows_without_engine, tmp_path):
    published.write_rows(tmp_path / "published.csv", rows_without_engine)
    quantities = [row["quantity"] for row in rows_without_engine]
    assert "4.0 mm stent after a 6.0 mm balloon at 14 bar" in quantities
    assert "gain in lumen diameter along the stent" in quantities
    assert "patients with a smallest area below 80 % of the healthy one" in quantities
    assert "smallest area over the circle of the largest balloon's chart" in quantities
    assert len(quantities) == len(set(zip(quantities, (row["bench"] for row in rows_without_engine))))
    with pytest.raises(ValueError, match="bar"):
        published.write_rows(tmp_path / "published.csv", [{"bar": 1}])


def test_a_balloon_without_stent_is_read_in_its_middle(tmp_path):
    """A refused model is left out."""
    write_tube(tmp_path / "engine/devices/first_balloon.vtp", [0.5, 0.7, 0.8, 0.9, 0.5], spacing=2.0)
    use = {"device": "b", "pressure_bar": 1, "centre_s_mm": 20.0}
    plan = {"procedure": [{"name": "first", "action": "predilatation", "devices": [use]}]}
    profile = [{"s_mm": s, "area_mm2": a} for s, a in ((19.0, 0.9), (20.0, np.pi * 0.7**2), (21.0, None))]
    middle, beside = ([{"step": "first", "inflated_radius_mm": r, "radius_mm": r - 0.1}] for r in (0.9, 0.2))
    slices = [{"s_mm": 17.0, "history": beside}, {"s_mm": 20.4, "history": middle}]
    outcome = CaseOutcome(tmp_path, plan, {"csa_profile": profile}, {"slices": slices})
    figures = bench_cases.balloon_figures(outcome)
    assert figures["engine"] == pytest.approx({"inflated_mm": 1.6, "final_mm": 1.4})
    assert figures["truth"] == pytest.approx({"inflated_mm": 1.8, "final_mm": 1.6})
    refused = dataclasses.replace(outcome, truth=None, refusal="did not converge")
    assert bench_cases.balloon_figures(refused) == {"engine": figures["engine"]}
    assert bench_cases.balloon_figures(CaseOutcome(tmp_path, refusal="no vessel")) == {}


def test_pressures_between_which_a_lesion_opens():
    diameters = {1: 1.0, 2: 2.0, 6: 3.0}
    assert published.opening_pressures(diameters, 1.5) == "1 to 2"
    assert published.opening_pressures(diameters, 2.5) == "2 to 6", "the pressures between were refused"
    assert published.opening_pressures(diameters, 0.9) == "1 or less"
    assert published.opening_pressures(diameters, 3.5) == "more than 6"
    assert published.opening_pressures({}, 3.5) == "-"


def test_a_chart_is_continued_by_its_first_slope():
    plan = {"devices": {"b": {"chart": {"pressure_bar": [2, 4, 6], "diameter_mm": [2.8, 2.9, 3.2]}}}}
    published.continue_chart(plan)
    chart = plan["devices"]["b"]["chart"]
    assert (chart["pressure_bar"], chart["diameter_mm"]) == ([1, 2, 4, 6], pytest.approx([2.75, 2.8, 2.9, 3.2]))

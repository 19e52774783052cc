"""Data of a real patient (lumen after the procedure, pressure wire): metrics, agreement, figures, page."""

import json

import numpy as np
import pytest
from PIL import Image

from reports.__main__ import main
from common.errors import ComputationError, InputError
from reports.study.agreement import agreement_table
from reports.inputs.case_files import CaseFiles
from reports.study.cohort import cohort_table
from reports.study.contrast import contrast_table
from reports.figures.case import case_figures
from reports.figures.study import study_figures
from reports.measuring.pressure_wire import same_decision_share
from reports.measuring.metrics import case_metrics
from reports.page.build import build_report
from reports.page.check import read_pages
from reports.selection.flow_chart import inclusion_figure
from reports.selection.patients import inclusion_table, patients_table
from reports.study.differences import difference_table, station_table
from reports.study.nearer import nearer_table
from reports.study.timings import timings_table
from common.files import write_json, write_table

STATES = ("pre", "vci", "rc", "post")
WIRE_MM = 37.0


def metrics_of(folder):
    config = folder / "case.yaml"
    return case_metrics(CaseFiles(folder.name, folder), config=config if config.exists() else None)


def test_a_wire_stands_beside_what_is_computed_at_its_sensor(make_case, tube):
    document = metrics_of(make_case(states=STATES, wire=WIRE_MM))
    assert document["measured"] == {"ffr_pre": 0.62, "ffr_post": 0.91, "branch": "main", "s_mm": WIRE_MM}
    map_pa = document["patient"]["map_pa"]
    for state in STATES:
        assert document["states"][state]["ffr"]["at_wire"] == pytest.approx(tube(state).pressure(WIRE_MM) / map_pa)
    assert document["registration"]["residual_mm"]["trimmed_rms"] == 0.12
    assert {"vci_minus_post", "rc_minus_post"} == set(document["differences"])


def test_what_the_registration_warns_of_is_kept(make_case):
    folder = make_case(states=STATES)
    path = folder / "post" / "registration.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"warnings": ["it may be another vessel"]}))
    assert metrics_of(folder)["lumen_warnings"]["post"][-1] == "it may be another vessel"


def test_agreement_with_post_and_wire(make_case):
    folders = [make_case(f"real{k}", states=STATES, change=c, wire=WIRE_MM) for k, c in enumerate((0.0, 0.02, -0.03))]
    documents = [metrics_of(folder) for folder in folders]
    for document in documents:  # so that all are included
        document["states"]["pre"]["ffr"]["distal"] = 0.7
    table = agreement_table(documents).set_index(["quantity", "comparison"])
    row = table.loc[("ffr", "pre_minus_measured")]
    computed = [document["states"]["pre"]["ffr"]["at_wire"] for document in documents]
    assert row["error"] == "measured" and row["n"] == 3
    assert row["bias"] == pytest.approx(sum(computed) / 3 - 0.62)
    assert row["loa_upper"] - row["loa_lower"] == pytest.approx(2 * 1.96 * row["sd"])
    after = table.loc[("ffr", "post_minus_measured")]
    assert after["mean_b"] == pytest.approx(0.91) and after["same_decision"] == 1.0
    assert ("mean_area", "pre_minus_measured") not in table.index, "a wire reads no areas"
    clinical = table.loc[("mean_area", "vci_minus_post")]
    assert clinical["error"] == "clinical" and clinical["published_bias"] == -1.55
    cohort = cohort_table(documents)
    assert cohort["measured_ffr_pre"].tolist() == [0.62] * 3 and cohort["post_ffr_distal"].notna().all()


@pytest.mark.parametrize("computed, measured, share", [((0.8, 0.9), (0.7, 0.81), 1.0), ((0.81, 0.9), (0.8, 0.85), 0.5)])
def test_decisions(computed, measured, share):
    assert same_decision_share(computed, measured) == share


def test_areas_only(make_case):
    """Without a flow after the procedure, areas are still compared."""
    document = metrics_of(make_case(states=STATES, compare="areas"))
    assert document["states"]["post"]["ffr"] is None and document["measured"] is None
    difference = document["differences"]["vci_minus_post"]
    assert difference["ffr"] is None and difference["ffr_distal"] is None
    assert difference["area_mm2"]["bias"] > 0, "opened further than the lumen found"
    table = agreement_table([document]).set_index(["quantity", "comparison"])
    assert ("ffr", "vci_minus_post") not in table.index and ("mean_area", "vci_minus_post") in table.index
    assert cohort_table([document])["post_ffr_distal"].isna().all()


def test_a_wire_that_the_flow_does_not_know_of_is_refused(make_case):
    folder = make_case(states=STATES, wire=WIRE_MM)
    boundary = folder / "flow" / "boundary.json"
    boundary.write_text(boundary.read_text().replace('"measured"', '"distal"'))
    with pytest.raises(InputError, match="no probe at the wire(.|\n)*flow boundary"):
        metrics_of(folder)


@pytest.mark.parametrize("first, last, covered", [(0.0, 27.0, 14.6), (14.0, 40.0, 15.6), (0.0, 40.0, 22.0)])
def test_a_lumen_that_ends_within_the_stent_is_compared_where_it_is(make_case, ended, capsys, first, last, covered):
    """The segment is 10 to 32 mm with its margins; sections within 2.4 mm of an end are flagged `end`."""
    folder = make_case(states=STATES, wire=WIRE_MM)
    whole = metrics_of(folder)
    capsys.readouterr()
    ended(folder, first, last)
    document = metrics_of(folder)
    assert document["registration"]["covered_mm"] == pytest.approx(covered, abs=0.25)
    assert document["registration"]["segment_mm"] == pytest.approx(22.0)
    said = capsys.readouterr().err
    assert ("of the 22.0 mm" in said) == (covered < 22.0)
    used, at = document["stations"]["relative_position"], whole["stations"]["relative_position"]
    for state, entry in document["states"].items():
        # The values are those of the whole lumen at the same places, up to interpolation between sections.
        for key, values in (("profile_mm2", entry["area"]), ("profile", entry["ffr"])):
            before = whole["states"][state]["area" if key == "profile_mm2" else "ffr"][key]
            assert values[key] == pytest.approx(np.interp(used, at, before), rel=2e-3)
    assert (document["states"]["post"]["ffr"]["past_segment"] is None) == (last < 32.0 or first > 10.0)


def test_a_lumen_that_covers_less_than_half_of_the_stent_is_refused(make_case, ended):
    folder = make_case(states=STATES)
    ended(folder, 0.0, 22.0)
    with pytest.raises(ComputationError, match="too few stations(.|\n)*post has the fewest"):
        metrics_of(folder)


def test_another_state_may_not_end_within_the_stent(make_case, ended):
    folder = make_case(states=STATES)
    ended(folder, 0.0, 27.0, state="vci")
    with pytest.raises(ComputationError, match="off the axis"):
        metrics_of(folder)


@pytest.mark.slow
@pytest.mark.parametrize("compare", ["flow", "areas"])
def test_figures_and_page(make_case, tmp_path, compare):
    folder = make_case("patient", states=STATES, compare=compare, wire=WIRE_MM)
    document = metrics_of(folder)
    files = CaseFiles("patient", folder)
    write_json(files.metrics, document)
    figures, study = tmp_path / "figures", tmp_path / "study"
    Image.new("RGB", (4, 4)).save(folder / "vci" / "plan.png")
    write_json(folder / "vci" / "plan.json", {"procedure": []})
    case_figures(files, figures)
    study_figures([document], figures)
    pullback = (figures / "patient_pullback.svg").read_text()
    assert "Pressure wire before PCI: 0.62" in pullback and "Pressure wire after PCI: 0.91" in pullback
    assert ("After the real PCI" in pullback) == (compare == "flow")
    write_table(study / "agreement.csv", agreement_table([document]), digits=None)
    write_table(study / "half_maximum.csv", agreement_table([]), digits=None)
    write_table(study / "differences.csv", difference_table([document]), digits=None)
    write_table(study / "differences_stations.csv", station_table([document]), digits=None)
    write_table(study / "cohort.csv", cohort_table([document]), digits=None)
    write_table(study / "nearer.csv", nearer_table([document]), digits=None)
    write_table(study / "contrast.csv", contrast_table([document]), digits=None)
    patients = patients_table([document], {"patient": {"patient": {"territory": "lad"}}})
    write_table(study / "patients.csv", patients, digits=None)
    steps = inclusion_table(patients, {"patient": list(STATES)})
    write_table(study / "inclusion.csv", steps, digits=None)
    inclusion_figure(steps, figures)
    write_table(study / "timings.csv", timings_table([files]), digits=None)
    seconds = ["--out", str(study / "seconds.csv"), "--figures-dir", str(figures)]
    main(["seconds", "--timings", str(study / "timings.csv"), *seconds])
    failed = {"case": "other", "step": "plan", "exit_code": 3, "message": "error: <none> fits", "log": "plan.log"}
    write_json(tmp_path / "failed.json", {"failed": [failed]})
    build_report([files], study, figures, tmp_path / "report", failed=tmp_path / "failed.json")
    page, case = (tmp_path / "report" / name for name in ("index.html", "cases/patient.html"))
    assert read_pages(page)
    page, case = page.read_text(), case.read_text()
    for words in ("Computed minus measured", "After the real PCI", "1 of 2 cases has no result"):
        assert words in page, words
    assert "error: &lt;none&gt; fits" in page and "--config cases=patient failed=" in page
    for words in (
        "FFR at the pressure wire",
        "0.12 mm are left between the axes",
        "Virtual PCI (VCI) − after PCI",
        "After the real PCI",
        "where each device lies",
        "FFR at each probe",
    ):
        assert words in case, words
    assert ("No flow is computed in it" in case) == (compare == "areas")
    assert "Nothing here has been compared" not in page

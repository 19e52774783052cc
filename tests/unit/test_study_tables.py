"""tests/verification/study_tables.py: the tables of docs/nine-patients.md, from small files of results/study."""

import json
import pathlib
import sys

import numpy as np
import pytest

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "verification")]

import study_tables  # noqa: E402
import study_reference  # noqa: E402
from page_tables import TABLE_MARKS  # noqa: E402

from common import vtp  # noqa: E402
from reports.study.agreement import published_results  # noqa: E402
from vci.benchmarks import scenes  # noqa: E402

COHORT = """case,pre_ffr_distal,reference_ffr_distal,vci_ffr_distal,rc_ffr_distal,{areas},deployment_expansion_index
a,0.70,0.90,0.91,0.92,{values},0.8
b,0.72,0.94,,0.96,{values},
"""
AREAS = [f"{state}_{area}_area_mm2" for state in ("pre", "reference", "vci", "rc") for area in ("mean", "minimum")]
AREAS += [f"{state}_mean_curvature_per_mm" for state in ("pre", "reference", "vci", "rc")]


@pytest.fixture
def results(tmp_path):
    (tmp_path / "study").mkdir()
    values = ",".join(str(1.5 + k) for k in range(len(AREAS)))
    (tmp_path / "study" / "cohort.csv").write_text(COHORT.format(areas=",".join(AREAS), values=values))
    return tmp_path


def test_a_row_a_patient_and_empty_where_nothing_is_known(results):
    lines = study_tables.patients(results).splitlines()
    assert len(lines) == 4
    assert lines[2].startswith("| a | 0.700 | 0.900 | 0.910 | 0.920 | 3.50 | 5.50 | 7.50 | 4.50 | 6.50 | 8.50 | 0.80 |")
    assert lines[3].startswith("| b | 0.720 | 0.940 |  | 0.960 |") and lines[3].endswith("|  |")


def test_mean_and_deviation_of_those_that_have_a_value(results):
    ffr = study_tables.spread(results).splitlines()[2]
    assert ffr.startswith("| FFR | 0.710 ± 0.014 | 0.920 ± 0.028 | 0.910 |")


def test_straightening_is_the_share_of_the_curvature_before(results):
    """From 9.5 /mm before to 10.5 in the reference: less by -11 %. A patient without a predicted lumen has no share."""
    lines = study_tables.straightening(results).splitlines()
    assert lines[2] == "| a | 9.500 | 10.500 | 11.500 | 12.500 | -11 | -21 | -32 |"
    assert lines[4] == "| all |  |  |  |  | -11 ± 0 | -21 ± 0 | -32 ± 0 |"
    path = results / "study" / "cohort.csv"
    path.write_text(
        path.read_text().replace("11.5,12.5,\n", ",12.5,\n").replace("10.5,11.5,12.5,0.8", "4.75,11.5,12.5,0.8")
    )
    lines = study_tables.straightening(results).splitlines()
    assert lines[2].endswith("| 50 | -21 | -32 |") and lines[3].endswith("|  | 12.500 | -11 |  | -32 |")
    assert lines[4] == "| all |  |  |  |  | 20 ± 43 |  | -32 ± 0 |"


def _write_sensitivity(results, case, name, text):
    folder = results / "cases" / case / "sensitivity"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.csv").write_text(text)


def test_intervals_and_inputs_of_the_flow_over_the_patients(results):
    head = "state,quantity,planned,lower,upper,samples,left_out,inputs\n"
    flow = "state,quantity,input,words,unit,low,planned,high,at_low,at_planned,at_high\n"
    for case, up in (("a", 0.01), ("b", 0.03)):
        _write_sensitivity(
            results,
            case,
            "flow_intervals",
            f"{head}pre,ffr,0.7,0.6,0.75,128,0,7\nvci,ffr,0.9,0.88,{0.9 + up},128,0,7\n",
        )
        rows = [f"{state},ffr,mass,mass,%,-20,0,20,{0.7 + up},0.7,0.68" for state in ("pre", "vci")]
        rows += [f"{state},ffr,blood,blood,%,-20,0,20,0.64,0.7,0.71" for state in ("pre", "vci")]
        _write_sensitivity(results, case, "flow", flow + "\n".join(rows) + "\n")
    lines = study_tables.intervals(results).splitlines()
    assert lines[2] == "| a | 0.700 | 0.600 to 0.750 | 0.150 | 0.900 | 0.880 to 0.910 | 0.030 |" and len(lines) == 4
    lines = study_tables.flow_inputs(results).splitlines()  # the input that moves FFR most comes first
    assert lines[2].startswith("| blood | -0.0600 | +0.0100 | 0.0600 |")
    assert lines[3].startswith("| mass | +0.0200 | -0.0200 | 0.0300 |") and len(lines) == 4


def test_inputs_of_the_deployment_of_the_patients_asked_for(results):
    assert study_tables.deployment_inputs(results) is None
    head = "state,quantity,input,words,unit,low,planned,high,at_low,at_planned,at_high\n"
    rows = ["vci,ffr,balloon_pressure,pressure,%,-20,0,20,0.91,0.92,0.925"]
    rows += ["vci,minimal_stent_area_mm2,balloon_pressure,pressure,%,-20,0,20,,6.5,7"]
    _write_sensitivity(results, "b", "deployment", head + "\n".join(rows) + "\n")
    head = "state,quantity,planned,lower,upper,samples,left_out,inputs\n"
    rows = ["vci,ffr,0.92,0.9,0.93,16,0,11", "vci,minimal_stent_area_mm2,6.5,5,7.25,16,0,11"]
    _write_sensitivity(results, "b", "deployment_intervals", head + "\n".join(rows) + "\n")
    one, together = study_tables.deployment_inputs(results).splitlines()[2:]
    assert one == "| b | pressure | -20 to 20 % | 0.9100 / 0.9200 / 0.9250 | none / 6.50 / 7.00 |"
    assert together.endswith("| 0.9000 to 0.9300 | 5.00 to 7.25 |")


@pytest.mark.parametrize(
    "value, said", [("0.00079", "+0.00079"), ("-0.0126", "-0.013"), ("0.31", "+0.310"), ("0", "0.000")]
)
def test_a_small_bias_has_two_digits(value, said):
    assert study_tables.format_small(value, 3) == said


def test_published_values_keep_the_digits_of_the_source(results):
    """The study's own values have as many as they need, the published ones no invented digit."""
    columns = "patients,quantity,comparison,n,bias,sd,loa_lower,loa_upper,published_bias,published_sd"
    rows = ["included,ffr,ct_vci_minus_ct,9,-0.00077,0.0021,-0.005,0.003,-0.02,0.05"]
    rows += ["included,mean_area,ct_vci_minus_ct,9,-0.53,0.438,-1.38,0.33,-1.55,1.89"]
    rows += ["included,minimum_area,ct_vci_minus_ct,9,-0.7,0.628,-1.93,0.53,,"]
    (results / "study" / "agreement.csv").write_text("\n".join([columns, *rows]) + "\n")
    ffr, area, smallest = study_tables.agreement(results).splitlines()[2:]
    assert ffr.endswith("| -0.00077 | 0.0021 | -0.0050 to +0.0030 | -0.02 ± 0.05 |")
    assert area.endswith("| -1.55 ± 1.89 |") and smallest.endswith("|  |")
    rows = [
        "by,name,n,mean_s,sd_s,published_mean_s,published_sd_s",
        "step,stent,9,4.16,2.54,8.5,",
        "all,a,9,1,2,24.92,1.0",
    ]
    (results / "study" / "seconds.csv").write_text("\n".join(rows) + "\n")
    step, procedure = study_tables.seconds(results).splitlines()[2:]
    assert step.endswith("| 8.50 |") and procedure.endswith("| 24.92 ± 1.00 |")


def test_published_values_of_the_page_are_those_of_the_file():
    text, published = study_tables.PAGE.path.read_text(), published_results()["quantities"]
    agreement = {f"{row['bias']:.2f} ± {row['sd']:.2f}" for row in published.values()}
    tables = {found[2]: found[0].splitlines() for found in TABLE_MARKS.finditer(text)}
    for name in ("agreement", "half_maximum"):
        cells = {line.split("|")[-2].strip() for line in tables[name] if "all together" in line}
        assert cells - {""} == agreement, name
    for row in published.values():
        assert all(f"{row[state]['mean']:.2f} ± {row[state]['sd']:.2f}" in text for state in ("predicted", "reference"))


def test_the_page_says_that_p_is_not_corrected():
    text = " ".join(study_tables.PAGE.path.read_text().split())
    assert "The p values are not corrected for the number of rows" in text


def test_the_page_has_a_place_for_each_table_and_keeps_what_was_not_run(tmp_path):
    text = study_tables.PAGE.path.read_text()
    assert study_tables.PAGE.names(text) == set(study_tables.TABLE_FUNCTIONS)
    assert study_tables.PAGE.filled(text, tmp_path) == text


def _write_stent(path, diameter_mm, tilt=0.0, count=24):
    """A stent of 10 mm on the axis x, its rings tilted. Its diameter is larger by 0.1 mm for each mm along it."""
    angle, s_mm = 2 * np.pi * np.arange(count) / count, np.linspace(-5, 5, 21)
    radius = 0.5 * (diameter_mm + 0.1 * s_mm)[:, None]
    y, z = radius * np.cos(angle), radius * np.sin(angle)
    points = np.stack([s_mm[:, None] + tilt * y, y, z], axis=-1).reshape(-1, 3)
    path.parent.mkdir(parents=True, exist_ok=True)
    vtp.write(path, scenes.polydata(points, scenes.Tube._triangles(len(s_mm), count)))


@pytest.fixture
def treated(tmp_path):
    """A case with a predilatation, a stent and a postdilatation; the truth is narrowest 2 mm past its middle."""
    vci, truth = (tmp_path / "cases" / "a" / name for name in ("vci", "reference"))
    _write_stent(vci / "devices" / "stent1.vtp", 2.8)
    for number, diameter in ((3, 2.0), (4, 2.9), (6, 2.5), (7, 3.1)):
        _write_stent(vci / "frames" / f"frame_device1_{number:04d}.vtp", diameter)
    names = [("pre", "predilatation"), ("stent", "stent"), ("post", "postdilatation")]
    (vci / "scene.json").write_text(json.dumps({"procedure": [{"name": n, "action": a} for n, a in names]}))
    stages = ("deployment-to-contact", "contact-to-balance", "balloon-extraction")
    stages = [{"step": name, "stage": stage} for name, _ in names for stage in stages]
    area = [{"s_mm": 30.0, "area_mm2": 0.25 * np.pi * 3.0**2}, {"s_mm": 31.0, "area_mm2": None}]
    (vci / "deployment.json").write_text(json.dumps({"stages": stages, "csa_profile": area}))
    truth.mkdir()
    history = [{"inflated_radius_mm": 1.7, "radius_mm": 1.5}, {"inflated_radius_mm": 1.6, "radius_mm": 1.53}]
    slices = [
        {"s_mm": s, "stented": s > 20, "radius_before_mm": r, "history": history}
        for s, r in ((10, 0.3), (25, 0.9), (32, 0.6))
    ]
    stents = [{"start_s_mm": 25.0, "end_s_mm": 35.0}]
    (truth / "reference.json").write_text(json.dumps({"slices": slices, "stents": stents}))
    return tmp_path


def test_the_narrowest_place_of_truth_and_stent(treated):
    """The last frame of an inflation counts for the stent, not one of an extraction, at the place of the slice."""
    lines = study_reference.throats(treated).splitlines()
    assert lines[2] == "| a | 1.20 | 3.40 | 3.30 | 3.06 | 3.00 | 3.00 | 10.0 | 9.1 |"
    assert lines[3] == "| all |  |  |  |  |  |  | 10.0 | 9.1 |"


def test_a_tilted_ring_counts_by_its_section_across_the_axis(tmp_path):
    _write_stent(tmp_path / "stent.vtp", 3.0, tilt=0.3)
    assert study_reference.ring_diameter(tmp_path / "stent.vtp", 0.0) == pytest.approx(3.0, rel=1e-6)


def test_no_table_of_narrowest_places_without_frames(results):
    assert study_reference.throats(results) is None


def test_the_truths_own_error_has_a_row_a_patient(tmp_path):
    assert study_reference.truth_errors(tmp_path) is None
    folder = tmp_path / "cases" / "lad01" / "reference"
    folder.mkdir(parents=True)
    estimate = {"slices": [{}], "step_area_percent": 0.0207, "mesh_area_percent": -0.0042}
    estimate |= {"mesh_and_step_area_percent": 0.0166, "spacing_area_percent": {"mean": 0.121, "largest": 0.51}}
    truth = {"case": "lad01", "slices": [{}, {}, {}], "error_estimate": estimate}
    (folder / "reference.json").write_text(json.dumps(truth))
    line = study_reference.truth_errors(tmp_path).splitlines()[2]
    assert line == "| lad01 | 3 | 1 | 0.021 | 0.004 | 0.017 | 0.12 | 0.51 |"

"""agreement.csv, cohort.csv and timings.csv."""

import pandas as pd
import pytest

from common.errors import InputError
from reports.__main__ import main, parser
from reports.study.agreement import agreement_table, published_results
from reports.inputs.case_files import CaseFiles
from reports.study.cohort import cohort_table
from reports.measuring.metrics import case_metrics
from reports.page import build
from reports.record import numbers
from reports.study.seconds import seconds_by_group, seconds_table, stage_seconds
from reports.study.tables import WRITTEN_BY, study_table
from reports.study.timings import timings_table
from workflow.__main__ import main as workflow


def documents(make_case, changes, **options):
    """metrics.json of cases. FFR before PCI is set to 0.7, so that all are included."""
    found = [
        case_metrics(CaseFiles(f"tube{k}", make_case(f"tube{k}", change=change, **options)))
        for k, change in enumerate(changes)
    ]
    for document in found:
        document["states"]["pre"]["ffr"]["distal"] = 0.7
    return found


def test_agreement_of_three_cases(make_case):
    cases = documents(make_case, [0.0, 0.02, -0.03])
    table = agreement_table(cases).set_index(["quantity", "comparison"])
    row = table.loc[("mean_area", "vci_minus_reference")]
    means = [[case["states"][state]["area"]["mean_mm2"] for case in cases] for state in ("vci", "reference")]
    assert row["n"] == 3
    assert row["bias"] == pytest.approx(sum(means[0]) / 3 - sum(means[1]) / 3)
    assert row["bias_ci_lower"] < row["bias"] < row["bias_ci_upper"]
    assert table["published_bias"].isna().all(), "the published agreement is not of this kind"
    assert set(table["error"]) == {"method"}
    assert len(table) == 8
    assert table.loc[("minimum_area", "vci_minus_reference"), "bias"] == pytest.approx(0.60, abs=0.01)


def test_four_errors_are_kept_apart(make_case):
    states = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
    cases = documents(make_case, [0.0, 0.02, -0.03], states=states)
    table = agreement_table(cases).set_index(["quantity", "comparison"])
    assert len(table) == 28
    kinds = table["error"].xs("mean_area", level="quantity").to_dict()
    assert kinds == {
        "vci_minus_reference": "method",
        "rc_minus_reference": "method",
        "ct_vci_minus_vci": "imaging_before",
        "ct_rc_minus_rc": "imaging_before",
        "ct_minus_reference": "imaging_after",
        "ct_vci_minus_ct": "clinical",
        "ct_rc_minus_ct": "clinical",
    }
    bias = table["bias"].xs("mean_area", level="quantity")
    method_and_before = bias["vci_minus_reference"] + bias["ct_vci_minus_vci"]
    assert bias["ct_vci_minus_ct"] == pytest.approx(method_and_before - bias["ct_minus_reference"])
    assert abs(bias["ct_minus_reference"]) > 0.05
    row = table.loc[("mean_area", "ct_vci_minus_ct")]
    assert (row["published_bias"], row["published_sd"], row["published_n"]) == (-1.55, 1.89, 9)
    assert (
        table.drop(index=[(q, "ct_vci_minus_ct") for q in ("ffr", "mean_area", "mean_curvature")])["published_bias"]
        .isna()
        .all()
    )


def test_published_limits_follow_from_bias_and_sd_where_the_note_says_so():
    paper = published_results()["quantities"]
    for name, tolerance in (("mean_area", 0.06), ("mean_curvature", 0.03)):
        row = paper[name]
        assert row["bias"] == pytest.approx(row["predicted"]["mean"] - row["reference"]["mean"], abs=0.011)
        assert row["loa_lower"] == pytest.approx(row["bias"] - 1.96 * row["sd"], abs=tolerance)
        assert row["loa_upper"] == pytest.approx(row["bias"] + 1.96 * row["sd"], abs=tolerance)


def test_cases_without_reference_leave_an_empty_agreement(make_case, tmp_path):
    case = case_metrics(CaseFiles("own", make_case("own", states=("pre", "vci"))))
    assert agreement_table([case]).empty
    row = cohort_table([case]).iloc[0]
    assert row["kind"] == "surface" and row["reference_ffr_distal"] is None
    assert row["procedure"] == "predilatation: 3.00x15 mm balloon at 12 bar; stent: 3.50x18 mm stent at 11 bar"


def test_timings_from_benchmarks_and_programs(make_case):
    table = timings_table([CaseFiles("tube", make_case())]).set_index("step")
    assert table.loc["deploy", ["source", "seconds", "cpu_s", "peak_memory_mib"]].tolist() == [
        "workflow",
        1.5,
        1.4,
        120.5,
    ]
    assert table.loc["vci/stent/balloon-extraction", "seconds"] == 0.2
    assert table.loc["pre/anatomy/remesh", "seconds"] == 1.25
    assert table.loc["reference/flow", "peak_memory_mib"] == 900.0


def test_seconds_by_stage_and_step():
    rows = [("one", "vci/stent/balloon-extraction", 2.0), ("one", "vci/postdilatation/balloon-extraction", 3.0)]
    rows += [("one", "vci/postdilatation_2/contact-to-balance", 4.0), ("two", "vci/stent/balloon-extraction", 7.0)]
    rows += [("one", "vci/anatomy/remesh", 50.0), ("one", "vci", 9.0), ("one", "ct_vci/stent/balloon-extraction", 60.0)]
    timings = pd.DataFrame([{"case": c, "step": s, "source": "program", "seconds": t} for c, s, t in rows])
    groups = seconds_by_group(stage_seconds(timings))
    assert groups["stage", "balloon-extraction"].tolist() == [5.0, 7.0]
    assert groups["step", "postdilatation"].tolist() == [7.0], "both post-dilatations of the one patient"
    assert groups["all", "procedure"].tolist() == [9.0, 7.0]
    table = seconds_table(timings).set_index(["by", "name"])
    assert table.loc[("all", "procedure"), ["n", "mean_s", "published_mean_s"]].tolist() == [2, 8.0, 24.92]
    assert table.loc[("stage", "balloon-extraction"), "published_mean_s"] == 9.17
    assert seconds_table(timings[timings["case"] == "none"]).empty


def test_a_step_that_was_not_sampled_has_no_processor_time(make_case):
    folder = make_case()
    benchmark = folder / "benchmarks" / "deploy.tsv"
    benchmark.write_text(benchmark.read_text().replace("\t1.40", "\t0.00"))
    row = timings_table([CaseFiles("tube", folder)]).set_index("step").loc["deploy"]
    assert row["seconds"] == 1.5 and pd.isna(row["cpu_s"])


def test_the_commands_write_the_same_bytes_twice(make_case, tmp_path):
    folder = make_case("tube")
    for out in ("a", "b"):
        main(["metrics", "--case", "tube", "--case-dir", str(folder), "--out", str(tmp_path / out / "metrics.json")])
        for name in ("agreement", "cohort"):
            arguments = [
                "--metrics",
                str(tmp_path / out / "metrics.json"),
                "--out",
                str(tmp_path / out / f"{name}.csv"),
            ]
            main([name, *arguments])
    for name in ("metrics.json", "agreement.csv", "cohort.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert pd.read_csv(tmp_path / "a" / "agreement.csv")["n"].tolist() == [1] * 8


def test_a_command_ends_with_one_message(make_case, tmp_path, capsys):
    folder = make_case("tube")
    (folder / "vci" / "scene.json").unlink()
    out = tmp_path / "metrics.json"
    with pytest.raises(SystemExit) as end:
        main(["metrics", "--case", "tube", "--case-dir", str(folder), "--out", str(out)])
    assert end.value.code == 2 and not out.exists()
    said = capsys.readouterr().err
    assert "scene.json" in said and "run the step that writes it: workflow scene" in said


def test_the_commands_that_messages_name_exist(capsys):
    for table in (*build.TABLES, *numbers.TABLES, "cohort"):
        assert table in WRITTEN_BY
    known = next(action for action in parser()._actions if action.dest == "command").choices
    for command in WRITTEN_BY.values():
        part, name = command.split()
        assert part == "reports" and name in known, command
    with pytest.raises(SystemExit) as end:
        workflow(["scene", "--help"])
    assert end.value.code == 0, capsys.readouterr().err


@pytest.mark.parametrize("table, command", [("inclusion", "patients"), ("half_maximum", "agreement")])
def test_a_table_that_is_missing_names_the_command_that_writes_it(tmp_path, table, command):
    with pytest.raises(InputError, match=f"(?s){table}.csv.*reports {command}$"):
        study_table(tmp_path, table)


def test_a_case_given_twice_is_refused(make_case, tmp_path):
    folder, out = make_case("tube"), tmp_path / "metrics.json"
    main(["metrics", "--case", "tube", "--case-dir", str(folder), "--out", str(out)])
    with pytest.raises(SystemExit):
        main(["cohort", "--metrics", str(out), str(out), "--out", str(tmp_path / "cohort.csv")])


def test_an_unpaired_value_is_refused(make_case):
    cases = documents(make_case, [0.0])
    cases[0]["states"]["vci"]["area"]["mean_mm2"] = None
    with pytest.raises(InputError, match="finite number"):
        agreement_table(cases)

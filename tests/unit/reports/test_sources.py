"""Under each figure and table of the report: its data as CSV, and the command that makes it again."""

import json
import re

import pandas as pd
import pytest

from common.errors import InputError
from reports.inputs.case_files import CaseFiles
from reports.measuring.metrics import case_metrics
from reports.page.data_files import (
    difference_rows,
    flow_rows,
    profile_table,
    pullback_table,
    sensitivity_tables,
    state_rows,
)
from reports.page.folder import TEMPLATE_FOLDER
from reports.page.sources import SOURCES, selection, source_of
from reports.study.tables import WRITTEN_BY

STUDY_DATA = {f"{name}.csv" for name in WRITTEN_BY} | {"differences_stations.csv"}


def test_templates_name_each_source_and_no_other():
    texts = [file.read_text() for file in TEMPLATE_FOLDER.glob("*.j2")]
    named = {name for text in texts for name in re.findall(r'\bsource\("(\w+)"\)', text)}
    curves = {"pullback", "area", "curvature"}  # templates take these names from reports.page.case_context.CURVES
    assert named | curves == set(SOURCES)


def test_a_source_with_its_data_and_command():
    found = source_of("agreement", STUDY_DATA, "--config cohort=quick")
    assert found["data"] == ["agreement.csv"]
    assert found["command"] == "snakemake -j2 results/study/agreement.csv --config cohort=quick"
    found = source_of("states", {"a_states.csv"}, "--config cohort=quick", "a")
    assert found["data"] == ["a_states.csv"], "without the differences: the case has no reference"
    assert found["command"] == "snakemake -j2 results/cases/a/metrics.json", "a case needs no cohort"


def test_a_source_without_data_says_why():
    assert (
        source_of("lumen", set(), "", "a")["note"]
        == "surfaces <code>results/cases/a/&lt;state&gt;/anatomy/lumen.vtp</code>"
    )
    with pytest.raises(InputError, match="a figure or table has no data"):
        source_of("agreement", set(), "")
    silent = [name for name, source in SOURCES.items() if not (source.target or source.note)]
    assert not silent, "neither a command nor who writes it"


@pytest.mark.parametrize(
    "arguments, options",
    [
        (("nine", ["a", "b"], None), "--config cohort=nine"),
        (("", ["a", "b"], None), "--config 'cases=a b'"),
        (("nine", ["a"], "results/study/failed.json"), "--config cohort=nine failed=results/study/failed.json"),
    ],
)
def test_files_of_the_study_are_asked_for_with_their_cases(arguments, options):
    assert selection(*arguments) == options


def test_the_tables_of_a_case(make_case):
    files = CaseFiles("tube", make_case())
    metrics = case_metrics(files)
    states = state_rows(metrics).set_index("state")
    assert list(states.index) == ["pre", "vci", "rc", "reference"]
    assert states.at["vci", "mean_area_mm2"] == metrics["states"]["vci"]["area"]["mean_mm2"]
    assert states.at["vci", "ffr_distal"] == metrics["states"]["vci"]["ffr"]["distal"]
    assert states["ffr_measured"].isna().all(), "no wire"
    differences = difference_rows(metrics).set_index("comparison")
    known = metrics["differences"]["vci_minus_reference"]
    assert differences.at["vci_minus_reference", "area_rmse_mm2"] == known["area_mm2"]["rmse"]
    assert differences.at["vci_minus_reference", "curvature_bias_per_mm"] == known["curvature_per_mm"]["bias"]
    profiles = profile_table(metrics)
    assert len(profiles) == 4 * metrics["stations"]["used"]
    of_rc = profiles[profiles["state"] == "rc"]
    assert list(of_rc["area_mm2"]) == metrics["states"]["rc"]["area"]["profile_mm2"]
    assert list(of_rc["ffr"]) == metrics["states"]["rc"]["ffr"]["profile"]


def test_the_pull_backs_of_a_case_are_those_of_its_states(make_case):
    files = CaseFiles("tube", make_case())
    table = pullback_table(files, ["pre", "vci"])
    assert list(table)[0] == "state"
    for state in ("pre", "vci"):
        own = table[table["state"] == state].drop(columns="state").reset_index(drop=True)
        pd.testing.assert_frame_equal(own, pd.read_csv(files.flow(state) / "pullback.csv"))


def test_states_without_a_flow_have_areas_alone(make_case):
    files = CaseFiles("tube", make_case(states=("pre", "vci", "rc", "post"), compare="areas"))
    metrics = case_metrics(files)
    states = state_rows(metrics).set_index("state")
    assert states.loc["post", ["ffr_distal", "ffr_error_estimate"]].isna().all()
    assert states.at["post", "mean_area_mm2"] == metrics["states"]["post"]["area"]["mean_mm2"]
    differences = difference_rows(metrics).set_index("comparison")
    assert pd.isna(differences.at["vci_minus_post", "ffr_bias"]) and differences.at["vci_minus_post", "area_sd_mm2"] > 0
    profiles = profile_table(metrics)
    assert profiles.loc[profiles["state"] == "post", "ffr"].isna().all()


def test_the_flow_of_a_case(make_case):
    files = CaseFiles("tube", make_case())
    solution = json.loads((files.flow("vci") / "ffr.json").read_text()) | {"cells": 20, "dofs": 100}
    table = flow_rows({"vci": {"solution": solution, "error": 0.001, "reduced_ffr": 0.9}})
    row = table.iloc[0]
    assert (row["state"], row["ffr"], row["ffr_error_estimate"], row["unknowns"]) == (
        "vci",
        solution["ffr"],
        0.001,
        100,
    )


def test_a_case_whose_inputs_were_not_varied_has_no_sensitivity(make_case):
    assert sensitivity_tables(make_case()) == {}

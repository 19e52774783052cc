"""The CSV files behind the report's tables and figures: copies of the study's tables, and tables made for each case."""

import pandas as pd

from reports.inputs.reading import require_file
from reports.measuring.pressure_wire import wire_pair
from reports.study.tables import WRITTEN_BY
from reports.whatif.tables import SOURCES, read_intervals, read_sensitivity

DIFFERENCE_COLUMNS = {"area_mm2": "area_{}_mm2", "curvature_per_mm": "curvature_{}_per_mm", "ffr": "ffr_{}"}
# column of <case>_flow.csv: key of ffr.json
FLOW_COLUMNS = {
    "status": "status",
    "model": "model",
    "cells": "cells",
    "unknowns": "dofs",
    "iterations": "iterations",
    "residual_absolute": "residual_absolute",
    "residual_relative": "residual_relative",
    "mass_imbalance": "mass_imbalance",
    "artificial_viscosity": "artificial_viscosity",
    "inlet_flow_m3_per_s": "inlet_flow_m3_per_s",
    "seconds": "seconds",
}


def write_study_data(folder, study_dir, software, failed, evidence):
    """Writes the study's tables into the ReportFolder `folder`. Raises InputError for a table that is missing.

    software: the JSON file of `reports software`, or None. failed: entries of failed.json. evidence: rows of the tests.
    """
    for name, command in WRITTEN_BY.items():
        folder.copy_data(study_dir / f"{name}.csv", command)
    folder.copy_data(study_dir / "differences_stations.csv", WRITTEN_BY["differences"])
    if software:
        folder.copy_data(software, "reports software", "software.json")
    folder.write_data("failed.csv", pd.DataFrame(failed))
    rows = [{**row, "reasons": "; ".join(row["reasons"])} for row in evidence]
    folder.write_data("evidence.csv", pd.DataFrame(rows))


def write_case_data(folder, files, context):
    """Writes the files of one case, named <case>_<table>.csv. files: its CaseFiles; context: made by case_context."""
    metrics, deployment = context["metrics"], context["deployment"] or {}
    tables = {
        "states": state_rows(metrics),
        "differences": difference_rows(metrics),
        "profiles": profile_table(metrics),
        "pullback": pullback_table(files, context["flow"]),
        "stages": pd.DataFrame(deployment.get("stages", [])),
        "flow": flow_rows(context["flow"]),
        "probes": probe_rows(context["probes"]),
        "plans": pd.DataFrame(context["plans"]),
        **sensitivity_tables(files.folder),
    }
    for name, table in tables.items():
        folder.write_data(f"{files.case}_{name}.csv", table)
    if context["plan_picture"]:
        folder.copy_data(files.folder / "vci" / "plan.json", "anatomy plan", f"{files.case}_plan.json")


def state_rows(metrics):
    """A row for each state: FFR, areas and curvature over the segment; FFR computed and measured at a wire's sensor."""
    rows = []
    for state, entry in metrics["states"].items():
        ffr, wire = entry["ffr"] or {}, wire_pair(metrics, state) or (None, None)
        rows.append(
            {
                "state": state,
                "ffr_distal": ffr.get("distal"),
                "ffr_error_estimate": ffr.get("error_estimate"),
                "ffr_past_segment": ffr.get("past_segment"),
                "ffr_computed_at_wire": wire[0],
                "ffr_measured": wire[1],
                "mean_area_mm2": entry["area"]["mean_mm2"],
                "minimum_area_mm2": entry["area"]["minimum_mm2"],
                "mean_curvature_per_mm": entry["curvature"]["mean_per_mm"],
            }
        )
    return pd.DataFrame(rows)


def difference_rows(metrics):
    """A row for each comparison: difference of FFR past the lesion; bias, sd and rmse over the stations."""
    return pd.DataFrame(
        {
            "comparison": comparison,
            "ffr_distal": row["ffr_distal"],
            **{
                column.format(kind): row[key][kind] if row[key] else None
                for key, column in DIFFERENCE_COLUMNS.items()
                for kind in ("bias", "sd", "rmse")
            },
        }
        for comparison, row in metrics["differences"].items()
    )


def profile_table(metrics):
    """A row for each state and station: relative position, arc length (mm), area (mm2), curvature (1/mm), FFR."""
    return pd.concat(
        pd.DataFrame(
            {
                "state": state,
                "relative_position": metrics["stations"]["relative_position"],
                "s_mm": entry["s_mm"],
                "area_mm2": entry["area"]["profile_mm2"],
                "curvature_per_mm": entry["curvature"]["profile_per_mm"],
                "ffr": (entry["ffr"] or {}).get("profile"),
            }
        )
        for state, entry in metrics["states"].items()
    )


def pullback_table(files, states):
    """The pullback.csv of all states, one below the other, with the state as the first column."""
    paths = {state: require_file(files.flow(state) / "pullback.csv", "flow solve") for state in states}
    tables = {state: pd.read_csv(path) for state, path in paths.items()}
    return pd.concat(tables, names=["state"]).reset_index("state") if tables else pd.DataFrame()


def flow_rows(flow):
    """A row for each state: FFR by the solver and by the reduced model, size of the problem, how it was solved."""
    return pd.DataFrame(
        {
            "state": state,
            "ffr": row["solution"]["ffr"],
            "ffr_error_estimate": row["error"],
            "ffr_reduced_model": row["reduced_ffr"],
            **{column: row["solution"].get(key) for column, key in FLOW_COLUMNS.items()},
        }
        for state, row in flow.items()
    )


def probe_rows(probes):
    """A row for each probe and state: place on its branch, and FFR."""
    return pd.DataFrame(
        {"probe": probe["name"], "branch": probe["branch"], "s_mm": probe["s_mm"], "state": state, "ffr": ffr}
        for probe in probes
        for state, ffr in probe["ffr"].items()
    )


def sensitivity_tables(case_folder):
    """{sensitivity, intervals}: DataFrames on the inputs that were varied, with the column `source`; {} if none was."""
    if not any((case_folder / "sensitivity" / f"{source}.csv").is_file() for source in SOURCES):
        return {}
    intervals = [table for table in read_intervals(case_folder).values() if len(table)]
    return {"sensitivity": read_sensitivity(case_folder), "intervals": pd.concat(intervals or [pd.DataFrame()])}

"""seconds.csv: duration of the virtual procedure by stage and by step, beside the published seconds."""

import re

import pandas as pd

from reports.study.agreement import published_results
from reports.study.bland_altman import sample_sd

STAGE_ROW = re.compile(r"vci/(?P<step>[^/]+)/(?P<stage>deployment-to-contact|contact-to-balance|balloon-extraction)")
COLUMNS = ["by", "name", "n", "mean_s", "sd_s", "published_mean_s", "published_sd_s"]


def read_timings(path):
    """timings.csv as a DataFrame."""
    return pd.read_csv(path)


def stage_seconds(timings):
    """DataFrame (case, step, stage, seconds) with a row for each stage of each step, from the engine's own clock.

    timings: DataFrame of timings.csv. A repeated step (postdilatation_2) gets the name of the first one.
    """
    rows = []
    for row in timings[timings["source"] == "program"].itertuples():
        found = STAGE_ROW.fullmatch(row.step)
        if found:
            step = re.sub(r"_\d+$", "", found["step"])
            rows.append({"case": row.case, "step": step, "stage": found["stage"], "seconds": row.seconds})
    return pd.DataFrame(rows, columns=["case", "step", "stage", "seconds"])


def seconds_by_group(stages):
    """{(by, name): seconds (n,), one value for each case that has this stage or step}, in order of appearance.

    by: "stage", "step" or "all". name: name of the stage or step. stages: result of stage_seconds.
    """
    groups = {}
    for by in ("stage", "step"):
        for name in stages[by].unique():
            groups[by, name] = stages[stages[by] == name].groupby("case", sort=False)["seconds"].sum().to_numpy()
    groups["all", "procedure"] = stages.groupby("case", sort=False)["seconds"].sum().to_numpy()
    return groups


def seconds_table(timings):
    """DataFrame of seconds.csv: mean and sample standard deviation over the cases; empty without a deployment."""
    stages, published = stage_seconds(timings), published_results()["seconds"]
    rows = []
    for (by, name), values in seconds_by_group(stages).items() if len(stages) else ():
        source = published[by].get(name, {})
        row = {"by": by, "name": name, "n": len(values), "mean_s": values.mean(), "sd_s": sample_sd(values)}
        rows.append(row | {"published_mean_s": source.get("mean"), "published_sd_s": source.get("sd")})
    return pd.DataFrame(rows, columns=COLUMNS)

"""Estimated and true errors of FFR along tubes: python3 tests/verification/flow/errors_along.py DIR CASE ...

DIR/CASE holds a straight tube of hard_cases.py that was solved by that script. Errors are against the axisymmetric
solution. Prints a row for each tube, with these figures (flow/measured.md quotes some):
- the largest error of the pull-back, its place, and the estimate there;
- the share of the points at which the estimate is no less than the error, give or take REFERENCE_ROUNDING;
- the least ratio of estimate to error over the points with an error above SMALL_ERROR;
- the largest error and the largest estimate behind the lesions;
- error and estimate at the outlet.
"""

import json
import pathlib
import sys

import numpy as np
import pandas as pd

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

import axisymmetric  # noqa: E402
import hard_cases  # noqa: E402

REFERENCE_ROUNDING, SMALL_ERROR = 2e-5, 2e-4  # of FFR; the first is the accuracy of the reference
# The reference is read no closer to an end than this, because a point on the end may lie in no cell.
END_MARGIN_MM = 0.05
HEALTHY_SHARE = 0.97  # the vessel counts as healthy where its radius is at least this share of the inlet's


def with_errors(tube, folder):
    """(table of pullback.csv with the true error in the column `error`, (error, estimate) at the outlet).

    tube: a hard_cases.Tube that is solved in `folder`.
    """
    answer, table = json.loads((folder / "ffr.json").read_text()), pd.read_csv(folder / "pullback.csv")
    length, (_, _, _, document) = max(tube.length, tube.reference_length), tube.case()
    reference = axisymmetric.Tube(tube.radius, length, tube.throat, document, hard_cases.REFERENCE_CELLS)
    s_mm = np.clip(table["s_mm"], END_MARGIN_MM, length - END_MARGIN_MM)
    along, at_outlet = reference.ffr_along(answer["inlet_flow_m3_per_s"], s_mm)
    (outlet,) = answer["outlets"]
    if tube.length < length:  # a vessel that was cut off: read the reference at the cut, not at its own outlet
        at_outlet = along[-1]
    return table.assign(error=table["ffr"] - along), (outlet["ffr"] - at_outlet, outlet["error_estimate"])


def row_figures(tube, table):
    """Figures of the printed row that come from the pull-back."""
    size, estimate = table["error"].abs(), table["ffr_error_estimate"]
    most = size.idxmax()
    counts = size > SMALL_ERROR
    healthy = np.array([tube.radius(s) >= HEALTHY_SHARE * tube.radius(0.0) for s in table["s_mm"]])
    behind = np.arange(len(table)) > np.flatnonzero(~healthy).max()
    return {
        "largest": size[most],
        "at_mm": table["s_mm"][most],
        "estimate_there": estimate[most],
        "share": float((estimate + REFERENCE_ROUNDING >= size).mean()),
        "least_ratio": float((estimate / size)[counts].min()) if counts.any() else np.nan,
        "behind": size[behind].max(),
        "estimate_behind": estimate[behind].max(),
    }


def main(folder, *names):
    """Prints the table."""
    for name in names:
        tube = hard_cases.STRAIGHT[name]
        table, outlet = with_errors(tube, pathlib.Path(folder) / name)
        row = row_figures(tube, table)
        most = f"{row['largest']:.4f} at {row['at_mm']:g} mm"
        print(
            f"| {name} | {most} | {row['estimate_there']:.4f} | {row['share']:.0%} |"
            f" {row['least_ratio']:.1f} | {row['behind']:.4f} | {row['estimate_behind']:.4f} | {outlet[0]:+.4f} |"
            f" {outlet[1]:.4f} |",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Whether an anatomy is that of the drawn patient: ends, branches, worst lesion, no warning of a stub."""

import csv
import json

import numpy as np
from drawn_patient import STENOSIS_PERCENT

LARGEST_DISTANCE_MM = 1.0
LEAST_LESION_PERCENT = 30.0  # per cent by diameter; milder lesions are ignored
STYLES_WITHOUT_CAPS = ("mask .35", "label .35", "rounded", "noise .05", "noise .02")  # styles that do not keep the caps
STUB_WARNINGS = (
    "stub left closed",
    "rounded end left closed",
    "branch left closed",
)  # warnings; no drawn patient has any


def compare(patient, style, folder):
    """(what is wrong, or an empty text; number of ends found; distance of the lesion in mm; its error in percentage
    points)."""
    found = json.loads((folder / "anatomy.json").read_text())
    expected = patient.ends()
    wrong, off_mm, off_percent = [], "", ""
    if len(found["ends"]) != len(expected):
        wrong.append(f"{len(found['ends'])} ends, not {len(expected)}")
    elif style != "stubs":
        centres = np.array([end["centre_mm"] for end in found["ends"]])
        for centre, outward, radius in expected:
            lost = radius * (style in STYLES_WITHOUT_CAPS)
            if np.linalg.norm(centres - centre, axis=1).min() > LARGEST_DISTANCE_MM + lost:
                wrong.append(f"no end near {np.round(centre, 1).tolist()}")
    if len(found["branches"]) != len(patient.branches):
        wrong.append(f"{len(found['branches'])} branches, not {len(patient.branches)}")
    lesion = patient.lesion()
    if lesion and lesion[2] > LEAST_LESION_PERCENT:
        if not found["lesions"]:
            wrong.append("no lesion")
        else:
            places, least, most = lesion

            def distance(one):
                return float(np.linalg.norm(places - _throat_point(one, folder), axis=1).min())

            best = min(found["lesions"], key=distance)
            off_mm, percent = round(distance(best), 2), best["diameter_stenosis_percent"]
            off_percent = round(percent - np.clip(percent, least, most), 1)
            if off_mm > LARGEST_DISTANCE_MM or abs(off_percent) > max(STENOSIS_PERCENT, stated_error_percent(best)):
                wrong.append(f"lesion {off_mm} mm and {off_percent} % off")
    return "; ".join(wrong), len(found["ends"]), off_mm, off_percent


def false_stubs(folder):
    """Number of warnings in anatomy.json of a stub or of an end left closed, of which a drawn patient has none."""
    repairs = json.loads((folder / "anatomy.json").read_text())["repairs"]
    return sum(one["count"] for one in repairs if one["what"] in STUB_WARNINGS)


def stated_error_percent(lesion):
    """Error in percentage points of a diameter stenosis that the anatomy's stated error of the lesion's smallest area
    allows."""
    wider = 1 / np.sqrt(1 - lesion["mla_error_percent"] / 100) - 1
    return wider * (100 - lesion["diameter_stenosis_percent"])


def _throat_point(lesion, folder):
    with (folder / "sections.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["branch"] == lesion["branch"]]
    best = min(rows, key=lambda row: abs(float(row["s_mm"]) - lesion["s_mla_mm"]))
    return np.array([float(best[key]) for key in ("x_mm", "y_mm", "z_mm")])

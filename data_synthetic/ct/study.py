"""Measures the error of the segmentation on known lumens: a table over cases, voxels, noise seeds and methods."""

import copy
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import time

from common import vtp
from common.documents import config
from common import volume as image
from common.errors import ComputationError, InputError, error_sentence
from common.files import replacing, write_json
from common.implicit import field, surface

from .. import generate, patient, tree
from . import evaluate, phantom, struts, vessel

ROOT = pathlib.Path(__file__).resolve().parents[2]

METHODS = ("psf_edge", "half_maximum", "threshold")
STENT_LENGTH_MM, CROWNS, LINKS = 18.0, 8, 2
COLUMNS = [
    "case",
    "state",
    "voxel_mm",
    "seed",
    "method",
    "status",
    "sections",
    "lost_sections",
    "mean_difference_mm2",
    "sd_mm2",
    "lower_limit_mm2",
    "upper_limit_mm2",
    "mean_radius_difference_mm",
    "sd_radius_mm",
    "resistance_ratio",
    "true_minimal_area_mm2",
    "found_minimal_area_mm2",
    "point_spread_fwhm_mm",
    "warnings",
]


class KnownLumen:
    """A lumen of known shape, with or without a stent.

    branches: branches of the tree. surface: (points, triangles) of the lumen. vessel: its Vessel. sections: sections to
    compare (evaluate). metal: (points in mm, volumes in mm3) of the struts, or None. compared_spans: {branch:
    (start, end) in mm}, to compare only these stretches, or None.
    """

    def __init__(self, case, where, strut_mm):
        """strut_mm: thickness of the struts of a stent; None without one."""
        description = copy.deepcopy(case["vessel"])
        lesions = description["lesions"]
        if strut_mm:
            # The stented vessel is one after a perfect treatment: a healthy lumen, with struts against the wall.
            description["lesions"] = []
        self.branches = tree.grow(description, where)
        lumen = field.LumenField(self.branches)
        points, triangles, _ = surface.build(lumen, generate.GRID_SPACING_MM)
        self.surface, poly = (points, triangles), vtp.surface(points, triangles)
        thickness, kind = generate.plaque_at(lumen, points)
        self.vessel = vessel.from_surface(poly, where)
        wall = self.vessel.lumen_wall_indices
        self.vessel.plaque_mm[: len(wall)], self.vessel.plaque_type[: len(wall)] = thickness[wall], kind[wall]
        self.sections = evaluate.comparison_sections(self.branches)
        self.metal, self.compared_spans = None, None
        if strut_mm:
            main = self.branches[0]
            centre = lesions[0]["centre_s_mm"]
            low = max(centre - 0.5 * STENT_LENGTH_MM, 2.0)
            high = min(centre + 0.5 * STENT_LENGTH_MM, main.axis.length_mm - 2.0)
            places, lengths = struts.struts_on_wall(poly, main.axis.points_mm, low, high, CROWNS, LINKS, strut_mm)
            self.metal = places, lengths * strut_mm**2
            self.compared_spans = {"main": (low + 1.0, high - 1.0)}

    def end_points(self):
        """End points as a user would click them: [(name, centre)]."""
        return [(name, centre) for name, centre, _, _ in field.open_ends(self.branches)]


def run(cases, voxels_mm, seeds, out, methods=METHODS, settings_path=None):
    """Writes the table `out` (CSV): one row per case, state (unstented, stented), voxel, noise seed and method.

    Raises InputError for a case that is not synthetic, voxels out of range, no seed or an unknown method.
    """
    settings = config.load_section(settings_path, "ct")
    bad = [v for v in voxels_mm if not 0.2 <= v <= 1]
    if bad:
        raise InputError("voxels out of range", "--voxels", bad[0], "0.2 to 1 mm")
    unknown = [method for method in methods if method not in METHODS]
    if unknown:
        raise InputError("no such method of segmentation", "--methods", unknown[0], f"of {', '.join(METHODS)}")
    if seeds < 1:
        raise InputError("no noise seed", "--seeds", seeds, "at least 1")
    loaded = [(path.stem, patient.load(path), str(path)) for path in cases]
    thickness, rows = settings["phantom"]["strut_thickness_mm"], []
    for name, case, where in loaded:
        for state in ("unstented", "stented") if case["vessel"]["lesions"] else ("unstented",):
            subject = KnownLumen(case, where, thickness if state == "stented" else None)
            for voxel in voxels_mm:
                scanner = dict(settings["phantom"], voxel_mm=[voxel] * 3)
                noise_free = phantom.render(subject.vessel, scanner, subject.metal)
                for seed in range(1, seeds + 1):
                    labels = (name, state, voxel, seed)
                    rows += _method_rows(subject, noise_free, dict(scanner, seed=seed), settings, methods, labels)
    with replacing(out) as partial:
        with open(partial, "w", newline="") as handle:
            writer = csv.DictWriter(handle, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    return rows


def _method_rows(subject, noise_free, scanner, settings, methods, labels):
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        image.write(phantom.add_noise(noise_free, scanner), folder / "ct.nii", "CT angiogram, synthetic")
        ends = [{"name": name, "centre_mm": centre.tolist()} for name, centre in subject.end_points()]
        write_json(folder / "ends.json", {"ends": ends})
        for method in methods:
            row = dict(zip(COLUMNS, (*labels, method)), status="ok")
            start = time.monotonic()
            segmentation = dict(settings["segmentation"], method=method)
            write_json(folder / "settings.json", dict(settings, segmentation=segmentation))
            row.update(_segmentation_row(folder, subject))
            rows.append(row)
            print(f"{' '.join(map(str, labels))} {method}: {time.monotonic() - start:.1f} s", file=sys.stderr)
    return rows


def _segmentation_row(folder, subject):
    """A part of a table's row: {column: value} for one segmentation by the command `anatomy ct`.

    It has the columns from `sections` on. If the image does not allow a segmentation, it has `status` alone. folder:
    folder with the volume, its end points and the settings. Raises ComputationError if the command fails for another
    reason.
    """
    command = [sys.executable, "-m", "anatomy", "ct", folder / "ct.nii", "--ends", folder / "ends.json"]
    command += ["--settings", folder / "settings.json", "--out", folder / "found"]
    command += ["--stented"] if subject.metal else []
    process = subprocess.run(list(map(str, command)), cwd=ROOT, capture_output=True, text=True)
    reason = error_sentence(process.stderr)
    if process.returncode == ComputationError.exit_code and reason:
        return {"status": reason}
    if process.returncode != 0:
        raise ComputationError(
            "the segmentation failed", " ".join(map(str, command)), process.stderr[-2000:], "see above"
        )
    document = json.loads((folder / "found" / "segmentation.json").read_text())
    found = vtp.points_and_triangles(vtp.read_triangles(folder / "found" / "lumen.vtp", ""))
    result = evaluate.compare_areas(subject.surface, found, subject.sections, subject.compared_spans)
    return {
        **{key: round(value, 4) for key, value in result.items()},
        "point_spread_fwhm_mm": round(document["point_spread_fwhm_mm"], 4),
        "warnings": " ".join(sorted({w["code"] for w in document["warnings"]})),
    }

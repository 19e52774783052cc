"""How well the segmentation finds known lumens: cases, voxels, noise seeds and methods, as a table."""

import copy
import csv
import sys
import time

import numpy as np

from common import vtp
from common.errors import ComputationError, InputError
from common.files import replacing

from .. import field, generate, patient, surface, tree
from . import evaluate, image, phantom, scan, segment, struts, vessel

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
    "resistance_ratio",
    "true_minimal_area_mm2",
    "found_minimal_area_mm2",
    "point_spread_fwhm_mm",
    "warnings",
]


class Subject:
    """A lumen of known shape: branches, surface (points, triangles), its Vessel, stent metal and where it is."""

    def __init__(self, case, where, stented):
        description = copy.deepcopy(case["vessel"])
        lesions = description["lesions"]
        if stented:
            # The vessel as a perfect treatment leaves it: healthy lumen, struts against the wall.
            description["lesions"] = []
        self.branches = tree.grow(description, where)
        lumen = field.LumenField(self.branches)
        points, triangles, _ = surface.build(lumen, generate.SPACING_MM)
        self.surface, poly = (points, triangles), vtp.surface(points, triangles)
        thickness, kind = generate.plaque_at(self.branches, points)
        self.vessel = vessel.from_surface(poly, where)
        wall = self.vessel.wall_points
        self.vessel.plaque_mm[: len(wall)], self.vessel.kind[: len(wall)] = thickness[wall], kind[wall]
        self.places = evaluate.sections(self.branches)
        self.metal, self.extents, self.strut_mm = None, None, 0.0
        if stented:
            main = self.branches[0]
            centre = lesions[0]["centre_s_mm"]
            low = max(centre - 0.5 * STENT_LENGTH_MM, 2.0)
            high = min(centre + 0.5 * STENT_LENGTH_MM, main.axis.length_mm - 2.0)
            self.metal = struts.laid_on(poly, main.axis.points_mm, low, high, CROWNS, LINKS, 0.08)
            self.extents = {"main": (low + 1.0, high - 1.0)}

    def ends(self):
        """End points as a user would click them: [(name, centre)]."""
        return [(name, centre) for name, centre, _, _ in field.ends(self.branches)]


def run(cases, voxels_mm, seeds, out, methods=METHODS, settings_path=None):
    """Writes the table `out` (CSV): one row per case, state (unstented, stented), voxel, noise seed and method.

    Raises InputError for a case that is not synthetic, voxels out of range or no seed.
    """
    settings = scan.load_settings(settings_path)
    bad = [v for v in voxels_mm if not 0.2 <= v <= 1]
    if bad:
        raise InputError("voxels out of range", "--voxels", bad[0], "0.2 to 1 mm")
    if seeds < 1:
        raise InputError("no noise seed", "--seeds", seeds, "at least 1")
    loaded = [(path.stem, patient.load(path), str(path)) for path in cases]
    rows = []
    for name, case, where in loaded:
        for state in ("unstented", "stented") if case["vessel"]["lesions"] else ("unstented",):
            subject = Subject(case, where, state == "stented")
            for voxel in voxels_mm:
                scanner = dict(settings["phantom"], voxel_mm=[voxel] * 3)
                area = scanner["strut_thickness_mm"] ** 2
                metal = (subject.metal[0], subject.metal[1] * area) if subject.metal else None
                clean = phantom.render(subject.vessel, scanner, metal)
                for seed in range(1, seeds + 1):
                    labels = (name, state, voxel, seed)
                    rows += _rows(subject, clean, dict(scanner, seed=seed), settings, methods, labels)
    with replacing(out) as partial:
        with open(partial, "w", newline="") as handle:
            writer = csv.DictWriter(handle, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    return rows


def _rows(subject, clean, scanner, settings, methods, labels):
    noisy = phantom.add_noise(clean, scanner)
    noisy.values = np.clip(np.rint(noisy.values), image.LOWEST_HU, image.HIGHEST_HU)  # as stored
    rows = []
    for method in methods:
        row = dict(zip(COLUMNS, (*labels, method)), status="ok")
        began = time.monotonic()
        try:
            found = segment.segment(noisy, subject.ends(), dict(settings["segmentation"], method=method))
            points, triangles, _ = surface.build(found["field"], settings["segmentation"]["surface_spacing_mm"])
            result = evaluate.compare(subject.surface, (points, triangles), subject.places, subject.extents)
            row.update({key: round(value, 4) for key, value in result.items()})
            row["point_spread_fwhm_mm"] = round(found["sigma_mm"] / phantom.SIGMA_PER_FWHM, 4)
            row["warnings"] = " ".join(sorted({w["code"] for w in found["warnings"]}))
        except ComputationError as error:
            row["status"] = error.what
        rows.append(row)
        print(f"{' '.join(map(str, labels))} {method}: {time.monotonic() - began:.1f} s", file=sys.stderr)
    return rows

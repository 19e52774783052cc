"""Straightening by the reference's beams against a solid in three dimensions, as CSV.

Run: /usr/bin/python3 tests/verification/data_synthetic/straightening_benchmark.py --out FOLDER [--cases CASE.yaml ...]
[--meshes 6x2x3 8x3x2]. Each case takes some minutes on one core. First the case is generated, its anatomy is measured
by build/lumen, and its plan is made.
"""

import numpy as np
from benchmark_case import compare_with_solids


def rows(case, document):
    """A row for each mesh of a case's document straightening_vs_3d.json, for the CSV."""
    before, beams = document["curvature_before_per_mm"], document["beams"]
    return [
        {
            "case": case,
            "mesh": solid["mesh"],
            "unknowns": solid["degrees_of_freedom"],
            "seconds_s": solid["seconds"],
            "stent_bending_n_mm2": document["stent_bending_n_mm2"],
            "curvature_before_per_mm": before,
            "curvature_beams_per_mm": beams["curvature_per_mm"],
            "curvature_solid_per_mm": solid["curvature_per_mm"],
            "curvature_stent_beams_per_mm": beams["stent_curvature_per_mm"],
            "curvature_stent_in_solid_per_mm": solid["stent_curvature_per_mm"],
            "lost_beams_percent": 100 * (1 - beams["curvature_per_mm"] / before),
            "lost_solid_percent": 100 * (1 - solid["curvature_per_mm"] / before),
            "mean_area_before_solid_mm2": solid["areas_before_mm2"]["mean"],
            "mean_area_beams_mm2": beams["areas_mm2"]["mean"],
            "mean_area_solid_mm2": solid["areas_mm2"]["mean"],
            "area_at_ends_beams_mm2": np.mean(beams["areas_mm2"]["ends"]),
            "area_at_ends_solid_mm2": np.mean(solid["areas_mm2"]["ends"]),
            "largest_shift_beams_mm": beams["largest_shift_mm"],
            "largest_shift_solid_mm": solid["largest_shift_mm"],
        }
        for solid in document["solids"]
    ]


if __name__ == "__main__":
    compare_with_solids(
        __doc__.splitlines()[0],
        ("quick_focal", "contrast_bend", "lcx02"),
        ["6x2x3", "8x3x2"],
        ("straightening-3d", "straightening_vs_3d.json"),
        rows,
    )

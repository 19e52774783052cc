"""The slices against a solid in three dimensions, as CSV.

Run: /usr/bin/python3 tests/verification/data_synthetic/solid_benchmark.py --out FOLDER [--cases CASE.yaml ...]
[--meshes 8x3x2 12x4x1.2]. Each case takes some minutes on one core. First the case is generated, its anatomy is
measured by build/lumen, and its plan is made.
"""

from benchmark_case import compare_with_solids


def rows(case, document):
    """A row for each mesh of a case's document slices_vs_3d.json, for the CSV."""
    found = []
    for solid in document["solids"]:
        against = solid["slices_against_it"]
        row = {
            "case": case,
            "mesh": solid["mesh"],
            "unknowns": solid["degrees_of_freedom"],
            "seconds_s": solid["seconds"],
        }
        for region in ("stent", "stent_edges", "beyond"):
            for name in ("mean", "rms", "largest"):
                row[f"{region}_area_{name}_percent"] = against.get(f"{region}_area_percent", {}).get(name)
        row["smallest_area_percent"] = against["minimal_lumen_area_in_stent_percent"]
        row["resistance_percent"] = against["resistance_percent"]
        found.append(row)
    return found


if __name__ == "__main__":
    compare_with_solids(
        __doc__.splitlines()[0],
        ("quick_focal", "long_plaque_bench"),
        ["8x3x2", "12x4x1.2"],
        ("reference-3d", "slices_vs_3d.json"),
        rows,
    )

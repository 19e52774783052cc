"""Seconds of each step of `lumen process` against the size of its input, as CSV.

Run: /usr/bin/python3 tests/verification/anatomy/benchmark.py --out FILE.csv [triangles ...] Steps are
wall clock, as anatomy.json has them: use an idle machine, or go by cpu_s.
"""

import argparse
import csv
import json
import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile
from math import cos, sin

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from places import build_folder  # noqa: E402

LUMEN = build_folder() / "lumen"
FOUR_BRANCHES = [
    ((0, 0, 0), (40, 0, 0), 1.7, 1.4),
    ((10, 0, 0), (10 + 9 * cos(1.0), 0, 9 * sin(1.0)), 0.9, 0.8),
    ((18, 0, 0), (18 + 10 * cos(0.9), 10 * sin(0.9), 0), 1.0, 0.9),
    ((29, 0, 0), (29 + 8 * cos(1.0), 0, -8 * sin(1.0)), 0.8, 0.7),
]
# of the tree at a grid spacing of 0.2 mm; their number grows with the inverse square of the spacing
TRIANGLES_AT_02 = 38000
COARSEST = 130000  # triangles taken from a grid; more are made by splitting each into four


def write_tree(triangles, path):
    """Writes the tree with about this many triangles.

    Run in a process of its own, and imports there: what this one has held counts as its children's peak memory.
    """
    import numpy as np
    import surfaces

    splits = 0
    while triangles / 4**splits > COARSEST:
        splits += 1
    points, cells = surfaces.tree(FOUR_BRANCHES, spacing=0.2 * (TRIANGLES_AT_02 * 4**splits / triangles) ** 0.5)
    for _ in range(splits):
        edges = np.sort(np.vstack([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
        unique, inverse = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (len(points) + inverse.reshape(3, -1)[k] for k in range(3))
        points = np.vstack([points, points[unique].mean(axis=1)])
        a, b, c = cells.T
        cells = np.vstack([np.column_stack(t) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    surfaces.write(path, points, cells)


def measured(triangles, folder):
    """{column: value} of one run."""
    surface = folder / "tree.stl"
    writer = multiprocessing.get_context("spawn").Process(target=write_tree, args=(triangles, surface))
    writer.start()
    writer.join()
    given = (surface.stat().st_size - 84) // 50  # of a binary STL
    process = subprocess.Popen([LUMEN, "process", surface, "--out", folder / "out"], stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"lumen process failed at {given} triangles: run it on the tree of this size")
    steps = json.loads((folder / "out" / "anatomy.json").read_text())["timings_s"]
    row = {
        "triangles": given,
        "cpu_s": round(usage.ru_utime + usage.ru_stime, 2),
        "peak_mib": round(usage.ru_maxrss / 1024),
    }
    return row | {step: round(seconds, 2) for step, seconds in steps.items()}


def main():
    """Writes one row per size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("triangles", nargs="*", type=int, default=[20000, 200000, 2000000], help="sizes of the input")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="the table, CSV")
    options = parser.parse_args()
    rows = []
    for size in options.triangles:
        with tempfile.TemporaryDirectory() as folder:
            rows.append(measured(size, pathlib.Path(folder)))
        print(rows[-1], file=sys.stderr)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with options.out.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()

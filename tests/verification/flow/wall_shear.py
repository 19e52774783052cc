"""Wall shear stress by boundary layers: python3 tests/verification/flow/wall_shear.py --out DIR RINGS:LAYERS ...

The tube with a lesion of 62 % is solved on single meshes of RINGS rings, whose outermost ring is split into LAYERS. The
wall shear stress is compared with axisymmetric.py at the same inflow. Writes DIR/wall_shear.csv with these columns:
- rings, wall_layers, dofs, error of FFR;
- in the lesion, in percent of the peak of the stress: root mean square error and largest error at the wall's nodes, and
  the error of the peak itself;
- from 1 mm behind the lesion on: the root mean square error in Pa;
- CPU seconds.
"""

import argparse
import csv
import json
import pathlib
import sys

import meshio
import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).resolve().parents[3])]

import axisymmetric  # noqa: E402
import growth  # noqa: E402
import hard_cases  # noqa: E402

CASE, LESION_RANGE, BEHIND_LESION = "single_62", (15.0, 25.0), (26.0, 45.0)  # mm
# On hard_cases.REFERENCE_CELLS the reference's wall shear stress differs from that on 200 by 20 cells by at most .3 %
# of the peak.
COLUMNS = ("rings", "wall_layers", "dofs", "ffr_error", "lesion_rms_percent", "lesion_largest_percent")
COLUMNS += ("peak_error_percent", "behind_rms_pa", "cpu_s")


def wall_stress(folder, out):
    """(s (n,) in mm, stress (n,) in Pa, positive downstream) at the wall's nodes of a solved tube along x."""
    solution = meshio.read(folder / out / "solution.vtu")
    stress = solution.point_data["wall_shear_stress_pa"]
    size = np.linalg.norm(stress, axis=1)
    wall = size > 0
    return solution.points[wall, 0], size[wall] * np.sign(stress[wall, 0])


def error_columns(s_mm, stress, flow):
    """Columns of the table that compare the stress at the wall's nodes with the reference at the inflow `flow`."""
    case = hard_cases.STRAIGHT[CASE]
    tube = axisymmetric.Tube(case.radius, case.length, case.throat, case.case()[3], hard_cases.REFERENCE_CELLS)
    places = np.arange(LESION_RANGE[0], BEHIND_LESION[1] + 0.05, 0.1)
    along = tube.wall_shear(places, flow)
    error, peak = stress - np.interp(s_mm, places, along), along.max()
    lesion, behind = ((s_mm > low) & (s_mm < high) for low, high in (LESION_RANGE, BEHIND_LESION))
    rms = [float(np.sqrt(np.mean(error[chosen] ** 2))) for chosen in (lesion, behind)]
    level = np.round(s_mm, 2)  # the nodes of one ring have the same level
    highest = max(stress[level == one].mean() for one in np.unique(level[lesion]))
    return {
        "lesion_rms_percent": f"{100 * rms[0] / peak:.1f}",
        "lesion_largest_percent": f"{100 * np.abs(error[lesion]).max() / peak:.1f}",
        "peak_error_percent": f"{100 * (highest / peak - 1):+.1f}",
        "behind_rms_pa": f"{rms[1]:.2f}",
    }


def row(folder, rings, layers):
    """Row of the table; the lumen is in `folder`."""
    name = f"r{rings}_w{layers}"
    spaced = [f"--stations-{where}={value * growth.DEFAULT.rings / rings}" for where, value in growth.SPACING.items()]
    line = ["--centreline", "centreline.vtp"]
    growth.command(
        folder, "mesh", "lumen.vtp", *line, "--out", f"{name}.msh", "--rings", rings, "--wall-layers", layers, *spaced
    )
    growth.command(folder, "solve", f"{name}.msh", *line, "--boundary", "boundary.json", "--out", name)
    answer = json.loads((folder / name / "ffr.json").read_text())
    reference = hard_cases.STRAIGHT[CASE].reference(answer["inlet_flow_m3_per_s"])
    return {
        "rings": rings,
        "wall_layers": layers,
        "dofs": answer["dofs"],
        "ffr_error": f"{answer['ffr'] - reference:+.4f}",
        **error_columns(*wall_stress(folder, name), answer["inlet_flow_m3_per_s"]),
        "cpu_s": f"{answer['cpu_seconds']:.0f}",
    }


def main():
    """Runs the meshes asked for and writes the table after each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="RINGS:LAYERS")
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    folder, rows = arguments.out / CASE, []
    hard_cases.write(CASE, folder)
    for given in arguments.meshes:
        rows.append(row(folder, *map(int, given.split(":"))))
        print(rows[-1], flush=True)
        with open(arguments.out / "wall_shear.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()

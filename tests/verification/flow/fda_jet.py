"""The jet of the FDA's nozzle at Re 500: python3 tests/verification/flow/fda_jet.py --out DIR.

Writes DIR/jet.csv with four rows: the mean and the standard deviation of five laboratories, the axisymmetric solution
of fda_axisymmetric.py, and the answer of `flow mesh` and `flow solve` with default settings. The columns are the
velocity on the axis in m/s (in the original's size), the place where the flow along the wall reattaches, FFR at a
probe, and its error estimate.
"""

import argparse
import csv
import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

import fda_nozzle  # noqa: E402  (makes the packages of the repository known)
import given_inflow  # noqa: E402
import growth  # noqa: E402
import hard_cases  # noqa: E402
import numpy as np  # noqa: E402
import vtk  # noqa: E402
from fda_axisymmetric import Nozzle  # noqa: E402
from vtk.util import numpy_support  # noqa: E402

OUTLET_PA, PROBE_ORIGINAL_MM = 90 * 133.322, 100.0  # behind the expansion, where the jet has spread
PLACES_MM = fda_nozzle.Z_ORIGINAL_MM
WALL_PLACES_MM = np.linspace(2, 118, 117)  # mm of the original: where the flow along the wall is read
NEAR_WALL_SHARE = 0.98  # share of the radius at which the flow along the wall is read
COLUMNS = ("row", *(f"z_{z:g}" for z in PLACES_MM), "within", "reattached", "ffr", "estimate")


FLUID = {"density_kg_per_m3": fda_nozzle.DENSITY, "viscosity_pa_s": fda_nozzle.VISCOSITY}


def document(nozzle, inlet_pa):
    """boundary.json for given_inflow: the nozzle's flow, OUTLET_PA at the outlet, inlet_pa at the inlet."""
    s_mm = float(nozzle.along_mm(PROBE_ORIGINAL_MM))
    outlet = {"name": "outlet1", "region_id": 2, "branch": "main", "flow_m3_per_s": fda_nozzle.FLOW}
    outlet["resistance_pa_s_per_m3"] = OUTLET_PA / fda_nozzle.FLOW
    return FLUID | {
        "map_pa": inlet_pa,
        "venous_pressure_pa": 0.0,
        "outlets": [outlet],
        "probes": [{"name": "distal", "branch": "main", "s_mm": s_mm, "point_mm": nozzle.branch.point(s_mm).tolist()}],
    }


def laboratory_rows():
    """The rows of the measured mean and standard deviation."""
    measured = {"laboratories": fda_nozzle.VELOCITY_ORIGINAL, "their SD": fda_nozzle.SPREAD_ORIGINAL}
    return [{"row": name, **velocities(values)} for name, values in measured.items()]


def velocities(values):
    """{column: text} of velocities of the original at PLACES_MM."""
    return {f"z_{z:g}": f"{value:.3f}" for z, value in zip(PLACES_MM, values)}


def count_within(values):
    """How many of the velocities are within two standard deviations of the laboratories' mean, in words."""
    near = np.abs(values - fda_nozzle.VELOCITY_ORIGINAL) <= 2 * fda_nozzle.SPREAD_ORIGINAL
    return f"{near.sum()} of {len(near)}"


def reattachment(z_mm, speed):
    """Where the flow reattaches: behind this place `speed` (n,) along the wall stays downstream.

    Returns text: the place in mm of the original, "nowhere upstream", or "behind" the last place if the speed there is
    still upstream.
    """
    back = np.flatnonzero(speed < 0)
    if len(back) == 0:
        return "nowhere upstream"
    k = back[-1]
    if k == len(z_mm) - 1:
        return f"behind {z_mm[-1]:.0f}"
    return f"{z_mm[k] + (z_mm[k + 1] - z_mm[k]) * speed[k] / (speed[k] - speed[k + 1]):.1f}"


def axisymmetric_row(nozzle):
    """(row of the axisymmetric solution, its pressure in Pa at the inlet's centre)."""
    exact, probe = Nozzle(FLUID), float(nozzle.along_mm(PROBE_ORIGINAL_MM))
    exact.solve(fda_nozzle.FLOW)
    on_axis = fda_nozzle.original_velocity(exact.at(nozzle.along_mm(PLACES_MM), 1e-4)[0])
    along = exact.at(nozzle.along_mm(WALL_PLACES_MM), NEAR_WALL_SHARE * fda_nozzle.RADIUS)[0]
    inlet, distal = OUTLET_PA + exact.at((0.01, probe), 1e-4)[1]
    found = {"row": "axisymmetric", **velocities(on_axis), "within": count_within(on_axis)}
    return found | {"reattached": reattachment(WALL_PLACES_MM, along), "ffr": f"{distal / inlet:.5f}"}, inlet


def vci_row(nozzle, boundary, folder):
    """Row of the answer of `flow solve`, meshed and solved in `folder`."""
    fda_nozzle.write(nozzle, folder)
    (folder / "boundary.json").write_text(json.dumps(boundary))
    line, meshes = ["--centreline", "centreline.vtp"], ["mesh.msh", "--coarse", *hard_cases.COARSE_MESHES]
    growth.command(folder, "mesh", "lumen.vtp", *line, "--out", *meshes)
    solve = ["solve", *meshes, *line, "--boundary", "boundary.json", "--out", "."]
    growth.command(folder, *solve, program=[given_inflow.__file__])
    answer, report = (json.loads((folder / name).read_text()) for name in ("ffr.json", "mesh.json"))
    rings = dict(
        zip((*hard_cases.COARSE_MESHES, "mesh.msh"), (*(part["rings"] for part in report["coarse"]), report["rings"]))
    )
    on_axis = fda_nozzle.original_velocity(along_x(folder / "solution.vtu", nozzle.along_mm(PLACES_MM), 1e-3))
    wall = along_x(folder / "solution.vtu", nozzle.along_mm(WALL_PLACES_MM), NEAR_WALL_SHARE * fda_nozzle.RADIUS)
    name = f"{rings[answer['mesh']]} rings, eps {answer['artificial_viscosity']:.2g}"
    found = {
        "row": name,
        **velocities(on_axis),
        "within": count_within(on_axis),
        "reattached": reattachment(WALL_PLACES_MM, wall),
    }
    estimate = answer["error_estimate"]
    return found | {"ffr": f"{answer['ffr']:.5f}", "estimate": f"{estimate['ffr']:.4f}" if estimate else "unknown"}


def along_x(path, x_mm, radius_mm):
    """Velocity (n,) in m/s along x at x_mm (n,), radius_mm from the axis, of a solution.vtu in mm."""
    reader, probe, points = vtk.vtkXMLUnstructuredGridReader(), vtk.vtkProbeFilter(), vtk.vtkPoints()
    reader.SetFileName(str(path))
    for x in x_mm:
        points.InsertNextPoint(x, radius_mm, 0.0)
    at = vtk.vtkPolyData()
    at.SetPoints(points)
    probe.SetInputData(at)
    probe.SetSourceConnection(reader.GetOutputPort())
    probe.Update()
    found = probe.GetOutput().GetPointData()
    if not numpy_support.vtk_to_numpy(found.GetArray(probe.GetValidPointMaskArrayName())).all():
        raise SystemExit(f"{path}: a point {radius_mm} mm from the axis lies outside")
    return numpy_support.vtk_to_numpy(found.GetArray("velocity_m_per_s"))[:, 0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    nozzle = fda_nozzle.make()
    exact, inlet_pa = axisymmetric_row(nozzle)
    rows = [*laboratory_rows(), exact, vci_row(nozzle, document(nozzle, inlet_pa), arguments.out)]
    with (arguments.out / "jet.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()

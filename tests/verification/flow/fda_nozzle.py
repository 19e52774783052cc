"""The FDA's benchmark nozzle: a cone to a throat and a sudden expansion, with the velocities of five laboratories.

    python3 tests/verification/flow/fda_nozzle.py --out DIR

writes DIR/lumen.vtp, centreline.vtp, sections.csv, anatomy.json, as the anatomy step does, and lumen.stl. All lengths
are a third of the original's (throat 4/3 mm, tube 4 mm), so the tube is as wide as a coronary artery. The Reynolds
number and the viscosity are the original's. The velocities are therefore three times as large.

Geometry of the original: inlet 12 mm wide, cone 22.685 mm long to the throat, 4 mm wide and 40 mm long, sudden
expansion to 12 mm at z = 0.
Source: Hariharan et al. 2011, J Biomech Eng 133, 041002 (FDA critical path nozzle, Re 500).
"""

import argparse
import dataclasses
import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "unit" / "flow")]

import tubes  # noqa: E402

from flow.geometry import centreline  # noqa: E402

SCALE = 1 / 3
RADIUS, THROAT = 6 * SCALE, 2 * SCALE  # mm
CONE_MM, THROAT_MM = 22.685 * SCALE, 40 * SCALE
INLET_MM, OUTLET_MM = 10.0, 40.0  # of straight tube before the cone, behind the expansion
AROUND = 48  # points of each circle
DENSITY, VISCOSITY = 1056.0, 0.0035  # kg/m3, Pa s
REYNOLDS = 500.0  # of the throat's diameter and mean velocity
# mean velocity in the throat, m/s, and flow, m3/s
MEAN_VELOCITY = REYNOLDS * VISCOSITY / (DENSITY * 2e-3 * THROAT)
FLOW = MEAN_VELOCITY * np.pi * (1e-3 * THROAT) ** 2
# Velocity on the axis at z mm behind the expansion: mean and standard deviation of five laboratories in m/s. z and the
# velocities are in the original's size.
Z_ORIGINAL_MM = np.array([-20.0, -8.0, 0.0, 8.0, 16.0, 24.0, 32.0, 60.0, 80.0])
VELOCITY_ORIGINAL = np.array([0.680, 0.733, 0.728, 0.726, 0.703, 0.667, 0.638, 0.537, 0.459])
SPREAD_ORIGINAL = np.array([0.023, 0.030, 0.022, 0.019, 0.022, 0.011, 0.011, 0.057, 0.041])


@dataclasses.dataclass
class Nozzle:
    """The nozzle's lumen.

    surface: geometry.surface.Surface. branch: geometry.centreline.Branch along +x, with the radius of the largest
    sphere inside. area_mm2 (n,): areas of the sections at branch.s_mm. expansion_mm: arc length to the expansion.
    """

    surface: object
    branch: object
    area_mm2: np.ndarray
    expansion_mm: float

    def along_mm(self, z_original_mm):
        """Arc length in mm in the scaled nozzle, of places z (n,) in mm behind the expansion of the original."""
        return self.expansion_mm + SCALE * np.asarray(z_original_mm)


def original_velocity(velocity):
    """Velocity in the original, from the velocity in the scaled nozzle (both in m/s)."""
    return SCALE * np.asarray(velocity)


def make(around=AROUND, inlet_mm=INLET_MM, outlet_mm=OUTLET_MM, spacing_mm=0.25):
    """The Nozzle; spacing_mm: distance of the centreline's points."""
    corners_s = np.cumsum([0.0, inlet_mm, CONE_MM, THROAT_MM, 0.0, outlet_mm])
    corners_r = np.array([RADIUS, RADIUS, THROAT, THROAT, RADIUS, RADIUS])
    expansion, length = corners_s[3], corners_s[-1]
    s, radius = _meridian(corners_s, corners_r, around)
    along = np.linspace(0.0, length, round(length / spacing_mm) + 1)
    wall = np.where(along < expansion, np.interp(along, corners_s[:4], corners_r[:4]), RADIUS)
    # Distance to the nearest point of the wall. Close behind the expansion that point is the throat's rim, and in the
    # cone it lies further downstream. The radius of the section would therefore be too large.
    gap = np.hypot(along[:, None] - s, radius).min(axis=1)
    branch = tubes.centre_branch(length, lambda _: RADIUS, spacing_mm=spacing_mm)
    branch = centreline.Branch(branch.name, branch.branch_id, branch.points, along, np.minimum(gap, wall))
    return Nozzle(tubes.revolved(s, radius, around), branch, np.pi * wall**2, float(expansion))


def _meridian(corners_s, corners_r, around):
    """(s, radius) of the rings of points. Neighbouring rings are about as far apart as the points on a ring."""
    s, radius = [corners_s[:1]], [corners_r[:1]]
    for k in range(len(corners_s) - 1):
        (s0, s1), (r0, r1) = corners_s[k : k + 2], corners_r[k : k + 2]
        edges = 2 * np.pi / around
        # The edges of a ring are proportional to its radius. In the cone the rings are therefore even in log r.
        share = (r1 - r0) / np.hypot(s1 - s0, r1 - r0)
        count = np.log(r1 / r0) / (edges * share) if share else (s1 - s0) / (edges * r0)
        t = np.linspace(0.0, 1.0, max(1, int(np.ceil(count))) + 1)[1:]
        r = r0 * (r1 / r0) ** t
        s.append(s0 + (s1 - s0) * ((r - r0) / (r1 - r0) if share else t))
        radius.append(r)
    return np.concatenate(s), np.concatenate(radius)


def write(nozzle, folder):
    """Writes the files of the anatomy step, and lumen.stl."""
    import vtk

    folder = pathlib.Path(folder)
    tubes.write_case(folder, nozzle.surface, [nozzle.branch], areas={nozzle.branch.name: nozzle.area_mm2})
    reader, writer = vtk.vtkXMLPolyDataReader(), vtk.vtkSTLWriter()
    reader.SetFileName(str(folder / "lumen.vtp"))
    writer.SetInputConnection(reader.GetOutputPort())
    writer.SetFileName(str(folder / "lumen.stl"))
    writer.SetFileTypeToBinary()
    writer.Write()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder for the files")
    write(make(), parser.parse_args().out)

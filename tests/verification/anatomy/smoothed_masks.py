"""How far the area of a throat is off in the smoothed contour of a mask, by its radius in voxels.

Run: /usr/bin/python3 tests/verification/anatomy/smoothed_masks.py [--draws 12]: a table of the mean, the standard
deviation and the extremes in per cent, over directions and places of the grid. Cut in the contour itself, without
`lumen`.
"""

import argparse

import lofts
import numpy as np
import surfaces

VOXEL_MM, HEALTHY_MM, LENGTH_MM = 0.35, 1.5, 24.0
PLACES_MM = (11.7, 12.0, 12.3)  # about the throat


def area(data, centre, frame):
    """Area (mm2) of a vtkPolyData's section across the first column of `frame` (3, 3)."""
    plane, cutter, join = surfaces.vtk.vtkPlane(), surfaces.vtk.vtkCutter(), surfaces.vtk.vtkStripper()
    plane.SetOrigin(*centre)
    plane.SetNormal(*frame[:, 0])
    cutter.SetInputData(data)
    cutter.SetCutFunction(plane)
    join.SetInputConnection(cutter.GetOutputPort())
    join.JoinContiguousSegmentsOn()
    join.Update()
    total = 0.0
    for k in range(join.GetOutput().GetNumberOfCells()):
        outline = surfaces.vtk_to_numpy(join.GetOutput().GetCell(k).GetPoints().GetData()) - centre
        y, z = outline @ frame[:, 1], outline @ frame[:, 2]
        total += abs(y @ np.roll(z, -1) - z @ np.roll(y, -1)) / 2
    return total


def error(voxels, seed):
    """Per cent by which a throat of that radius in voxels is too wide in a contour drawn by `seed`."""
    random = np.random.default_rng(seed)
    frame = np.linalg.qr(random.standard_normal((3, 3)))[0]
    origin = random.uniform(0, VOXEL_MM, 3)
    radius = lofts.narrowed(HEALTHY_MM, 100 * (1 - voxels * VOXEL_MM / HEALTHY_MM), LENGTH_MM / 2, 8)
    points, triangles = surfaces.tube(surfaces.straight, radius, LENGTH_MM, edge=0.25)
    contour = surfaces.polydata(*lofts.contoured(points @ frame.T + origin, triangles, VOXEL_MM))
    ratios = [area(contour, s * frame[:, 0] + origin, frame) / (np.pi * radius(np.array(s)) ** 2) for s in PLACES_MM]
    return 100 * (np.mean(ratios) - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=12)
    draws = parser.parse_args().draws
    print("voxels  mean  deviation  least  most")
    for voxels in (1.1, 1.25, 1.5, 1.75, 2.0, 2.5):
        off = np.array([error(voxels, seed) for seed in range(draws)])
        print(f"{voxels:6.2f} {off.mean():5.1f} {off.std():10.1f} {off.min():6.1f} {off.max():5.1f}", flush=True)


if __name__ == "__main__":
    main()

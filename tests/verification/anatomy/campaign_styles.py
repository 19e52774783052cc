"""The ways in which the campaign reconstructs a drawn patient's surface."""

import lofts
import masks
import numpy as np
import surfaces

STUB_MM = 2.0
VOXEL_MM = 0.35


def _without_caps(patient):
    points, triangles = patient.points, patient.triangles
    middle = points[triangles].mean(axis=1)
    cap = np.zeros(len(triangles), bool)
    for centre, outward, radius in patient.ends():
        on = np.abs((middle - centre) @ outward) < 1e-3
        cap |= on & (np.linalg.norm(middle - centre, axis=1) < 1.2 * radius)
    return points, triangles[~cap]


STYLES = {
    "as it is": lambda p: (p.points, p.triangles),
    "open": _without_caps,
    "loft 8": lambda p: lofts.fused(p.pieces(8, 0.8)),
    "loft 12": lambda p: lofts.fused(p.pieces(12, 0.6)),
    "loft 16": lambda p: lofts.fused(p.pieces(16, 0.5)),
    "loft 24": lambda p: lofts.fused(p.pieces(24, 1.0)),
    "loft 16 polygon caps": lambda p: lofts.fused(p.pieces(16, 0.7, "polygon")),
    "slanted": lambda p: lofts.fused(p.pieces(24, 0.5, slant=30)),
    "rounded": lambda p: lofts.fused(p.pieces(24, 0.5, "round")),
    "stubs": lambda p: lofts.fused(p.pieces(24, 0.5, stub=STUB_MM)),
    "mask .35": lambda p: lofts.contoured(p.points, p.triangles, VOXEL_MM),
    "label .35": lambda p: lofts.voxelised(p.points, p.triangles, VOXEL_MM),
    "decimated": lambda p: lofts.decimated(p.points, p.triangles, 0.1),
    "noise .02": lambda p: (lofts.noised(p.points, 0.02, 1), p.triangles),
    "noise .05": lambda p: (lofts.noised(p.points, 0.05, 1), p.triangles),
}


def write_style_file(made, folder):
    """The file of a style's surface, or of its labels (nx, ny, nz) with their low corner."""
    if made[0].ndim < 3:
        return surfaces.write(folder / "surface.stl", *made)
    labels, low = made
    affine = np.diag([VOXEL_MM, VOXEL_MM, VOXEL_MM, 1.0])
    affine[:3, 3] = low
    return masks.nifti(folder / "surface.nii.gz", labels, affine)

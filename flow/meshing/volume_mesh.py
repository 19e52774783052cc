"""Linear tetrahedra inside the lumen surface by gmsh, in a process of its own.

gmsh raises C++ exceptions that Python cannot catch, so flow/gmsh_fill.py is run as a program, which reads a surface and
a size field from one .npz file and writes nodes and tetrahedra to another. It reads no options of the user's.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from common.errors import ComputationError
from flow.meshing import gmsh_fill

PROGRAM = pathlib.Path(__file__).with_name("gmsh_fill.py")
COMMAND = [sys.executable, "-I", "-B", str(PROGRAM)]


def fill(surface, size_field, spacing_mm):
    """(points (n, 3), tetrahedra (t, 4)): the surface's vertices come first, in their order. Raises
    ComputationError."""
    with tempfile.TemporaryDirectory(prefix="flow-mesh-") as folder:
        folder = pathlib.Path(folder)
        origin, spacing, shape, values = size_field.grid(surface.points, spacing_mm)
        np.savez(
            folder / gmsh_fill.SURFACE,
            points=surface.points,
            triangles=surface.triangles,
            region=surface.region,
            origin=origin,
            spacing=spacing,
            shape=shape,
            values=values,
        )
        done = subprocess.run(COMMAND, cwd=folder, text=True, capture_output=True)
        if done.returncode != 0 or not (folder / gmsh_fill.VOLUME).is_file():
            tail = (done.stdout + done.stderr).strip().splitlines()[-3:]
            raise ComputationError(
                "gmsh could not fill the lumen", "volume mesh", "; ".join(tail), "check the surface for self-contact"
            )
        with np.load(folder / gmsh_fill.VOLUME) as volume:
            points, tetrahedra = volume["points"], volume["tetrahedra"]
    if len(tetrahedra) == 0:
        raise ComputationError("gmsh made no tetrahedra", "volume mesh", 0, "check the surface for self-contact")
    if not np.allclose(points[: len(surface.points)], surface.points, rtol=0, atol=1e-12):
        raise ComputationError("gmsh moved the surface", "volume mesh", "vertices differ", "report this surface")
    return points, tetrahedra

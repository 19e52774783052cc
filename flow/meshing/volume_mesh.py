"""Linear tetrahedra inside the lumen surface by gmsh (HXT), in a process of its own.

gmsh raises C++ exceptions that Python cannot catch, so flow/gmsh_fill.py is run as a program, which reads a surface and
a size field from one .npz file and writes nodes and tetrahedra to another. gmsh's optimiser goes through sets ordered
by address, so that its tetrahedra depend on where the memory of its process lies, down to the lengths of paths and
variables, to whether Python compiled a module and to the seed of its string hashes, by which it lays out dictionaries.
For the same surface to give the same mesh the program is read from standard input, with an environment of its own.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from common.errors import ComputationError
from flow.meshing import gmsh_fill

PROGRAM = pathlib.Path(__file__).with_name("gmsh_fill.py")
COMMAND = [sys.executable, "-s", "-P", "-B", "-"]  # -I without -E, which would not see the seed
ENVIRONMENT = {"PATH": "/usr/bin:/bin", "LC_ALL": "C", "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}


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
        source = PROGRAM.read_text()
        done = subprocess.run(COMMAND, input=source, cwd=folder, env=ENVIRONMENT, text=True, capture_output=True)
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

"""Linear tetrahedra inside the lumen surface by gmsh, in a process of its own.

gmsh raises C++ exceptions that Python cannot catch. So gmsh runs in a program of its own, flow/meshing/gmsh_fill.py.
For each surface this program reads points, facets and a size field from one .npz file, and writes nodes and tetrahedra
to another. It stays until this process ends, since loading gmsh takes longer than filling a junction. The user's gmsh
options are not read.
"""

import atexit
import functools
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from common.errors import ComputationError
from flow.geometry import curving, tet10
from flow.meshing import gmsh_fill, slivers

PROGRAM = pathlib.Path(__file__).with_name("gmsh_fill.py")
# Gamma is 1 for a regular and 0 for a flat tetrahedron (geometry.curving). slivers.split_slivers tries to replace
# cells below WANTED_GAMMA. A cell left below LEAST_GAMMA would spoil the whole solve, so it is refused.
LEAST_GAMMA, WANTED_GAMMA = 0.02, 0.1
LEAST_SPACING_MM = 0.25  # least spacing of the grid that hands the cells' sizes to gmsh
COMMAND = [sys.executable, "-I", "-B", str(PROGRAM)]


@functools.cache
def _program():
    """The running gmsh_fill.py (subprocess.Popen)."""
    program = subprocess.Popen(COMMAND, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    atexit.register(program.communicate)  # closes its input, at which it ends
    return program


def _run_gmsh(folder):
    """Fills the surface in `folder`. Raises ComputationError with gmsh's last words."""
    if _program().poll() is not None:
        _program.cache_clear()  # the program was killed since the last surface
    program = _program()
    print(json.dumps(str(folder)), file=program.stdin, flush=True)
    code = program.stdout.readline().strip()
    if code == "0" and (folder / gmsh_fill.VOLUME).is_file():
        return
    log = folder / gmsh_fill.LOG
    words = log.read_text(errors="replace").strip().splitlines()[-3:] if log.is_file() else []
    value = "; ".join(words) or f"exit code {code or 'unknown'}"
    raise ComputationError("gmsh could not fill the lumen", "volume mesh", value, "check the surface for self-contact")


def fill(surface, size_field):
    """(points (n, 3) in mm, tetrahedra (t, 4) of positive volume) inside a closed Surface.

    The surface's vertices are the first points, in their order. size_field: size_field.SizeField. Raises
    ComputationError, also if a sliver is left (LEAST_GAMMA).
    """
    with tempfile.TemporaryDirectory(prefix="flow-mesh-") as folder:
        folder = pathlib.Path(folder)
        origin, spacing, shape, values = size_field.grid(
            surface.points, max(LEAST_SPACING_MM, float(size_field.size.min()))
        )
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
        _run_gmsh(folder)
        with np.load(folder / gmsh_fill.VOLUME) as volume:
            points, tetrahedra = volume["points"], volume["tetrahedra"]
    if len(tetrahedra) == 0:
        raise ComputationError("gmsh made no tetrahedra", "volume mesh", 0, "check the surface for self-contact")
    if not np.allclose(points[: len(surface.points)], surface.points, rtol=0, atol=1e-12):
        raise ComputationError("gmsh moved the surface", "volume mesh", "vertices differ", "report this surface")
    cells = tet10.orient_positive(points, tetrahedra)
    points, tetrahedra = slivers.split_slivers(points, cells, surface.edges()[0], WANTED_GAMMA)
    worst = int(np.argmin(curving.gamma(points[tetrahedra])))
    gamma = float(curving.gamma(points[tetrahedra[worst]][None])[0])
    if not gamma >= LEAST_GAMMA:
        where = f"volume mesh: tetrahedron at {np.round(points[tetrahedra[worst]].mean(axis=0), 2).tolist()} mm"
        raise ComputationError("gmsh left a sliver", where, f"gamma {gamma:.3g}", f"at least {LEAST_GAMMA} is needed")
    return points, tetrahedra

"""A narrowed straight tube for OpenFOAM's simpleFoam: SIMPLEC and GAMG on polyhedra, parabolic inflow, pressure behind.

Needs the programs of Debian's package `openfoam`. Lengths in mm where a name says so, else SI.
"""

import os
import pathlib
import re
import shutil
import subprocess

import numpy as np

from common.errors import ComputationError

PROGRAMS = ("gmshToFoam", "transformPoints", "polyDualMesh", "renumberMesh", "simpleFoam")
MOST_ITERATIONS = 1500
GRADIENTS = (
    "Gauss linear",
    "cellLimited Gauss linear 1",
)  # of the velocity: the second converges where the first cycles
HEADER = "FoamFile { version 2.0; format ascii; class %s; object %s; }\n"
SCHEMES = """ddtSchemes { default steadyState; }
gradSchemes { default Gauss linear; grad(U) %s; }
divSchemes
{
    default none;
    div(phi,U) bounded Gauss linearUpwind grad(U);
    div((nuEff*dev2(T(grad(U))))) Gauss linear;
}
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
"""
SOLUTION = """solvers
{
    p { solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0.05; }
    U { solver smoothSolver; smoother symGaussSeidel; tolerance 1e-10; relTol 0.05; }
}
SIMPLE { consistent yes; nNonOrthogonalCorrectors 0; residualControl { p 1e-5; U 1e-5; } }
relaxationFactors { equations { U 0.9; } }
"""
CONTROL = """application simpleFoam;
startFrom startTime; startTime 0; stopAt endTime; endTime %d; deltaT 1;
writeControl timeStep; writeInterval %d; writeFormat ascii; writePrecision 12; timePrecision 8;
runTimeModifiable false;
functions
{
    axis
    {
        type probes; libs (sampling); probeLocations (%s); fields (p); interpolationScheme cellPoint;
        writePrecision 10;
    }
}
"""


def missing_programs():
    """Names of the programs that are not installed."""
    return [name for name in PROGRAMS if shutil.which(name) is None]


def tetrahedra(radius, length_mm, throat_mm, edge_mm, path):
    """Meshes the tube by gmsh (format 2.2, mm): edge_mm in the healthy part, a third of it at the throat."""
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        model = gmsh.model.occ
        s = np.linspace(0, length_mm, 201)
        wall = [model.addPoint(x, float(radius(x)), 0) for x in s]
        ends = [model.addPoint(0, 0, 0), model.addPoint(length_mm, 0, 0)]
        lines = [model.addLine(ends[0], ends[1]), model.addLine(ends[1], wall[-1]), model.addSpline(wall[::-1])]
        half = model.addPlaneSurface([model.addCurveLoop([*lines, model.addLine(wall[0], ends[0])])])
        model.revolve([(2, half)], 0, 0, 0, 1, 0, 0, 2 * np.pi)
        model.synchronize()
        groups = {"inlet": [], "outlet": [], "wall": []}
        for _, surface in gmsh.model.getBoundary(gmsh.model.getEntities(3), oriented=False):
            low, high = np.split(np.array(gmsh.model.getBoundingBox(2, surface)), 2)
            flat = high[0] - low[0] < 1e-3
            groups["wall" if not flat else "inlet" if low[0] < 1 else "outlet"].append(surface)
        for name, surfaces in groups.items():
            gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, surfaces), name)
        volumes = [tag for _, tag in gmsh.model.getEntities(3)]
        gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, volumes), "fluid")

        def size(dim, tag, x, y, z):  # fine at the throat, coarser upstream and along the jet
            return edge_mm * (0.25 + 0.75 * np.clip(max((throat_mm - x) / 5, (x - throat_mm - 5) / 25), 0, 1))

        gmsh.model.mesh.setSizeCallback(size)
        for name in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
            gmsh.option.setNumber(f"Mesh.CharacteristicLength{name}", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def run(folder, radius, length_mm, throat_mm, places_mm, edge_mm, flow, density, viscosity):
    """Meshes and solves.

    Returns {cells, pressures_pa: over the outlet's, on the axis at places_mm, iterations, mesh_cpu_s, solve_cpu_s,
    gradient: the first of GRADIENTS with which it converges, whose seconds count}. Raises ComputationError where a
    program fails or simpleFoam does not converge.
    """
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("system", "constant", "0"):
        (folder / name).mkdir(parents=True)
    places = " ".join(f"({s * 1e-3:.9g} 0 0)" for s in places_mm)
    control = CONTROL % (MOST_ITERATIONS, MOST_ITERATIONS, places)
    for name, text in (("controlDict", control), ("fvSolution", SOLUTION), ("fvSchemes", SCHEMES % GRADIENTS[0])):
        _write(folder / "system" / name, "dictionary", text)
    started = _children_cpu()
    own = os.times()
    tetrahedra(radius, length_mm, throat_mm, edge_mm, folder / "tube.msh")
    meshing = sum(os.times()[:2]) - sum(own[:2])
    _call(folder, "gmshToFoam", "tube.msh")
    boundary = folder / "constant" / "polyMesh" / "boundary"
    boundary.write_text(re.sub(r"(wall\s*{\s*type\s*)patch", r"\1wall", boundary.read_text()))
    _call(folder, "transformPoints", "-scale", "(0.001 0.001 0.001)")
    _call(folder, "polyDualMesh", "60", "-overwrite", "-concaveMultiCells")
    _call(folder, "renumberMesh", "-overwrite")
    meshing += _children_cpu() - started
    _fields(folder, float(radius(0.0)) * 1e-3, flow, density, viscosity)
    for gradient in GRADIENTS:
        _write(folder / "system" / "fvSchemes", "dictionary", SCHEMES % gradient)
        shutil.rmtree(folder / "postProcessing", ignore_errors=True)
        started = _children_cpu()
        converged = re.search(r"SIMPLE solution converged in (\d+) iterations", _call(folder, "simpleFoam"))
        if converged:
            break
        shutil.rmtree(folder / str(MOST_ITERATIONS))
    else:
        raise ComputationError(
            "simpleFoam did not converge", str(folder), f"{MOST_ITERATIONS} iterations", "see its log"
        )
    last = (folder / "postProcessing" / "axis" / "0" / "p").read_text().splitlines()[-1]
    return {
        "cells": int(re.search(r"nCells:\s*(\d+)", (folder / "constant" / "polyMesh" / "owner").read_text()).group(1)),
        "pressures_pa": [density * float(p) for p in last.split()[1:]],
        "iterations": int(converged.group(1)),
        "mesh_cpu_s": meshing,
        "solve_cpu_s": _children_cpu() - started,
        "gradient": gradient,
    }


def _write(path, kind, text):
    path.write_text(HEADER % (kind, path.name) + text)


def _children_cpu():
    return sum(os.times()[2:4])


def _call(folder, *command):
    """Output of a program run in the case's folder, also kept as log.<program>."""
    environment = {**os.environ, "WM_PROJECT_DIR": "/usr/share/openfoam", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=folder, env=environment, text=True, capture_output=True)
    (folder / f"log.{command[0]}").write_text(done.stdout + done.stderr)
    if done.returncode != 0:
        raise ComputationError(f"{command[0]} failed", str(folder), f"exit code {done.returncode}", "see its log")
    return done.stdout


def _inlet_faces(folder):
    """Area vectors (m2) and centres (m) of the inlet's faces, from the mesh in ASCII."""
    mesh = folder / "constant" / "polyMesh"
    number = r"([-+.eE\d]+)"
    points = np.array(re.findall(rf"^\({number} {number} {number}\)$", (mesh / "points").read_text(), re.M), float)
    text = (mesh / "faces").read_text()
    faces = [np.array(face.split(), int) for face in re.findall(r"\d+\s*\(([\d\s]+)\)", text)]
    entry = re.search(r"inlet\s*{(.*?)}", (mesh / "boundary").read_text(), re.S).group(1)
    count, start = (int(re.search(rf"{key}\s+(\d+)", entry).group(1)) for key in ("nFaces", "startFace"))
    areas, centres = [], []
    for face in faces[start : start + count]:
        corners = points[face]
        middle = corners.mean(axis=0)
        parts = 0.5 * np.cross(corners - middle, np.roll(corners, -1, axis=0) - middle)
        size = np.linalg.norm(parts, axis=1)
        areas.append(parts.sum(axis=0))
        centres.append((((corners + np.roll(corners, -1, axis=0) + middle) / 3) * size[:, None]).sum(0) / size.sum())
    return np.array(areas), np.array(centres)


def _fields(folder, radius, flow, density, viscosity):
    """Boundary values: a parabola of exactly `flow` (m3/s) at the inlet, pressure 0 at the outlet, no slip."""
    areas, centres = _inlet_faces(folder)
    share = np.clip(1 - (np.hypot(centres[:, 1], centres[:, 2]) / radius) ** 2, 0, None)
    speed = share * flow / (share * np.abs(areas[:, 0])).sum()
    inlet = "\n".join(f"({u:.9g} 0 0)" for u in speed)
    _write(
        folder / "0" / "U",
        "volVectorField",
        f"""dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0);
boundaryField
{{
    inlet {{ type fixedValue; value nonuniform List<vector> {len(speed)}\n(\n{inlet}\n)\n; }}
    outlet {{ type zeroGradient; }}
    wall {{ type noSlip; }}
}}
""",
    )
    _write(
        folder / "0" / "p",
        "volScalarField",
        """dimensions [0 2 -2 0 0 0 0]; internalField uniform 0;
boundaryField
{ inlet { type zeroGradient; } outlet { type fixedValue; value uniform 0; } wall { type zeroGradient; } }
""",
    )
    _write(
        folder / "constant" / "transportProperties",
        "dictionary",
        f"transportModel Newtonian; nu [0 2 -1 0 0 0 0] {viscosity / density:.9g};\n",
    )
    _write(folder / "constant" / "turbulenceProperties", "dictionary", "simulationType laminar;\n")

"""A narrowed straight tube as a case of OpenFOAM's simpleFoam.

The solver uses SIMPLEC and GAMG on polyhedra. The inflow is a parabola, and the pressure is given at the outlet.
Needs the programs of Debian's package `openfoam`. Lengths in mm where a name says so, else SI.
"""

import os
import re
import shutil

import numpy as np
from openfoam_run import (
    POINT,
    run_program,
    children_cpu_seconds,
    faces,
    figures,
    inlet_faces,
    points_of,
    polyhedra,
    write,
)

# Schemes for the velocity's gradient, and the most iterations of each. The limited one can converge where the linear
# one only cycles.
GRADIENTS = {"Gauss linear": 600, "cellLimited Gauss linear 1": 1500}
AVERAGED_ITERATIONS = 200  # if a run does not converge, its result is the mean over this many last iterations
# The pressure drop has settled once it stays this near to its last value (relative). The time until then is reported.
SETTLED_SHARE = 1e-4
SCHEMES = """ddtSchemes { default steadyState; }
gradSchemes { default Gauss linear; grad(U) %(gradient)s; }
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
startFrom startTime; startTime 0; stopAt endTime; endTime %(iterations)d; deltaT 1;
writeControl timeStep; writeInterval %(iterations)d; writeFormat ascii; writePrecision 12; timePrecision 8;
runTimeModifiable false;
functions
{
    axis
    {
        type probes; libs (sampling); probeLocations (%(places)s); fields (p); interpolationScheme cellPoint;
        writePrecision 10;
    }
}
"""


def tetrahedra(radius, length_mm, throat_mm, edge_mm, path):
    """Meshes the tube by gmsh (format 2.2, mm): edge_mm in the healthy part, a quarter of edge_mm at the throat."""
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


def mesh(folder, radius, length_mm, throat_mm, places_mm, edge_mm, flow, density, viscosity):
    """Writes the case with its polyhedra and boundary values: {cells, volume_mm3, mesh_cpu_s}.

    Pressures are probed on the axis at places_mm. Raises ComputationError where a program fails.
    """
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("system", "constant", "0"):
        (folder / name).mkdir(parents=True)
    places = " ".join(f"({s * 1e-3:.9g} 0 0)" for s in places_mm)
    values = {"places": places, "iterations": 1, "gradient": "Gauss linear"}
    for name, text in (("controlDict", CONTROL), ("fvSolution", SOLUTION), ("fvSchemes", SCHEMES)):
        write(folder / "system" / name, "dictionary", text % values)
    started = children_cpu_seconds()
    own = os.times()
    tetrahedra(radius, length_mm, throat_mm, edge_mm, folder / "tube.msh")
    seconds = sum(os.times()[:2]) - sum(own[:2])
    polyhedra(folder, "tube.msh", lambda _: _onto_wall(folder, radius))
    seconds += children_cpu_seconds() - started
    _fields(folder, float(radius(0.0)) * 1e-3, flow, density, viscosity)
    return {**figures(folder), "mesh_cpu_s": seconds}


def solve(folder, gradient, density):
    """Solves a case that `mesh` wrote with one of GRADIENTS, from rest.

    Returns a dict:
    - converged, iterations;
    - pressures_pa: on the axis at the probed places, relative to the outlet's pressure. They are those of the last
      iteration if the run converged, else means over the last AVERAGED_ITERATIONS iterations;
    - scatter_pa: the standard deviations over these iterations, 0 if the run converged;
    - flow_m3_per_s: through the outlet;
    - solve_cpu_s;
    - settled_cpu_s: CPU seconds until the pressure drop stays within SETTLED_SHARE of its last value. None if the run
      did not converge.

    Raises ComputationError if simpleFoam fails.
    """
    write(folder / "system" / "fvSchemes", "dictionary", SCHEMES % {"gradient": gradient})
    control = folder / "system" / "controlDict"
    control.write_text(re.sub(r"(endTime|writeInterval) \d+", rf"\1 {GRADIENTS[gradient]}", control.read_text()))
    for old in [folder / "postProcessing", *folder.glob("[1-9]*")]:
        shutil.rmtree(old, ignore_errors=True)
    started = children_cpu_seconds()
    log = run_program(folder, "simpleFoam")
    seconds = children_cpu_seconds() - started
    converged = re.search(r"SIMPLE solution converged in (\d+) iterations", log)
    table = np.loadtxt(folder / "postProcessing" / "axis" / "0" / "p", ndmin=2)[:, 1:] * density
    last = table[-1:] if converged else table[-AVERAGED_ITERATIONS:]
    fall = table[:, 0] - table[:, 1]
    far = np.flatnonzero(np.abs(fall / fall[-1] - 1) > SETTLED_SHARE)
    after = np.array(re.findall(r"ExecutionTime = ([\d.]+) s", log), float)
    return {
        "converged": converged is not None,
        "iterations": len(table),
        "pressures_pa": last.mean(axis=0),
        "scatter_pa": last.std(axis=0),
        "flow_m3_per_s": _outflow(folder),
        "solve_cpu_s": seconds,
        "settled_cpu_s": float(after[far[-1] + 1]) if converged and len(far) else None,
    }


def _outflow(folder):
    """Flow through the outlet in m3/s, from the fields that were written last."""
    latest = max((path for path in folder.glob("[1-9]*")), key=lambda path: int(path.name))
    text = (latest / "phi").read_text()
    values = re.search(r"outlet\s*{.*?List<scalar>\s*\d+\s*\((.*?)\)", text, re.S).group(1)
    return float(np.sum(np.array(values.split(), float)))


def _onto_wall(folder, radius):
    """Moves the wall's points outwards to the true radius, because the dual mesh has them on chords of the circle."""
    points = points_of(folder)
    chosen = np.unique(np.concatenate(faces(folder, "wall")))
    distance = np.hypot(points[chosen, 1], points[chosen, 2])
    points[chosen, 1:] *= (1e-3 * radius(1e3 * points[chosen, 0]) / distance)[:, None]
    path, rows = folder / "constant" / "polyMesh" / "points", iter(points)
    path.write_text(POINT.sub(lambda _: "({:.12g} {:.12g} {:.12g})".format(*next(rows)), path.read_text()))


def _fields(folder, radius, flow, density, viscosity):
    """Boundary values: a parabola of exactly `flow` (m3/s) at the inlet, pressure 0 at the outlet, no slip."""
    areas, centres = inlet_faces(folder)
    share = np.clip(1 - (np.hypot(centres[:, 1], centres[:, 2]) / radius) ** 2, 0, None)
    speed = share * flow / (share * np.abs(areas[:, 0])).sum()
    inlet = "\n".join(f"({u:.9g} 0 0)" for u in speed)
    write(
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
    write(
        folder / "0" / "p",
        "volScalarField",
        """dimensions [0 2 -2 0 0 0 0]; internalField uniform 0;
boundaryField
{ inlet { type zeroGradient; } outlet { type fixedValue; value uniform 0; } wall { type zeroGradient; } }
""",
    )
    write(
        folder / "constant" / "transportProperties",
        "dictionary",
        f"transportModel Newtonian; nu [0 2 -1 0 0 0 0] {viscosity / density:.9g};\n",
    )
    write(folder / "constant" / "turbulenceProperties", "dictionary", "simulationType laminar;\n")

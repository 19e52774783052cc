"""A tree as a case of OpenFOAM's simpleFoam: our answer gives the flows, and simpleFoam finds the pressures.

The mesh has one polyhedron round each node of a mesh file of `flow mesh`, and so has layers along the wall. SIMPLE runs
with upwind first, then with linearUpwind. The inflow is a parabola. Side branches have given flow rates, and the main
branch's outlet has pressure 0. A run with SIMPLEC and given pressures at all outlets diverged. Lengths are in mm if a
name says so, else in SI units.
"""

import shutil

import numpy as np
import openfoam_run as run

from flow.geometry.surface import INLET, WALL

# gmsh numbers a tetrahedron's nodes as follows: corners 0 to 3, then middles 4 to 9 of edges 01, 12, 02, 03, 23, 13.
# CORNERS has the four children at the corners.
CORNERS = ((0, 4, 6, 7), (1, 5, 4, 9), (2, 6, 5, 8), (3, 7, 9, 8))
# Diagonals of the octahedron between the corners: the two middles at its ends, and the ring of the other four.
DIAGONALS = ((4, 8, (5, 6, 7, 9)), (5, 7, (4, 6, 8, 9)), (6, 9, (4, 5, 8, 7)))
FACE_PARTS = ([0, 3, 5], [1, 4, 3], [2, 5, 4], [3, 4, 5])  # the four triangles that one of six nodes is cut into
UPWIND_ITERATIONS, LINEAR_ITERATIONS = 300, 500  # iterations of each scheme
AVERAGED_ITERATIONS = 100  # iterations over which means are taken
CONVECTION = ("bounded Gauss upwind", "bounded Gauss linearUpwind grad(U)")
SCHEMES = """ddtSchemes { default steadyState; }
gradSchemes { default Gauss linear; }
divSchemes { default none; div(phi,U) %s; div((nuEff*dev2(T(grad(U))))) Gauss linear; }
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
"""
SOLUTION = """solvers
{
    p { solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0.05; }
    U { solver smoothSolver; smoother symGaussSeidel; tolerance 1e-10; relTol 0.05; }
}
SIMPLE { consistent no; nNonOrthogonalCorrectors 0; residualControl { } }
relaxationFactors { fields { p 0.3; } equations { U 0.5; } }
"""
CONTROL = """application simpleFoam;
startFrom latestTime; startTime 0; stopAt endTime; endTime %(iterations)d; deltaT 1;
writeControl timeStep; writeInterval %(iterations)d; writeFormat ascii; writePrecision 12; timePrecision 8;
runTimeModifiable false;
functions
{
    inside
    {
        type probes; libs (sampling); probeLocations ((%(place)s)); fields (p); interpolationScheme cellPoint;
        writePrecision 10;
    }
    inlet
    {
        type surfaceFieldValue; libs (fieldFunctionObjects); regionType patch; name inlet; operation areaAverage;
        fields (p); writeFields false; writePrecision 10;
    }
}
"""


def patch_name(region):
    """Name of the OpenFOAM patch for a region_id."""
    return {WALL: "wall", INLET: "inlet"}.get(int(region), f"outlet{int(region) - 1}")


def tetrahedra(source, path):
    """Cuts each curved tetrahedron of a mesh file of `flow mesh` into eight at its nodes.

    Writes them to `path` (gmsh's format 2.2, mm).
    """
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        gmsh.open(str(source))
        tags, points, _ = gmsh.model.mesh.getNodes()
        number = np.zeros(int(tags.max()) + 1, int)
        number[tags] = np.arange(len(tags))
        points = points.reshape(-1, 3)
        cells = number[gmsh.model.mesh.getElementsByType(11)[1].reshape(-1, 10)]
        walls = {tag - 1: gmsh.model.mesh.getElementsByType(9, tag)[1] for _, tag in gmsh.model.getEntities(2)}
        walls = {region: number[nodes.reshape(-1, 6)] for region, nodes in sorted(walls.items())}
    finally:
        gmsh.finalize()
    fluid = max(walls) + 2
    names = [f'2 {region + 1} "{patch_name(region)}"' for region in walls] + [f'3 {fluid} "fluid"']
    nodes = [f"{k} {x:.9g} {y:.9g} {z:.9g}" for k, (x, y, z) in enumerate(points, 1)]
    elements = []
    for region, triangles in walls.items():
        corners = np.concatenate([triangles[:, part] for part in FACE_PARTS]) + 1
        elements += [f"2 2 {region + 1} {region + 1} {a} {b} {c}" for a, b, c in corners]
    elements += [f"4 2 {fluid} {fluid} {a} {b} {c} {d}" for a, b, c, d in eighths(points, cells) + 1]
    elements = [f"{k} {one}" for k, one in enumerate(elements, 1)]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    for name, part in (("PhysicalNames", names), ("Nodes", nodes), ("Elements", elements)):
        lines += [f"${name}", str(len(part)), *part, f"$End{name}"]
    path.write_text("\n".join(lines) + "\n")


def eighths(points, cells):
    """Tetrahedra (8 t, 4) that cells (t, 10), with gmsh's order of nodes, are cut into.

    Four lie at the corners. The octahedron between them is cut along its shortest diagonal, for a better shape.
    """
    length = [np.linalg.norm(points[cells[:, a]] - points[cells[:, b]], axis=1) for a, b, _ in DIAGONALS]
    shortest = np.argmin(length, axis=0)
    parts = [cells[:, list(part)] for part in CORNERS]
    for k, (a, b, ring) in enumerate(DIAGONALS):
        own = cells[shortest == k]
        parts += [own[:, [a, b, c, d]] for c, d in zip(ring, ring[1:] + ring[:1])]
    found = np.concatenate(parts)
    sides = points[found[:, 1:]] - points[found[:, :1]]
    inverted = np.linalg.det(sides) < 0
    found[inverted] = found[inverted][:, [0, 1, 3, 2]]
    return found


def mesh(folder, source):
    """Writes the case's polyhedra, one for each node of a mesh file of `flow mesh`.

    Returns {cells, volume_mm3, mesh_cpu_s}. Raises ComputationError where a program fails.
    """
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("system", "constant", "0"):
        (folder / name).mkdir(parents=True)
    _settings(folder, "0 0 0", CONVECTION[0], 1)
    started = run.cpu_seconds()
    tetrahedra(source, folder / "tree.msh")
    run.polyhedra(folder, "tree.msh")
    return {"mesh_cpu_s": run.cpu_seconds() - started, **run.figures(folder)}


def _settings(folder, place, convection, iterations):
    texts = {"controlDict": CONTROL % {"place": place, "iterations": iterations}, "fvSolution": SOLUTION}
    for name, text in {**texts, "fvSchemes": SCHEMES % convection}.items():
        run.write(folder / "system" / name, "dictionary", text)


def solve(folder, flows, probe_mm, density, viscosity):
    """Solves a case that `mesh` wrote, from rest.

    flows: {region_id: outflow in m3/s, None at the outlet whose pressure is given}; under INLET the inflow.
    Returns {fall_pa: mean pressure at the inlet minus the pressure at the probe, as a mean over the last
    AVERAGED_ITERATIONS iterations, scatter_pa: standard deviation over these iterations, iterations, solve_cpu_s}.
    Raises ComputationError if simpleFoam fails.
    """
    _fields(folder, flows, density, viscosity)
    place = " ".join(f"{1e-3 * x:.9g}" for x in probe_mm)
    started = run.cpu_seconds()
    for convection, last in zip(CONVECTION, (UPWIND_ITERATIONS, UPWIND_ITERATIONS + LINEAR_ITERATIONS)):
        _settings(folder, place, convection, last)
        run.run_program(folder, "simpleFoam")
    seconds = run.cpu_seconds() - started
    fall = density * (_series(folder, "inlet", "surfaceFieldValue.dat") - _series(folder, "inside", "p"))
    return {
        "fall_pa": float(fall[-AVERAGED_ITERATIONS:].mean()),
        "scatter_pa": float(fall[-AVERAGED_ITERATIONS:].std()),
        "iterations": len(fall),
        "solve_cpu_s": seconds,
    }


def _series(folder, name, file):
    """Values over the iterations that a function object wrote. simpleFoam writes one file for each of its starts."""
    found = sorted((folder / "postProcessing" / name).glob(f"*/{file}"), key=lambda path: int(path.parent.name))
    return np.concatenate([np.loadtxt(path, ndmin=2)[:, 1] for path in found])


def _fields(folder, flows, density, viscosity):
    """Writes the boundary values. The inflow is a parabola on a circle of the inlet's area, scaled to flows[INLET]."""
    areas, centres = run.inlet_faces(folder)
    area = np.linalg.norm(areas.sum(axis=0))
    normal = areas.sum(axis=0) / area
    centre = np.average(centres, axis=0, weights=areas @ normal)
    distance = np.linalg.norm(centres - centre, axis=1)
    share = np.clip(1 - distance**2 * np.pi / area, 0, None)
    speed = share * flows[INLET] / (share * (areas @ normal)).sum()
    inlet = "\n".join("({:.9g} {:.9g} {:.9g})".format(*(-u * normal)) for u in speed)
    given = f"type fixedValue; value nonuniform List<vector> {len(speed)}\n({inlet});"
    velocity, pressure = {"wall": "type noSlip;", "inlet": given}, dict.fromkeys(
        ("wall", "inlet"), "type zeroGradient;"
    )
    for region, flow in flows.items():
        if region != INLET:
            rate = f"type flowRateOutletVelocity; volumetricFlowRate {flow}; value uniform (0 0 0);"
            held = flow is None
            velocity[patch_name(region)] = "type zeroGradient;" if held else rate
            pressure[patch_name(region)] = "type fixedValue; value uniform 0;" if held else "type zeroGradient;"
    for name, kind, units, patches, rest in (
        ("U", "volVectorField", "[0 1 -1 0 0 0 0]", velocity, "(0 0 0)"),
        ("p", "volScalarField", "[0 2 -2 0 0 0 0]", pressure, "0"),
    ):
        entries = "\n".join(f"{patch} {{ {text} }}" for patch, text in patches.items())
        text = f"dimensions {units}; internalField uniform {rest};\nboundaryField\n{{\n{entries}\n}}\n"
        run.write(folder / "0" / name, kind, text)
    transport = f"transportModel Newtonian; nu [0 2 -1 0 0 0 0] {viscosity / density:.9g};\n"
    run.write(folder / "constant" / "transportProperties", "dictionary", transport)
    run.write(folder / "constant" / "turbulenceProperties", "dictionary", "simulationType laminar;\n")
    for old in [folder / "postProcessing", *folder.glob("[1-9]*")]:
        shutil.rmtree(old, ignore_errors=True)

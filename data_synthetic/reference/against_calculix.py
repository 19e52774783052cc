"""The slice against CalculiX (ccx 2.20), another code: a thick ring of plaque and wall, inflated and let go.

The same nodes, loads and constants: eccentric ring, plaque (J2, neo-Hookean, hardening) inside, Yeoh wall outside, a
pressure on the lumen that follows it up to two levels and back to none. CalculiX takes one layer of C3D20R in plane
strain; its finite plasticity is that of Simo too (*PLASTIC with NLGEOM), its Yeoh energy penalises the volume by
(J - 1)^2 where the slice has (J^2 - 1)/2 - ln J.
"""

import os
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np

from common.errors import ComputationError, InputError
from common.files import write_json

from . import materials
from .slice_model import SliceModel

AROUND, THROUGH = 16, 4
INNER_MM, C10_MPA, C20_MPA, BULK_MPA = 0.8, 0.05, 0.2, 20.0
PRESSURES_MPA = (0.045, 0.075, 0.0)
HEIGHT_MM = 0.2
INCREMENTS = 12  # a step of load, in both programs
SEAT_MPA_PER_MM = 1e-7  # holds the slice against rigid motion; CalculiX pins a node
TIMEOUT_S = 900


def ring():
    """(theta (2 around,), inner (2 around,), outer (2 around,)) in rad and mm; the plaque is the inner half."""
    theta = np.pi * np.arange(2 * AROUND) / AROUND
    return theta, np.full(len(theta), INNER_MM), 2.0 + 0.25 * np.cos(theta)


def slice_positions():
    """Positions (steps, 2 around, 2) of the lumen's nodes by the slice."""
    theta, inner, outer = ring()
    model = SliceModel(AROUND, THROUGH, C10_MPA, C20_MPA, BULK_MPA, SEAT_MPA_PER_MM)
    plaque = materials.FIBROUS

    def tissue(angle, radius):
        share = (radius < 0.5 * (INNER_MM + 2.0 + 0.25 * np.cos(angle))).astype(float)
        return (share, *(np.full_like(radius, v) for v in (plaque.shear_mpa, plaque.yield_mpa, plaque.hardening_mpa)))

    model.place(inner, outer, tissue)
    found, before = [], 0.0
    for pressure in PRESSURES_MPA:
        for value in np.linspace(before, pressure, INCREMENTS + 1)[1:]:
            model.advance({"pressure": float(value)}, "ring")
        before = pressure
        found.append(model.lumen_position())
    return np.array(found)


def nodes_and_elements():
    """(coordinates {number: (x, y, z)}, elements (n, 20), depth index (n,) of their first node) of one layer."""
    theta, inner, outer = ring()
    rows = 2 * THROUGH + 1
    depth = np.linspace(0, 1, rows)
    radius = inner[:, None] + (outer - inner)[:, None] * depth
    x, y = radius * np.cos(theta)[:, None], radius * np.sin(theta)[:, None]
    columns = len(theta)

    def number(i, j, k):
        return 1 + (k * columns + i % columns) * rows + j

    ring_nodes = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0)]  # (round, depth): corners, middles
    elements, first = [], []
    for i in range(0, columns, 2):
        for j in range(0, rows - 1, 2):
            low, high = ([number(i + a, j + b, k) for a, b in ring_nodes] for k in (0, 2))
            upright = [number(i + a, j + b, 1) for a, b in ring_nodes[:4]]
            elements.append(low[:4] + high[:4] + low[4:] + high[4:] + upright)
            first.append(j)
    used = {n for element in elements for n in element}
    coordinates = {
        number(i, j, k): (x[i, j], y[i, j], 0.5 * k * HEIGHT_MM)
        for k in range(3)
        for i in range(columns)
        for j in range(rows)
        if number(i, j, k) in used
    }
    return coordinates, np.array(elements), np.array(first)


def _lines(values, per_line=12):
    values = [str(v) for v in values]
    return [", ".join(values[i : i + per_line]) + "," for i in range(0, len(values), per_line)]


def deck():
    """Text of the CalculiX input."""
    coordinates, elements, first = nodes_and_elements()
    plaque = materials.FIBROUS
    mu, bulk = plaque.shear_mpa, BULK_MPA
    young, poisson = 9 * bulk * mu / (3 * bulk + mu), (3 * bulk - 2 * mu) / (2 * (3 * bulk + mu))
    rows = 2 * THROUGH + 1
    lumen = [1 + i * rows for i in range(2 * AROUND)]
    inside = first < THROUGH
    out = ["*NODE, NSET=ALL"]
    out += [f"{n}, {x:.12f}, {y:.12f}, {z:.12f}" for n, (x, y, z) in sorted(coordinates.items())]
    for name, chosen in (("PLAQUE", inside), ("WALL", ~inside)):
        out.append(f"*ELEMENT, TYPE=C3D20R, ELSET={name}")
        for number in np.flatnonzero(chosen):
            out += _lines([number + 1, *elements[number]], 11)
    out += ["*NSET, NSET=LUMEN", *_lines(lumen), "*ELSET, ELSET=INSIDE", *_lines(np.flatnonzero(first == 0) + 1)]
    # One node of the outside is pinned along x; the ring is symmetric about that axis.
    out += ["*BOUNDARY", "ALL, 3, 3", f"{rows}, 1, 2", f"{AROUND * rows + rows}, 2, 2"]
    out += ["*MATERIAL, NAME=PLAQUE", "*ELASTIC", f"{young:.12g}, {poisson:.12g}", "*PLASTIC"]
    out += [f"{plaque.yield_mpa}, 0.", f"{plaque.yield_mpa + 10 * plaque.hardening_mpa}, 10."]
    out += ["*MATERIAL, NAME=WALL", "*HYPERELASTIC, YEOH", f"{C10_MPA}, {C20_MPA}, 0., {2 / bulk:.12g}, 0., 0."]
    out += [f"*SOLID SECTION, ELSET={name}, MATERIAL={name}" for name in ("PLAQUE", "WALL")]
    for pressure in PRESSURES_MPA:
        out += ["*STEP, NLGEOM, INC=10000", "*STATIC", f"{1 / INCREMENTS}, 1., 1e-6, {1 / INCREMENTS}"]
        out += ["*DLOAD", f"INSIDE, P6, {pressure}", "*NODE PRINT, NSET=LUMEN, FREQUENCY=10000", "U", "*END STEP"]
    return "\n".join(out) + "\n"


def _printed(text):
    """Displacements (steps, nodes, 2) of the last increment of each step in the text of a .dat file."""
    blocks = [block.split("\n\n") for block in text.split("displacements")[1:]]
    found = [np.array([line.split()[1:3] for line in block[1].strip().splitlines()], float) for block in blocks]
    if len(found) != len(PRESSURES_MPA) or any(len(values) != 2 * AROUND for values in found):
        raise ComputationError(
            "CalculiX did not finish", "reference-ccx", f"{len(found)} results", "look at the folder's ring.log"
        )
    return np.array(found)


def calculix_positions(program, folder):
    """Positions (steps, 2 around, 2) of the lumen's nodes by CalculiX, run in `folder`.

    Raises InputError where the program is missing, ComputationError where it fails.
    """
    path = shutil.which(program)
    if path is None:
        raise InputError("CalculiX is not installed", "--program", program, "apt-get install calculix-ccx")
    folder = pathlib.Path(folder)
    (folder / "ring.inp").write_text(deck())
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    with open(folder / "ring.log", "w") as log:
        subprocess.run([path, "ring"], cwd=folder, env=environment, stdout=log, stderr=log, timeout=TIMEOUT_S)
    results = folder / "ring.dat"
    moved = _printed(results.read_text() if results.is_file() else "")
    theta, inner, _ = ring()
    return np.stack([inner * np.cos(theta), inner * np.sin(theta)], axis=1) + moved


def compared(ours, theirs):
    """Per load: mean radii (mm) about the centroid and the largest distance between nodes, rigid motion taken off."""
    found = []
    for pressure, a, b in zip(PRESSURES_MPA, ours, theirs):
        a, b = a - a.mean(axis=0), b - b.mean(axis=0)
        radii = [float(np.linalg.norm(v, axis=1).mean()) for v in (a, b)]
        found.append(
            {
                "pressure_mpa": pressure,
                "slice_radius_mm": radii[0],
                "calculix_radius_mm": radii[1],
                "radius_difference_percent": 100 * (radii[0] / radii[1] - 1),
                "largest_node_difference_mm": float(np.linalg.norm(a - b, axis=1).max()),
            }
        )
    return found


def compare(out, program="ccx"):
    """Writes `out`/slices_vs_calculix.json. Raises InputError, ComputationError."""
    with tempfile.TemporaryDirectory() as folder:
        theirs = calculix_positions(program, folder)
    document = {"schema": "vci-slices-vs-calculix-1", "loads": compared(slice_positions(), theirs)}
    write_json(pathlib.Path(out) / "slices_vs_calculix.json", document)
    for load in document["loads"]:
        print(", ".join(f"{key} {value:.6g}" for key, value in load.items()))
    return document

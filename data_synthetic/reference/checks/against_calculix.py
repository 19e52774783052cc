"""Compares a slice with CalculiX (ccx 2.20), another code. A thick ring of plaque and wall is inflated and let go.

Both codes have the same nodes, loads and constants. The ring is eccentric, with plaque (J2, neo-Hookean, hardening)
inside and a Yeoh wall outside. A follower pressure on the lumen rises to two levels and returns to zero.
"""

import pathlib
import tempfile

import numpy as np

from common.files import write_json

from ..slices.model import SliceModel
from ..solid import materials
from . import calculix

AROUND, THROUGH = 16, 4
INNER_MM, C10_MPA, C20_MPA, BULK_MPA = 0.8, 0.05, 0.2, 20.0
PRESSURES_MPA = (0.045, 0.075, 0.0)
INCREMENTS = 12  # both programs apply each load step in this many increments
RIGID_SUPPORT_MPA_PER_MM = 1e-7  # so soft that it only stops rigid motion; CalculiX has pinned nodes instead


def ring_geometry():
    """(theta, inner, outer) of the ring, each (2 AROUND,): angles in rad of the nodes, radii in mm of both edges.

    The plaque is the inner half of the thickness.
    """
    theta = np.pi * np.arange(2 * AROUND) / AROUND
    return theta, np.full(len(theta), INNER_MM), 2.0 + 0.25 * np.cos(theta)


def slice_positions():
    """Positions (load steps, 2 AROUND, 2) in mm of the lumen's nodes by the slice."""
    theta, inner, outer = ring_geometry()
    model = SliceModel(AROUND, THROUGH, C10_MPA, C20_MPA, BULK_MPA, RIGID_SUPPORT_MPA_PER_MM)
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


def ring_layer():
    """The ring as a calculix.ElementLayer."""
    return calculix.build_layer(*ring_geometry(), THROUGH)


def input_deck():
    """Text of the CalculiX input."""
    layer, plaque = ring_layer(), materials.FIBROUS
    inside = layer.depth_index < THROUGH // 2
    out = calculix.mesh_lines(layer, {"PLAQUE": inside, "WALL": ~inside})
    out += ["*ELSET, ELSET=INSIDE", *calculix.comma_lines(np.flatnonzero(layer.depth_index == 0) + 1)]
    # One node of the outside is pinned; the opposite one stays on the x axis, the line of symmetry.
    out += ["*BOUNDARY", f"{layer.outer_nodes[0]}, 1, 2", f"{layer.outer_nodes[AROUND]}, 2, 2"]
    out += calculix.plaque_lines("PLAQUE", plaque.shear_mpa, plaque.yield_mpa, plaque.hardening_mpa, BULK_MPA)
    out += calculix.wall_lines("WALL", C10_MPA, C20_MPA, BULK_MPA)
    out += [f"*SOLID SECTION, ELSET={name}, MATERIAL={name}" for name in ("PLAQUE", "WALL")]
    for pressure in PRESSURES_MPA:
        out += ["*STEP, NLGEOM, INC=10000", "*STATIC", f"{1 / INCREMENTS}, 1., 1e-6, {1 / INCREMENTS}"]
        out += ["*DLOAD", f"INSIDE, P6, {pressure}", "*NODE PRINT, NSET=LUMEN, FREQUENCY=10000", "U", "*END STEP"]
    return "\n".join(out) + "\n"


def calculix_positions(program, folder):
    """Positions (load steps, nodes round the lumen, 2) in mm by CalculiX, run in `folder`.

    Raises InputError and ComputationError, as `calculix.run_and_read` does.
    """
    theta, inner, _ = ring_geometry()
    moved = calculix.run_and_read(program, input_deck(), folder, "displacements", len(PRESSURES_MPA), len(theta))
    return np.stack([inner * np.cos(theta), inner * np.sin(theta)], axis=1) + moved


def comparison_rows(by_slice, by_calculix):
    """A row (dict) for each load step: mean radii (mm) of the lumen by both codes, and their largest difference.

    by_slice, by_calculix: results of slice_positions() and calculix_positions(). The largest difference is the greatest
    distance between a node's two positions, after both centroids are aligned.
    """
    found = []
    for pressure, a, b in zip(PRESSURES_MPA, by_slice, by_calculix):
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
        by_calculix = calculix_positions(program, folder)
    document = {"schema": "vci-slices-vs-calculix-1", "loads": comparison_rows(slice_positions(), by_calculix)}
    write_json(pathlib.Path(out) / "slices_vs_calculix.json", document)
    for load in document["loads"]:
        print(", ".join(f"{key} {value:.6g}" for key, value in load.items()))
    return document

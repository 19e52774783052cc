"""Input and run of CalculiX (ccx 2.20), another finite-element code, for a slice in plane strain.

The slice is one layer of elements C3D20R between z = 0 and LAYER_HEIGHT_MM, with all nodes held in z. Finite plasticity
is Simo's in both codes (*PLASTIC with NLGEOM). The Yeoh energies differ in the penalty on a change of volume J: (J -
1)^2 in CalculiX, (J^2 - 1)/2 - ln J in the slice.
"""

import os
import pathlib
import shutil
import subprocess
from dataclasses import dataclass

import numpy as np

from common.errors import ComputationError, InputError

LAYER_HEIGHT_MM = 0.2
TIMEOUT_S = 1800


@dataclass(frozen=True)
class ElementLayer:
    """One layer of 20-node bricks in a ring.

    coordinates: {node number: (x, y, z)} in mm. elements (n, 20): node numbers. ring_index, depth_index (n,): an
    element's place round the ring and through the wall. lumen_nodes, outer_nodes (2 around,): numbers of the nodes at z
    = 0 on the inner and the outer circle. top_offset: the node at z = LAYER_HEIGHT_MM above a node has the number of
    that node plus `top_offset`.
    """

    coordinates: dict
    elements: np.ndarray
    ring_index: np.ndarray
    depth_index: np.ndarray
    lumen_nodes: np.ndarray
    outer_nodes: np.ndarray
    top_offset: int

    def lumen_nodes_all_heights(self):
        """(numbers (n,), places (n,)) of the lumen's nodes at all heights, sorted by number.

        places: index into `lumen_nodes` of the node at z = 0 below each.
        """
        column = {int(node): place for place, node in enumerate(self.lumen_nodes)}
        levels = (0, self.top_offset // 2, self.top_offset)
        above = {node + level: place for node, place in column.items() for level in levels}
        numbers = sorted(node for node in above if node in self.coordinates)
        return np.array(numbers), np.array([above[node] for node in numbers])

    def displacement_lines(self, moved_mm):
        """Lines of input that prescribe displacements (2 around, 2) in mm of the lumen's nodes, at all heights."""
        out = ["*BOUNDARY"]
        for node, place in zip(*self.lumen_nodes_all_heights()):
            out += [f"{node}, {d + 1}, {d + 1}, {moved_mm[place, d]:.12g}" for d in (0, 1)]
        return out


def build_layer(theta, inner, outer, through):
    """The ElementLayer with nodes on rays at angles theta (2 around,) in rad, and `through` elements through the wall.

    inner, outer (2 around,): radii in mm of both edges on each ray.
    """
    rows, columns = 2 * through + 1, len(theta)
    share = np.linspace(0, 1, rows)
    radius = inner[:, None] + (outer - inner)[:, None] * share
    x, y = radius * np.cos(theta)[:, None], radius * np.sin(theta)[:, None]

    def number(i, j, k):
        return 1 + (k * columns + i % columns) * rows + j

    ring_nodes = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0)]  # (round, depth) in half elements
    elements, places = [], []
    for i in range(0, columns, 2):
        for j in range(0, rows - 1, 2):
            low, high = ([number(i + a, j + b, k) for a, b in ring_nodes] for k in (0, 2))
            upright = [number(i + a, j + b, 1) for a, b in ring_nodes[:4]]
            elements.append(low[:4] + high[:4] + low[4:] + high[4:] + upright)
            places.append((i // 2, j // 2))
    used = {n for element in elements for n in element}
    coordinates = {
        number(i, j, k): (x[i, j], y[i, j], 0.5 * k * LAYER_HEIGHT_MM)
        for k in range(3)
        for i in range(columns)
        for j in range(rows)
        if number(i, j, k) in used
    }
    column, depth = np.array(places).T
    lumen, outside = (np.array([number(i, j, 0) for i in range(columns)]) for j in (0, rows - 1))
    return ElementLayer(coordinates, np.array(elements), column, depth, lumen, outside, 2 * columns * rows)


def comma_lines(values, per_line=12):
    """Lines of numbers separated by commas, at most per_line numbers in a line."""
    values = [str(v) for v in values]
    return [", ".join(values[i : i + per_line]) + "," for i in range(0, len(values), per_line)]


def mesh_lines(ring, sets):
    """Lines of input for an ElementLayer: nodes, elements, node sets, and all nodes held in z.

    sets: {name: (n,) of bool}, which elements belong to each set.
    """
    out = ["*NODE, NSET=ALL"]
    out += [f"{n}, {x:.12f}, {y:.12f}, {z:.12f}" for n, (x, y, z) in sorted(ring.coordinates.items())]
    for name, chosen in sets.items():
        out.append(f"*ELEMENT, TYPE=C3D20R, ELSET={name}")
        for number in np.flatnonzero(chosen):
            out += comma_lines([number + 1, *ring.elements[number]], 11)
    return out + [
        "*NSET, NSET=LUMEN",
        *comma_lines(ring.lumen_nodes),
        "*NSET, NSET=WHOLELUMEN",
        *comma_lines(ring.lumen_nodes_all_heights()[0]),
        "*BOUNDARY",
        "ALL, 3, 3",
    ]


def plaque_lines(name, shear_mpa, yield_mpa, hardening_mpa, bulk_mpa):
    """Lines of input for plaque: an elastoplastic material with linear hardening."""
    young = 9 * bulk_mpa * shear_mpa / (3 * bulk_mpa + shear_mpa)
    poisson = (3 * bulk_mpa - 2 * shear_mpa) / (2 * (3 * bulk_mpa + shear_mpa))
    out = [f"*MATERIAL, NAME={name}", "*ELASTIC", f"{young:.12g}, {poisson:.12g}", "*PLASTIC"]
    return out + [f"{yield_mpa:.12g}, 0.", f"{yield_mpa + 10 * hardening_mpa:.12g}, 10."]


def wall_lines(name, c10_mpa, c20_mpa, bulk_mpa):
    """Lines of input for the wall: a Yeoh material."""
    return [f"*MATERIAL, NAME={name}", "*HYPERELASTIC, YEOH", f"{c10_mpa}, {c20_mpa}, 0., {2 / bulk_mpa:.12g}, 0., 0."]


def support_lines(ring, support_mpa_per_mm):
    """Lines of input for the elastic support outside the wall.

    It consists of springs at the outer nodes of both faces, fixed at their other end. Simpson's rule on each element's
    side shares the support (MPa/mm) out among the nodes.
    """
    numbers, places = ring.outer_nodes, np.array([ring.coordinates[n][:2] for n in ring.outer_nodes])
    first, middle, last = places[0::2], places[1::2], np.roll(places[0::2], -1, axis=0)
    points, weights = np.polynomial.legendre.leggauss(4)
    length = sum(
        w * np.linalg.norm((x - 0.5) * first - 2 * x * middle + (x + 0.5) * last, axis=1)
        for x, w in zip(points, weights)
    )
    share = np.empty(len(numbers))
    share[1::2] = 4 * length / 6
    share[0::2] = (length + np.roll(length, 1)) / 6
    out, element = [], len(ring.elements)
    for node, part in zip(numbers, share):
        stiffness = 0.5 * support_mpa_per_mm * LAYER_HEIGHT_MM * part
        for direction in (1, 2):
            name = f"SUPPORT{node}D{direction}"
            out += [
                f"*ELEMENT, TYPE=SPRING1, ELSET={name}",
                f"{element + 1}, {node}",
                f"{element + 2}, {node + ring.top_offset}",
            ]
            out += [f"*SPRING, ELSET={name}", f"{direction}", f"{stiffness:.12g}"]
            element += 2
    return out


def run_and_read(program, text, folder, kind, steps, nodes):
    """Runs CalculiX in `folder`. Returns what it prints for a node set after each load step: (steps, nodes, 2).

    text: the input. kind: "displacements" (mm) or "forces" (N). steps, nodes: the expected numbers. Raises InputError
    if the program is missing, ComputationError if it fails.
    """
    path = shutil.which(program)
    if path is None:
        raise InputError("CalculiX is not installed", "--program", program, "apt-get install calculix-ccx")
    folder = pathlib.Path(folder)
    (folder / "slice.inp").write_text(text)
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    with open(folder / "slice.log", "w") as log:
        subprocess.run([path, "slice"], cwd=folder, env=environment, stdout=log, stderr=log, timeout=TIMEOUT_S)
    results = folder / "slice.dat"
    text = results.read_text() if results.is_file() else ""
    blocks = [block.split("\n\n") for block in text.split(f" {kind} (")[1:]]
    found = [np.array([line.split()[1:3] for line in block[1].strip().splitlines()], float) for block in blocks]
    if len(found) != steps or any(len(values) != nodes for values in found):
        what, remedy = f"{len(found)} of {steps} results", "a finer slice, or a softer plan"
        raise ComputationError("CalculiX did not finish", "reference-ccx", what, remedy)
    return np.array(found)

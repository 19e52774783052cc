"""Lumens and devices of a case, packed for the 3-D viewer: quantised, reordered and compressed."""

import base64
import zlib

import matplotlib
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.spatial import cKDTree

from reports.figures.lumen import COLOUR_MAP, nearest_ffr, view_axes
from reports.inputs.case_files import states_in_3d
from reports.inputs.reading import read_table
from reports.inputs.surface import Surface, read_device, read_lumen

MOST_TRIANGLES = 12000
QUANTISATION_STEPS = 65535  # quantisation steps over the range of a coordinate or value: 1 um over 65 mm
COLOUR_STEPS = 32  # steps of the colour map
SECTION_COLUMNS = ("s_mm", "x_mm", "y_mm", "z_mm", "area_mm2", "equivalent_diameter_mm")


def viewer_data(files, metrics):
    """The content of a case's 3D viewer, as a JSON-ready document.

    `bounds` and `view` (rows: the axes of the first view) are common to all states. A state has points and triangles.
    Each point has the diameter (mm), the area (mm2) and, if the state has a flow, the FFR at the nearest place of an
    axis. Devices belong to state `vci`.
    """
    states = states_in_3d(metrics["states"])
    lumens = {state: order_for_compression(read_lumen(files.lumen(state), MOST_TRIANGLES)) for state in states}
    devices = (
        [order_for_compression(device) for device in map(read_device, files.strut_files()) if device]
        if "vci" in states
        else []
    )
    all_points = np.vstack([surface.points for surface in [*lumens.values(), *devices]])
    low, high = all_points.min(0), all_points.max(0)
    values = {state: values_at_points(files, state, lumens[state].points) for state in states}
    ranges = {
        name: [
            float(min(v[name].min() for v in values.values() if name in v)),
            float(max(v[name].max() for v in values.values() if name in v)),
        ]
        for name in ("ffr", "diameter", "area")
    }
    return {
        "bounds": [low.tolist(), high.tolist()],
        "view": view_axes(lumens["pre"].points).tolist(),
        "ranges": ranges,
        "states": {
            state: {
                **pack_surface(lumens[state], low, high),
                **{name: pack(quantise(v, *ranges[name])) for name, v in values[state].items()},
            }
            for state in states
        },
        "devices": [pack_surface(device, low, high) for device in devices],
    }


def values_at_points(files, state, points):
    """Diameter (mm), area (mm2) and, with a flow, FFR at points (n, 3), from the nearest place on any axis."""
    table = read_table(files.anatomy(state) / "sections.csv", SECTION_COLUMNS, ("branch",), "anatomy")
    _, nearest = cKDTree(table[["x_mm", "y_mm", "z_mm"]].to_numpy()).query(points)
    return {
        **({"ffr": nearest_ffr(files, state, points)} if files.has_flow(state) else {}),
        "diameter": table["equivalent_diameter_mm"].to_numpy()[nearest],
        "area": table["area_mm2"].to_numpy()[nearest],
    }


def order_for_compression(surface):
    """The same Surface with vertices and triangles in an order that compresses well: neighbours stand close together.

    Vertices are in reverse Cuthill-McKee order. A triangle starts at its vertex of lowest number, its orientation kept.
    """
    ends = np.vstack([surface.triangles[:, [0, 1]], surface.triangles[:, [1, 2]], surface.triangles[:, [2, 0]]])
    count = len(surface.points)
    neighbours = coo_matrix((np.ones(2 * len(ends)), (ends.T.ravel(), ends.T[::-1].ravel())), (count, count))
    order = reverse_cuthill_mckee(neighbours.tocsr(), symmetric_mode=True)
    place = np.empty(count, int)
    place[order] = np.arange(count)
    triangles = place[surface.triangles]
    turned = (triangles.argmin(1)[:, None] + np.arange(3)) % 3
    triangles = np.take_along_axis(triangles, turned, 1)
    return Surface(surface.points[order], triangles[np.lexsort(triangles.T[::-1])])


def pack_surface(surface, low, high):
    """{points, triangles, wide} of a Surface for the viewer. low, high (3,): the bounds of the coordinates in mm.

    points: each coordinate in 16 bits, as the difference from the point before. triangles: first vertex as the
    difference from that of the triangle before, the others as differences from the first. wide: 32-bit triangles.
    """
    first = surface.triangles[:, :1]
    wide = len(surface.points) > QUANTISATION_STEPS
    return {
        "points": pack(row_differences(quantise(surface.points, low, high))),
        "triangles": pack(
            np.hstack([row_differences(first), surface.triangles[:, 1:] - first]), np.uint32 if wide else np.uint16
        ),
        "wide": wide,
    }


def row_differences(values):
    """Each row (n, k) minus the row before it, the first as it is."""
    return np.diff(values.astype(np.int64), axis=0, prepend=0)


def quantise(values, low, high):
    """Values between low and high as 16-bit integers 0 to QUANTISATION_STEPS; 0 if the range is empty."""
    span = np.maximum(np.asarray(high) - np.asarray(low), 1e-12)
    return (
        np.round((np.asarray(values) - low) / span * QUANTISATION_STEPS).clip(0, QUANTISATION_STEPS).astype(np.uint16)
    )


def pack(values, kind=np.uint16):
    """Integers (n,) or (n, k), modulo the range of `kind`, as base64 of a zlib stream.

    The stream holds column after column; of each, the lowest bytes of all rows, then the next bytes. Neighbouring bytes
    are alike then, so they compress well.
    """
    columns = np.asarray(values).reshape(len(values), -1).T
    wrapped = columns.astype(np.int64).astype(kind).astype(np.dtype(kind).newbyteorder("<"))
    planes = wrapped.ravel().view(np.uint8).reshape(*columns.shape, np.dtype(kind).itemsize).transpose(0, 2, 1)
    return base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")


def colour_table():
    """The colour map as [[r, g, b], ...] of 0 to 1, the same as in the figures."""
    return np.round(matplotlib.colormaps[COLOUR_MAP](np.linspace(0, 1, COLOUR_STEPS))[:, :3], 4).tolist()

"""Lumens and devices of a case, packed for the 3-D viewer: quantised, base64, small."""

import base64

import matplotlib
import numpy as np
from scipy.spatial import cKDTree

from reports.figures.lumen import nearest_ffr, view_axes
from reports.inputs.case_files import pictured
from reports.inputs.reading import read_table
from reports.inputs.surface import read_device, read_lumen

MOST_TRIANGLES = 12000
STEPS = 65535  # quantisation steps over the range of a coordinate or value: 1 um over 65 mm
COLOUR_MAP, COLOURS = "viridis", 32
PLACES = ("s_mm", "x_mm", "y_mm", "z_mm", "area_mm2", "equivalent_diameter_mm")


def viewer_data(files, metrics):
    """The content of a case's 3D viewer, as a JSON-ready document.

    `bounds` and `view` (rows: the axes of the first view) are common to all states. A state has points and triangles.
    Each point has FFR, and the diameter (mm) and area (mm2) at the nearest place of the axis. Devices belong to state
    `vci`.
    """
    states = pictured(metrics["states"])
    lumens = {state: read_lumen(files.lumen(state), MOST_TRIANGLES) for state in states}
    devices = [device for device in map(read_device, files.struts()) if device] if "vci" in states else []
    every = np.vstack([surface.points for surface in [*lumens.values(), *devices]])
    low, high = every.min(0), every.max(0)
    values = {state: along_axis(files, state, lumens[state].points) for state in states}
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


def along_axis(files, state, points):
    """Diameter (mm), area (mm2) and, with a flow, FFR at points (n, 3), from the nearest place on any axis."""
    table = read_table(files.anatomy(state) / "sections.csv", PLACES, ("branch",), "anatomy")
    _, nearest = cKDTree(table[["x_mm", "y_mm", "z_mm"]].to_numpy()).query(points)
    return {
        **({"ffr": nearest_ffr(files, state, points)} if files.has_flow(state) else {}),
        "diameter": table["equivalent_diameter_mm"].to_numpy()[nearest],
        "area": table["area_mm2"].to_numpy()[nearest],
    }


def pack_surface(surface, low, high):
    """Points (16 bits a coordinate over the bounds) and triangles of a Surface, base64."""
    kind = np.uint16 if len(surface.points) <= STEPS else np.uint32
    return {
        "points": pack(quantise(surface.points, low, high)),
        "triangles": pack(surface.triangles.astype(kind)),
        "wide": kind is np.uint32,
    }


def quantise(values, low, high):
    """Values between low and high as 16-bit integers 0 to STEPS; 0 if the range is empty."""
    span = np.maximum(np.asarray(high) - np.asarray(low), 1e-12)
    return np.round((np.asarray(values) - low) / span * STEPS).clip(0, STEPS).astype(np.uint16)


def pack(array):
    """An integer array as base64 of its little-endian bytes."""
    return base64.b64encode(array.astype(array.dtype.newbyteorder("<")).tobytes()).decode("ascii")


def colour_table():
    """The colour map as [[r, g, b], ...] of 0 to 1, the same as in the figures."""
    return np.round(matplotlib.colormaps[COLOUR_MAP](np.linspace(0, 1, COLOURS))[:, :3], 4).tolist()

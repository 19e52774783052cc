"""Lumens, devices and values on the wall of a case, packed for the 3-D viewer: quantised, reordered, compressed."""

import base64
import zlib

import matplotlib
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.spatial import cKDTree
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

from common import vtp
from reports.figures.lumen import COLOUR_MAP, nearest_ffr, view_axes
from reports.inputs.case_files import states_in_3d
from reports.inputs.reading import read_array, read_polydata, read_table
from reports.inputs.surface import Surface, read_device, read_lumen
from reports.measuring.device_readouts import LARGEST_MALAPPOSITION_MM
from reports.measuring.stent_edges import RUPTURE_STRETCH

MOST_TRIANGLES = 12000
QUANTISATION_STEPS = 65535  # steps over the range of a coordinate or value: a step is 1 um for a vessel of 65 mm
NO_VALUE = QUANTISATION_STEPS  # the step that stands for nan; values take only the steps below it
COLOUR_STEPS = 32  # steps of a colour table
# The colours of these values have fixed ends, so that patients can be compared. The limit is in the middle; beyond it
# the colours are warm. Stretch is 1 for the wall before PCI. Gap is the distance in mm between stent and wall. From its
# limit on, acute malapposition is corrected (Räber et al., Eur Heart J 2018; 39: 3281-3300).
SCALES = {
    "stretch": {"low": 1.0, "high": 2 * RUPTURE_STRETCH - 1.0, "limit": RUPTURE_STRETCH},
    "gap": {"low": 0.0, "high": 2 * LARGEST_MALAPPOSITION_MM, "limit": LARGEST_MALAPPOSITION_MM},
}
TOUCHING_MM = 0.1  # a wall point with gap 0 touches a stent if it is this near to one; otherwise no stent faces it
SECTION_COLUMNS = ("s_mm", "x_mm", "y_mm", "z_mm", "area_mm2", "equivalent_diameter_mm")


def viewer_data(files, metrics):
    """The content of a case's 3D viewer, as a JSON-ready document.

    `bounds` and `view` (rows: the axes of the first view) are common to all states. A state has points and triangles,
    with the `values_at_points`. `devices` are the stents of the state `vci`. `ranges` has the smallest and largest of
    each value. `scales` has the fixed ends and the limit of a value's colours, for values in SCALES.
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
        name: [float(end([end(v[name]) for v in values.values() if name in v])) for end in (np.nanmin, np.nanmax)]
        for name in dict.fromkeys(name for v in values.values() for name in v)
    }
    return {
        "bounds": [low.tolist(), high.tolist()],
        "view": view_axes(lumens["pre"].points).tolist(),
        "ranges": ranges,
        "scales": {name: scale for name, scale in SCALES.items() if name in ranges},
        "states": {
            state: {
                **pack_surface(lumens[state], low, high),
                **{name: pack(quantise_values(v, *ranges[name])) for name, v in values[state].items()},
            }
            for state in states
        },
        "devices": [pack_surface(device, low, high) for device in devices],
    }


def values_at_points(files, state, points):
    """Values (n,) of a state at points (n, 3): diameter (mm), area (mm2), FFR with a flow, wall_values of `vci`.

    The wall_values come from the nearest point of the wall, all others from the nearest section or pull-back point.
    """
    table = read_table(files.anatomy(state) / "sections.csv", SECTION_COLUMNS, ("branch",), "anatomy")
    _, nearest = cKDTree(table[["x_mm", "y_mm", "z_mm"]].to_numpy()).query(points)
    return {
        **({"ffr": nearest_ffr(files, state, points)} if files.has_flow(state) else {}),
        "diameter": table["equivalent_diameter_mm"].to_numpy()[nearest],
        "area": table["area_mm2"].to_numpy()[nearest],
        **(wall_values(files, points) if state == "vci" else {}),
    }


def wall_values(files, points):
    """{stretch, gap} of the wall after virtual PCI, at the wall's points nearest to points (n, 3).

    stretch (n,): the wall's largest principal stretch, nan where the wall was held fixed. gap (n,): distance in mm from
    the wall to the stent, nan where no stent faces the wall. A quantity without any value is left out.
    """
    path = files.deployed_lumen
    lumen = read_polydata(path, "vci deploy")
    stretch, gap, displacement = (
        read_array(lumen.GetPointData(), name, path) for name in ("wall_stretch", "malapposition_mm", "displacement_mm")
    )
    wall = vtp.points(lumen)
    stretch = np.where(np.any(displacement != 0.0, axis=1), stretch, np.nan)
    gap = np.where((gap > 0.0) | (distance_to_stents(files, wall) < TOUCHING_MM), gap, np.nan)
    _, nearest = cKDTree(wall).query(points)
    values = {"stretch": stretch[nearest], "gap": gap[nearest]}
    return {name: v for name, v in values.items() if np.isfinite(v).any()}


def distance_to_stents(files, points):
    """Distance (n,) in mm from points (n, 3) to the smooth surface of the nearest stent; infinite without a stent."""
    nearest = np.full(len(points), np.inf)
    for path in files.stent_files():
        surface, found = vtkImplicitPolyDataDistance(), vtkDoubleArray()
        surface.SetInput(read_polydata(path, "vci deploy"))
        surface.FunctionValue(numpy_to_vtk(points, deep=True), found)
        nearest = np.minimum(nearest, np.abs(vtk_to_numpy(found)))
    return nearest


def order_for_compression(surface):
    """The same Surface, reordered so that neighbours stand close together, which compresses well.

    Vertices are in reverse Cuthill-McKee order. A triangle starts at its vertex of lowest number and keeps its
    orientation.
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

    points: each coordinate in 16 bits, as the difference from the point before. triangles: the first vertex as the
    difference from the first vertex of the triangle before, the two others as differences from the first. wide: whether
    the triangles have 32 bits, for many points.
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


def quantise_values(values, low, high):
    """Like quantise, for values that may be nan: nan becomes NO_VALUE, all other steps are lower."""
    steps = np.minimum(quantise(np.nan_to_num(values, nan=low), low, high), NO_VALUE - 1)
    return np.where(np.isnan(values), NO_VALUE, steps).astype(np.uint16)


def pack(values, kind=np.uint16):
    """Integers (n,) or (n, k), modulo the range of `kind`, as base64 of a zlib stream.

    The stream holds one column after another. In a column the lowest bytes of all rows come first, then the next bytes.
    So similar bytes are neighbours and compress well.
    """
    columns = np.asarray(values).reshape(len(values), -1).T
    wrapped = columns.astype(np.int64).astype(kind).astype(np.dtype(kind).newbyteorder("<"))
    planes = wrapped.ravel().view(np.uint8).reshape(*columns.shape, np.dtype(kind).itemsize).transpose(0, 2, 1)
    return base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")


def colour_tables():
    """{plain, limit}: tables of colours [[r, g, b], ...] of 0 to 1.

    plain: the colour map of the figures. limit: for values with a limit, cool colours below it and warm ones above.
    """
    half = np.linspace(0.0, 1.0, COLOUR_STEPS // 2)
    cool = matplotlib.colormaps["GnBu"](0.3 + 0.6 * half)
    warm = matplotlib.colormaps["OrRd"](0.5 + 0.45 * half)
    tables = {"plain": matplotlib.colormaps[COLOUR_MAP](np.linspace(0, 1, COLOUR_STEPS)), "limit": [*cool, *warm]}
    return {name: np.round(np.array(table)[:, :3], 4).tolist() for name, table in tables.items()}

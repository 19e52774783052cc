"""Slices of the CT before and after the procedure with lumen and plaque, like figure 5 of Lyu et al. 2025."""

import matplotlib.pyplot as plt
import numpy as np
import vtk
from scipy.ndimage import map_coordinates
from vtk.util.numpy_support import vtk_to_numpy

from reports.figures.style import LABELS, save_figure
from reports.inputs.polyline import read_centreline
from reports.inputs.reading import require_file, read_polydata

HALF_WIDTH_MM, PIXEL_MM = 5.0, 0.05
WINDOW_HU = (-200.0, 800.0)
SLICE_NAMES = ("Proximal end", "Tightest place before", "Distal end")  # places in the treated segment, margins included
# state of the image -> states whose lumens are drawn on it: the true lumen, and the lumen found in the image
STATES_BY_IMAGE = {"pre": ("pre", "ct_pre"), "reference": ("reference", "ct")}
SEGMENTED_STATES = ("ct_pre", "ct")
TRUE_COLOUR, SEGMENTED_COLOUR, PLAQUE_COLOUR = "#5fe3c0", "#ff8ad8", "#e6c229"  # all visible on the black of a CT


@plt.rc_context({"figure.constrained_layout.use": False})  # it leaves wide gaps here; saving would apply it, too
def ct_figure(files, metrics, folder):
    """Writes <case>_ct.{svg,png} and returns their paths.

    Each panel is a slice across the vessel. There is a row for each CT image (STATES_BY_IMAGE) and a column for each
    place along the segment (SLICE_NAMES).
    """
    before = metrics["states"]["pre"]["area"]["profile_mm2"]
    stations = dict(zip(SLICE_NAMES, (0, int(np.argmin(before)), len(before) - 1)))
    figure, grid = plt.subplots(len(STATES_BY_IMAGE), len(SLICE_NAMES), figsize=(7.5, 5.35), squeeze=False)
    figure.subplots_adjust(left=0.04, right=0.99, bottom=0.08, top=0.95, wspace=0.03, hspace=0.03)
    for row, (image, states) in zip(grid, STATES_BY_IMAGE.items()):
        line = read_centreline(files.anatomy(image) / "centreline.vtp", metrics["segment"]["branch"])
        values, origin, spacing = read_volume(files.folder / "ct" / image / "ct.nii.gz")
        for axes, (place, station) in zip(row, stations.items()):
            centre, plane_axes = cross_section_plane(line, metrics["states"][image]["s_mm"][station])
            draw_slice(axes, values, origin, spacing, centre, plane_axes)
            for state in states:
                draw_outline(axes, files.lumen(state), centre, plane_axes, state)
            if image == "pre":
                axes.set_title(place, fontsize=8.5)
        row[0].set_ylabel(LABELS[image])
    handles = {label: handle for axes in grid.ravel() for handle, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(handles.values(), handles, loc="lower center", ncols=len(handles), fontsize=8.5)
    return save_figure(figure, folder, f"{files.case}_ct")


def read_volume(path):
    """(values (nx, ny, nz) in HU, centre of the first voxel (3,), spacing (3,)) of a CT volume.

    Centre and spacing are in mm, in the coordinates of the lumen.
    """
    reader = vtk.vtkNIFTIImageReader()
    reader.SetFileName(str(require_file(path, "data_synthetic phantom")))
    reader.Update()
    data, matrix = reader.GetOutput(), reader.GetQFormMatrix()
    values = vtk_to_numpy(data.GetPointData().GetScalars()).reshape(data.GetDimensions(), order="F")
    return values, np.array([matrix.GetElement(k, 3) for k in range(3)]), np.array(data.GetSpacing())


def cross_section_plane(line, s_mm):
    """The plane across a Polyline at arc length s_mm: (its centre (3,) in mm, two unit vectors (2, 3) in it)."""
    centre, tangent = line.point_at(s_mm), line.point_at(s_mm + 1.0) - line.point_at(s_mm - 1.0)
    tangent /= np.linalg.norm(tangent)
    first = np.cross(tangent, np.eye(3)[np.abs(tangent).argmin()])
    first /= np.linalg.norm(first)
    return centre, np.stack([first, np.cross(tangent, first)])


def draw_slice(axes, values, origin, spacing, centre, plane_axes):
    """Draws the CT in grey on a square of side 2 HALF_WIDTH_MM round the point `centre` (3,).

    values, origin, spacing: result of `read_volume`. plane_axes (2, 3): unit vectors in the plane of the square.
    """
    positions = np.arange(-HALF_WIDTH_MM, HALF_WIDTH_MM + 0.5 * PIXEL_MM, PIXEL_MM)
    points = centre + positions[None, :, None] * plane_axes[0] + positions[:, None, None] * plane_axes[1]
    indices = np.moveaxis((points - origin) / spacing, -1, 0)
    grey = map_coordinates(values.astype(np.float32), indices, order=1, mode="nearest")
    extent = (-HALF_WIDTH_MM, HALF_WIDTH_MM, -HALF_WIDTH_MM, HALF_WIDTH_MM)
    axes.imshow(grey, cmap="gray", vmin=WINDOW_HU[0], vmax=WINDOW_HU[1], origin="lower", extent=extent)
    axes.grid(False)
    axes.set(xticks=[], yticks=[])
    axes.autoscale(False)  # an outline that leaves the square is cut off there, so that all panels have one scale


def draw_outline(axes, lumen, centre, plane_axes, state):
    """Draws the outline of a lumen in a plane and, for state `pre`, the outer edge of its plaque if there is any.

    lumen: file of the surface. centre (3,) and plane_axes (2, 3): a point of the plane in mm and unit vectors in it.
    If the plane cuts the surface in several outlines, only the one nearest to `centre` is drawn.
    """
    surface = read_polydata(lumen, "anatomy")
    plane = vtk.vtkPlane()
    plane.SetOrigin(*centre)
    plane.SetNormal(*np.cross(*plane_axes))
    cutter = vtk.vtkCutter()
    cutter.SetInputData(surface)
    cutter.SetCutFunction(plane)
    nearest = vtk.vtkPolyDataConnectivityFilter()
    nearest.SetInputConnection(cutter.GetOutputPort())
    nearest.SetExtractionModeToClosestPointRegion()
    nearest.SetClosestPoint(*centre)
    nearest.Update()
    merged = vtk.vtkCleanPolyData()
    merged.SetInputConnection(nearest.GetOutputPort())
    joined = vtk.vtkStripper()  # joins the segments of the cut to one line, also where it turns back at a side branch
    joined.SetInputConnection(merged.GetOutputPort())
    joined.SetMaximumLength(surface.GetNumberOfPoints())  # of points in a line
    joined.JoinContiguousSegmentsOn()
    joined.Update()
    outline = max(_lines(joined.GetOutput()), key=len)
    points = vtk_to_numpy(joined.GetOutput().GetPoints().GetData())
    ring = ((points - centre) @ plane_axes.T)[outline]
    if state in SEGMENTED_STATES:
        axes.plot(*ring.T, color=SEGMENTED_COLOUR, linestyle=":", label="Lumen found in the CT")
    else:
        axes.plot(*ring.T, color=TRUE_COLOUR, linewidth=1.2, label="True lumen")
    thickness = joined.GetOutput().GetPointData().GetArray("plaque_thickness_mm")
    if thickness is not None and state == "pre":
        plaque_thickness = np.nan_to_num(vtk_to_numpy(thickness))[outline]
        outwards = ring - ring[:-1].mean(0)
        edge = ring + outwards / np.linalg.norm(outwards, axis=1, keepdims=True) * plaque_thickness[:, None]
        axes.plot(*edge.T, color=PLAQUE_COLOUR, linewidth=1.2, label="Outer edge of the plaque")


def _lines(polydata):
    """[(n,) indices of the points] of each line of a vtkPolyData."""
    cells = polydata.GetLines()
    offsets, points = (vtk_to_numpy(array) for array in (cells.GetOffsetsArray(), cells.GetConnectivityArray()))
    return [points[a:b] for a, b in zip(offsets, offsets[1:])]

"""A CT volume: voxels in HU with their place in the patient's frame, written as NIfTI-1."""

import gzip
import pathlib
import tempfile
from dataclasses import dataclass

import numpy as np
import vtk
from scipy.ndimage import map_coordinates, spline_filter
from vtk.util.numpy_support import numpy_to_vtk

from common.files import replacing

LOWEST_HU, HIGHEST_HU = -1024, 3071  # scanners store twelve bits, which is this range
SIGMA_PER_FWHM = 1 / np.sqrt(8 * np.log(2))
UNITS_BYTE, MILLIMETRES = 123, 2  # place and value of the field xyzt_units in a NIfTI-1 header


@dataclass
class Image:
    """A CT volume. values (nx, ny, nz) in HU; origin_mm (3,): centre of the first voxel; spacing_mm (3,).

    The axes are the patient's x, y and z.
    """

    values: np.ndarray
    origin_mm: np.ndarray
    spacing_mm: np.ndarray

    def centres(self, axis):
        """Voxel centres (mm) along axis 0, 1 or 2."""
        return self.origin_mm[axis] + self.spacing_mm[axis] * np.arange(self.values.shape[axis])

    def index(self, points_mm):
        """Indices (n, 3) of the voxels nearest to points (n, 3) in mm, and whether each lies in the volume (n,)."""
        at = np.rint((np.asarray(points_mm) - self.origin_mm) / self.spacing_mm).astype(int)
        return at, np.all((at >= 0) & (at < self.values.shape), axis=-1)

    def cropped(self, points_mm, margin_mm):
        """The part of the image round points (n, 3) in mm, with margin_mm on every side as far as the image reaches."""
        low = np.floor((np.min(points_mm, axis=0) - margin_mm - self.origin_mm) / self.spacing_mm).astype(int)
        high = np.ceil((np.max(points_mm, axis=0) + margin_mm - self.origin_mm) / self.spacing_mm).astype(int) + 1
        low, high = np.maximum(low, 0), np.minimum(high, self.values.shape)
        box = tuple(slice(a, b) for a, b in zip(low, high))
        return Image(self.values[box], self.origin_mm + low * self.spacing_mm, self.spacing_mm)

    def interpolator(self):
        """A function of points (..., 3) in mm that gives HU (...) by cubic splines. The image is mirrored outside."""
        coefficients = spline_filter(self.values.astype(np.float32), order=3, output=np.float32, mode="mirror")

        def at(points_mm):
            where = (np.asarray(points_mm, float) - self.origin_mm) / self.spacing_mm
            return map_coordinates(coefficients, np.moveaxis(where, -1, 0), order=3, mode="mirror", prefilter=False)

        return at


def write(image, path, description):
    """Writes an Image as 16-bit NIfTI-1 with HU clipped to twelve bits, compressed if `path` ends in .gz.

    Its qform and sform both hold the image's place in the patient's frame, in mm. description: at most 79 characters.
    """
    values = np.clip(np.rint(image.values), LOWEST_HU, HIGHEST_HU).astype(np.int16)
    data = vtk.vtkImageData()
    data.SetDimensions(*values.shape)
    data.SetSpacing(*image.spacing_mm)
    data.GetPointData().SetScalars(numpy_to_vtk(values.ravel(order="F"), deep=True))
    matrix = vtk.vtkMatrix4x4()
    for axis in range(3):
        matrix.SetElement(axis, 3, float(image.origin_mm[axis]))
    writer = vtk.vtkNIFTIImageWriter()
    writer.SetInputData(data)
    writer.SetQFormMatrix(matrix)
    writer.SetSFormMatrix(matrix)
    writer.SetRescaleSlope(1.0)
    writer.SetRescaleIntercept(0.0)
    writer.SetDescription(description[:79])
    with replacing(path) as partial, tempfile.TemporaryDirectory() as folder:
        plain = pathlib.Path(folder) / "volume.nii"
        writer.SetFileName(str(plain))
        writer.Write()
        content = bytearray(plain.read_bytes())
        content[UNITS_BYTE] = MILLIMETRES  # vtkNIFTIImageWriter leaves the units unknown
        # mtime=0 leaves out the time of day, so that the same volume gives the same bits.
        partial.write_bytes(gzip.compress(content, 6, mtime=0) if partial.suffix == ".gz" else content)

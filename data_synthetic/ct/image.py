"""A CT volume: voxels in HU with their place in the patient's frame, written and read as NIfTI-1."""

import gzip
import pathlib
import struct
import tempfile
import zlib
from dataclasses import dataclass

import numpy as np
import vtk
from scipy.ndimage import map_coordinates, spline_filter
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from common.errors import InputError
from common.files import replacing

LOWEST_HU, HIGHEST_HU = -1024, 3071  # twelve bits, as scanners store
UNITS_BYTE, MILLIMETRES = 123, 2  # NIfTI-1 header, xyzt_units


@dataclass
class Image:
    """values (nx, ny, nz) in HU; origin_mm (3,) is the centre of the first voxel, spacing_mm (3,), axes x, y, z."""

    values: np.ndarray
    origin_mm: np.ndarray
    spacing_mm: np.ndarray

    def centres(self, axis):
        """Voxel centres (mm) along axis 0, 1 or 2."""
        return self.origin_mm[axis] + self.spacing_mm[axis] * np.arange(self.values.shape[axis])

    def index(self, points_mm):
        """Nearest voxel (n, 3) to points (n, 3), and whether it lies in the volume (n,)."""
        at = np.rint((np.asarray(points_mm) - self.origin_mm) / self.spacing_mm).astype(int)
        return at, np.all((at >= 0) & (at < self.values.shape), axis=-1)

    def interpolator(self):
        """f(points (..., 3) mm) -> HU (...) by cubic splines; mirrored outside the volume."""
        coefficients = spline_filter(self.values.astype(np.float32), order=3, output=np.float32, mode="mirror")

        def at(points_mm):
            where = (np.asarray(points_mm, float) - self.origin_mm) / self.spacing_mm
            return map_coordinates(coefficients, np.moveaxis(where, -1, 0), order=3, mode="mirror", prefilter=False)

        return at


def write(image, path, description):
    """Writes 16-bit NIfTI-1 (gzip by suffix), HU clipped to twelve bits, qform = sform = the patient's frame in mm."""
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
        content[UNITS_BYTE] = MILLIMETRES  # which the writer leaves unknown
        # Without the time of day, so that the same volume gives the same bits.
        partial.write_bytes(gzip.compress(content, 6, mtime=0) if partial.suffix == ".gz" else content)


def _check_complete(path):
    """Raises InputError if the file ends before the voxels that its NIfTI-1 header announces; VTK fills in zeros."""
    try:
        with gzip.open(path) if path.suffix == ".gz" else open(path, "rb") as handle:
            header, length = handle.read(352), 352
            order = "<" if struct.unpack("<i", header[:4])[0] == 348 else ">"
            sizes = struct.unpack(f"{order}8h", header[40:56])
            bits, start = struct.unpack(f"{order}h", header[72:74])[0], struct.unpack(f"{order}f", header[108:112])[0]
            while chunk := handle.read(1 << 24):
                length += len(chunk)
    except (EOFError, struct.error, zlib.error, gzip.BadGzipFile) as error:
        raise InputError("the volume is cut off or damaged", path, error, "copy or export it again") from error
    wanted = int(start) + int(np.prod(sizes[1 : 1 + max(sizes[0], 1)], dtype=np.int64)) * bits // 8
    if length < wanted:
        raise InputError("the volume is cut off", path, f"{length} of {wanted} bytes", "copy or export it again")


def read(path):
    """The image at `path`. Raises InputError if it is no NIfTI volume or is rotated against the axes."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such file", path, "missing", "give a CT volume, .nii or .nii.gz")
    reader = vtk.vtkNIFTIImageReader()
    if not reader.CanReadFile(str(path)):
        raise InputError("not a NIfTI volume", path, path.suffix, "convert the CT series to .nii or .nii.gz")
    _check_complete(path)
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    matrix = reader.GetQFormMatrix() or reader.GetSFormMatrix()
    if matrix is None:
        raise InputError("the volume has no place in space", f"{path}: qform, sform", "absent", "export it with one")
    matrix = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    if np.abs(matrix[:3, :3] - np.eye(3)).max() > 1e-4:
        raise InputError("the volume is rotated or flipped", f"{path}: qform", "not along x, y, z", "resample it first")
    scalars = data.GetPointData().GetScalars()
    if scalars is None or scalars.GetNumberOfComponents() != 1 or min(data.GetDimensions()) < 2:
        raise InputError("not a volume of one CT number a voxel", path, data.GetDimensions(), "give one 3D series")
    values = vtk_to_numpy(scalars).reshape(data.GetDimensions(), order="F")
    slope = reader.GetRescaleSlope() or 1.0
    values = values * np.float32(slope) + np.float32(reader.GetRescaleIntercept())
    # The header holds 32-bit numbers; a nanometre is more than they carry.
    return Image(values, np.round(matrix[:3, 3], 6), np.round(np.array(data.GetSpacing()), 6))

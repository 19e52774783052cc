"""Reads CT volumes from scanners and archives: NIfTI files and DICOM series, in any orientation."""

import pathlib
from dataclasses import dataclass

import nibabel
import numpy as np
import pydicom

from common.errors import InputError
from common.volume import Image

LARGEST_SKEW = 1e-3  # largest cosine between two voxel axes: 0.2 mm over a heart; a tilted gantry gives far more
LARGEST_UNEVENNESS = 0.25  # largest error of a slice's place, in slice distances; rounding to 0.1 mm causes less
SAME_PLACE_MM, HEADER_TOLERANCE = 1e-3, 1e-3  # a header's rounding errors: of places (mm); of directions and sizes
FEWEST_SLICES = 10  # a series that shows a vessel has this many; scouts and dose reports have fewer
AIR_AND_FAT_HU = 0.0  # at least a hundredth of the voxels round any heart, air and fat, are darker than this
AIR_HU = -1024.0  # the lowest CT number on the usual 12-bit scale; lower values are padding
FRAMES_HINT = "right-anterior-superior for NIfTI, left-posterior-superior for DICOM: x and y change sign between them"
MM_PER_UNIT = {"meter": 1000.0, "mm": 1.0, "micron": 0.001, "unknown": 1.0}


@dataclass
class Volume:
    """A CT volume: an Image, whose coordinates run along its own voxel axes, and its orientation in the patient.

    rotation (3, 3): turns the image's coordinates into the patient's, both in mm: patient = rotation @ image.
    """

    image: Image
    rotation: np.ndarray

    def to_image(self, points):
        """Points (..., 3) of the patient in the image's coordinates."""
        return np.asarray(points, float) @ self.rotation

    def to_patient(self, points):
        """Points (..., 3) of the image in the patient's coordinates."""
        return np.asarray(points, float) @ self.rotation.T


def read(path, series=None):
    """The Volume of a NIfTI file or of a folder of DICOM files.

    Coordinates are the NIfTI header's (right-anterior-superior) or DICOM's (left-posterior-superior). series: the UID
    of the wanted series if the folder has several. Raises InputError if there is no single, complete volume of CT
    numbers.
    """
    path = pathlib.Path(path)
    if path.is_dir():
        values, affine = _read_dicom(path, series)
    elif path.is_file():
        values, affine = _read_nifti(path)
    else:
        raise InputError("no such CT volume", path, "missing", "a NIfTI file, or a folder with a DICOM series")
    if not np.isfinite(values).all():
        count = int((~np.isfinite(values)).sum())
        raise InputError("a CT number is not finite", path, f"{count} voxels", "export the volume again, as integers")
    lowest = float(np.percentile(_without_padding(values[::2, ::2, ::2]), 1))
    if lowest > AIR_AND_FAT_HU:
        remedy = "give CT numbers in HU: the rescale intercept (often -1024) is missing, or it is no CT;"
        remedy += " a volume cropped to blood and muscle alone needs some fat or lung round it"
        value = f"only a hundredth of the voxels lie below {lowest:.0f} HU: no fat, no air"
        raise InputError("no CT numbers", path, value, remedy)
    return _align_to_axes(values, affine, path)


def _without_padding(values):
    """The values without padding, which fills corners and margins with one number: (k,), or unchanged (nx, ny, nz).

    The lowest value counts as padding, unless it lies between AIR_HU and AIR_AND_FAT_HU: then it may be air.
    """
    lowest = values.min()
    inside = values[values > lowest]
    return inside if inside.size and not AIR_HU <= lowest < AIR_AND_FAT_HU else values


def _align_to_axes(values, affine, path):
    """The Volume of values (nx, ny, nz) with the affine (4, 4) from voxel indices to mm.

    Its axes are swapped and reversed until they are right-handed and as near as possible to the patient's. No voxel
    moves in space.
    """
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    if not (spacing > 0).all() or not np.isfinite(affine).all():
        remedy = "export it with the position and direction of its voxels"
        raise InputError("the volume has no place in space", path, affine[:3].tolist(), remedy)
    axes = affine[:3, :3] / spacing
    skew = np.abs(axes.T @ axes - np.eye(3)).max()
    if skew > LARGEST_SKEW:
        value = f"{np.degrees(np.arcsin(min(skew, 1))):.2f} degrees off"
        remedy = "resample it to a rectangular grid (dcm2niix and 3D Slicer do): the gantry was tilted"
        raise InputError("the voxel axes are not at right angles", path, value, remedy)
    order = nibabel.orientations.io_orientation(affine)
    turned = nibabel.orientations.apply_orientation(values, order)
    affine = affine @ nibabel.orientations.inv_ornt_aff(order, values.shape)
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    rotation = np.linalg.qr(affine[:3, :3] / spacing)[0]  # exact rotation; columns may be negated
    rotation *= np.sign((rotation * affine[:3, :3]).sum(axis=0))
    if np.abs(rotation - np.eye(3)).max() < 1e-4:
        rotation = np.eye(3)
    # Rounded to a nanometre, since the header's 32-bit numbers are no more exact.
    origin = np.round(rotation.T @ affine[:3, 3], 6)
    return Volume(Image(np.ascontiguousarray(turned), origin, np.round(spacing, 6)), rotation)


def _read_nifti(path):
    """(values (nx, ny, nz) in HU, affine (4, 4) from voxel indices to mm) of a NIfTI file."""
    try:
        found = nibabel.load(path)
        if not isinstance(found, nibabel.Nifti1Image):
            raise InputError("not a NIfTI volume", path, type(found).__name__, "a file .nii or .nii.gz")
        values = found.get_fdata(dtype=np.float32)
    except (nibabel.filebasedimages.ImageFileError, nibabel.spatialimages.HeaderDataError) as error:
        raise InputError(
            "not a NIfTI volume", path, path.suffix, "a file .nii or .nii.gz, or a DICOM folder"
        ) from error
    except (OSError, EOFError, ValueError) as error:
        raise InputError("the volume is cut off or damaged", path, error, "copy or export it again") from error
    values = values[..., 0] if values.ndim == 4 and values.shape[3] == 1 else values
    if values.ndim != 3 or min(values.shape) < 2:
        remedy = "export one phase alone, as a volume of three dimensions"
        raise InputError("not a volume of one CT number a voxel", path, f"voxels {list(values.shape)}", remedy)
    header = found.header
    if header["sform_code"] == 0 and header["qform_code"] == 0:
        raise InputError(
            "the volume has no place in space", f"{path}: qform, sform", "absent", "export it with one of them"
        )
    scale = np.diag([MM_PER_UNIT[header.get_xyzt_units()[0]]] * 3 + [1.0])
    return values, scale @ found.affine


def _read_dicom(folder, series_uid):
    """(values (nx, ny, nz) in HU, affine (4, 4) from voxel indices to mm) of a folder's series.

    series_uid: the series' UID, or None if the folder has a single one.
    """
    by_series = {}
    for file in sorted(file for file in folder.rglob("*") if file.is_file()):
        try:
            head = pydicom.dcmread(file, stop_before_pixels=True)
        except (pydicom.errors.InvalidDicomError, OSError):
            continue
        if "SeriesInstanceUID" in head and "ImagePositionPatient" in head and "Rows" in head:
            by_series.setdefault(str(head.SeriesInstanceUID), []).append((file, head))
        elif int(head.get("NumberOfFrames", 1)) > 1:
            remedy = "convert it to NIfTI (dcm2niix)"
            raise InputError("one file with many frames is not read", file, f"{head.NumberOfFrames} frames", remedy)
    found = {uid: slices for uid, slices in by_series.items() if len(slices) >= FEWEST_SLICES}
    if series_uid is not None:
        found = {uid: slices for uid, slices in found.items() if uid == series_uid}
    if len(found) != 1:
        names = [f"{uid} ({s[0][1].get('SeriesDescription', '')}, {len(s)} images)" for uid, s in by_series.items()]
        remedy = f"a folder with one series of {FEWEST_SLICES} images or more, or name its UID (ct: series, --series)"
        what = (
            "several series in the folder"
            if found
            else "no such series"
            if series_uid
            else "no DICOM series in the folder"
        )
        raise InputError(what, folder, "; ".join(names) or "none", remedy)
    return _stack_slices(next(iter(found.values())), folder)


def _stack_slices(slices, folder):
    """The values and affine of one series, as _read_dicom() returns them. slices: [(file, header)]."""
    heads = [head for _, head in slices]
    if heads[0].get("Modality") != "CT":
        value = f"modality {heads[0].get('Modality')}"
        raise InputError("not a CT series", folder, value, "the folder of a CT angiogram, whose modality is CT")
    names = [*["ImageOrientationPatient"] * 6, *["PixelSpacing"] * 2, "Rows", "Columns"]
    geometry = [(*map(float, h.ImageOrientationPatient), *map(float, h.PixelSpacing), h.Rows, h.Columns) for h in heads]
    lowest, highest = np.min(geometry, axis=0), np.max(geometry, axis=0)
    if (highest - lowest).max() > HEADER_TOLERANCE:
        k = int((highest - lowest).argmax())
        value, remedy = f"{names[k]} from {lowest[k]:g} to {highest[k]:g}", "a folder with one reconstruction alone"
        raise InputError("the images of the series differ in size or direction", folder, value, remedy)
    along_row, along_column = np.array(geometry[0][:3]), np.array(geometry[0][3:6])
    normal = np.cross(along_row, along_column)
    place = np.array([[float(x) for x in h.ImagePositionPatient] for h in heads])
    order = np.argsort(place @ normal)
    place, steps = place[order], np.diff((place @ normal)[order])
    if steps.min() < SAME_PLACE_MM:
        at = np.round(place[int(steps.argmin())], 2).tolist()
        value = f"{int((steps < SAME_PLACE_MM).sum())} images lie where another does, the first at {at} mm"
        raise InputError("several images of one slice", folder, value, "a folder with one phase of the heart alone")
    off = np.concatenate([[0], np.cumsum(steps - steps.mean())])
    if np.abs(off).max() > LARGEST_UNEVENNESS * np.median(steps):
        at = int(np.abs(steps - np.median(steps)).argmax())
        value = f"{steps[at]:.3f} mm after image {at + 1} along the series, else {np.median(steps):.3f} mm"
        remedy = "the whole series, evenly reconstructed: an image is missing, or there are two slice distances"
        raise InputError("the slices are not evenly apart", folder, value, remedy)
    values = np.stack([_pixels(slices[k][0]).T for k in order], axis=2)
    affine = np.eye(4)
    rows_apart, columns_apart = geometry[0][6:8]
    affine[:3, 0], affine[:3, 1] = along_row * columns_apart, along_column * rows_apart
    affine[:3, 2], affine[:3, 3] = (place[-1] - place[0]) / (len(place) - 1), place[0]
    return values, affine


def _pixels(file):
    """CT numbers (rows, columns) of one image."""
    image = pydicom.dcmread(file)
    try:
        values = image.pixel_array.astype(np.float32)
    except Exception as error:  # pydicom's decoders raise whatever errors their libraries raise
        raise InputError("the image cannot be decoded", file, error, "decompress it (gdcmconv --raw)") from error
    return values * np.float32(image.get("RescaleSlope", 1)) + np.float32(image.get("RescaleIntercept", 0))

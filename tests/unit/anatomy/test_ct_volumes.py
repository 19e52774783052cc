"""CT volumes in the forms that archives hand on, each with the same vessel at the same place."""

import gzip
import json

import nibabel
import numpy as np
import pydicom
import pytest
from pydicom.dataset import FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

from anatomy.ct import volumes
from common import volume as image
from common.errors import InputError

SPACING = np.array([0.35, 0.4, 0.5])


@pytest.fixture
def volume():
    values = np.rint(np.random.default_rng(3).normal(0, 200, (12, 14, 16))).astype(np.float32)
    return image.Image(values, np.array([-12.35, 4.2, 7.7]), SPACING)


def rotation(*degrees):
    x, y, z = np.radians(degrees)
    about_x = [[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]]
    about_y = [[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]]
    about_z = [[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]]
    return np.array(about_z) @ about_y @ about_x


def check_places(found, values, affine):
    """Every voxel's value is found at the place that the affine gives it."""
    index = np.stack(np.meshgrid(*[np.arange(1, n - 1) for n in values.shape], indexing="ij"), axis=-1).reshape(-1, 3)
    places = index @ affine[:3, :3].T + affine[:3, 3]
    at, inside = found.image.index(found.to_image(places))
    assert inside.all()
    assert np.abs(found.image.values[tuple(at.T)] - values[tuple(index.T)]).max() < 0.51
    centres = found.image.origin_mm + at * found.image.spacing_mm
    assert np.abs(found.to_patient(centres) - places).max() < 1e-3


@pytest.mark.parametrize("name", ["ct.nii", "ct.nii.gz"])
def test_the_phantoms_own_file(volume, tmp_path, name):
    image.write(volume, tmp_path / name, "phantom")
    found = volumes.read(tmp_path / name)
    assert np.array_equal(found.rotation, np.eye(3))
    assert np.array_equal(found.image.values, volume.values)
    assert np.allclose(found.image.origin_mm, volume.origin_mm, atol=1e-6)
    assert np.array_equal(found.image.spacing_mm, SPACING)


@pytest.mark.parametrize("flips", [(1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, 1, -1)])
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 0, 2)])
@pytest.mark.parametrize("turn", [(0, 0, 0), (12, -7, 20)])
def test_nifti_in_any_orientation(volume, tmp_path, flips, order, turn):
    axes = rotation(*turn)[:, list(order)] * flips * SPACING
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = axes, (31.0, -190.0, 1700.0)
    nibabel.save(nibabel.Nifti1Image(volume.values.astype(np.int16), affine), tmp_path / "ct.nii.gz")
    found = volumes.read(tmp_path / "ct.nii.gz")
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    check_places(found, volume.values, affine)


def test_a_slope_and_an_intercept_are_applied(volume, tmp_path):
    stored = (2 * (volume.values + 24)).astype(np.int16)
    nibabel.save(nibabel.Nifti1Image(stored, np.diag([*SPACING, 1])), tmp_path / "ct.nii")
    content = bytearray((tmp_path / "ct.nii").read_bytes())
    content[112:120] = np.array([0.5, -24], "<f4").tobytes()  # scl_slope, scl_inter
    (tmp_path / "ct.nii").write_bytes(content)
    assert np.array_equal(volumes.read(tmp_path / "ct.nii").image.values, volume.values)


def test_a_volume_in_metres_comes_in_millimetres(volume, tmp_path):
    nifti = nibabel.Nifti1Image(volume.values.astype(np.int16), np.diag([*(SPACING / 1000), 1]))
    nifti.header.set_xyzt_units("meter")
    nibabel.save(nifti, tmp_path / "ct.nii")
    assert volumes.read(tmp_path / "ct.nii").image.spacing_mm == pytest.approx(SPACING)


def write_series(folder, values, affine, slope=1.0, intercept=-1024.0, names=None, uid=None, modality="CT"):
    """A DICOM series of values (nx, ny, nz) at an affine (4, 4) from voxel numbers to the patient's mm."""
    folder.mkdir(exist_ok=True)
    uid, spacing = uid or generate_uid(), np.linalg.norm(affine[:3, :3], axis=0)
    for k in range(values.shape[2]):
        data = pydicom.Dataset()
        data.SOPClassUID, data.SOPInstanceUID, data.SeriesInstanceUID = CTImageStorage, generate_uid(), uid
        data.Modality, data.SeriesDescription = modality, "CTA 75 %"
        data.Rows, data.Columns = values.shape[1], values.shape[0]
        data.PixelSpacing = [f"{spacing[1]:.8g}", f"{spacing[0]:.8g}"]
        axes = affine[:3, :2] / spacing[:2]
        data.ImageOrientationPatient = [f"{x:.9f}" for x in [*axes[:, 0], *axes[:, 1]]]
        data.ImagePositionPatient = [f"{x:.10g}" for x in affine[:3, 3] + k * affine[:3, 2]]
        data.RescaleSlope, data.RescaleIntercept = slope, intercept
        data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
        data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 0
        stored = np.rint((values[:, :, k].T - intercept) / slope).astype(np.uint16)
        data.PixelData = stored.tobytes()
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = data.SOPClassUID, data.SOPInstanceUID
        meta.TransferSyntaxUID = ExplicitVRLittleEndian
        data.file_meta, data.is_little_endian, data.is_implicit_VR = meta, True, False
        pydicom.dcmwrite(folder / (names[k] if names else f"{uid[-6:]}_{k}.dcm"), data, write_like_original=False)
    return uid


def oblique(turn=(0, 0, 0), downwards=False):
    affine = np.eye(4)
    affine[:3, :3] = rotation(*turn) * SPACING
    affine[:3, 3] = (31.0, -190.0, 1700.0)
    if downwards:
        affine[:3, 2] *= -1
    return affine


@pytest.mark.parametrize("turn", [(0, 0, 0), (12, -7, 20), (90, 0, 0)])
@pytest.mark.parametrize("downwards", [False, True])
@pytest.mark.parametrize("slope, intercept", [(1.0, -1024.0), (0.5, -1000.0)])
def test_dicom_series_in_any_orientation(volume, tmp_path, turn, downwards, slope, intercept):
    affine = oblique(turn, downwards)
    names = [f"I{k}" for k in np.random.default_rng(1).permutation(volume.values.shape[2])]  # no order, no ending
    write_series(tmp_path / "series", volume.values, affine, slope, intercept, names)
    (tmp_path / "series" / "DICOMDIR.txt").write_text("no image")
    found = volumes.read(tmp_path / "series")
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    check_places(found, volume.values, affine)


def test_of_several_series_one_must_be_named(volume, tmp_path):
    write_series(tmp_path / "study", volume.values[..., :3], oblique())  # a scout
    first = write_series(tmp_path / "study", volume.values, oblique())
    assert volumes.read(tmp_path / "study").image.values.shape == volume.values.shape
    write_series(tmp_path / "study", volume.values - 7, oblique())
    with pytest.raises(InputError, match="several series"):
        volumes.read(tmp_path / "study")
    check_places(volumes.read(tmp_path / "study", first), volume.values, oblique())
    with pytest.raises(InputError, match="no such series"):
        volumes.read(tmp_path / "study", "1.2.3")


def test_incomplete_or_unfit_series_are_refused(volume, tmp_path):
    write_series(tmp_path / "gap", volume.values, oblique(), names=[f"{k:02d}" for k in range(16)])
    (tmp_path / "gap" / "07").unlink()
    with pytest.raises(InputError, match="not evenly apart"):
        volumes.read(tmp_path / "gap")
    uid = write_series(tmp_path / "phases", volume.values, oblique())
    write_series(tmp_path / "phases", volume.values, oblique(), uid=uid, names=[f"b{k}" for k in range(16)])
    with pytest.raises(InputError, match="several images of one slice"):
        volumes.read(tmp_path / "phases")
    write_series(tmp_path / "mr", volume.values, oblique(), modality="MR")
    with pytest.raises(InputError, match="not a CT series"):
        volumes.read(tmp_path / "mr")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no DICOM series"):
        volumes.read(tmp_path / "empty")


def test_positions_rounded_to_a_tenth_of_a_millimetre_are_even(volume, tmp_path):
    """Slices 0.45 mm apart are written as 0.4 and 0.5 mm apart. A series with larger differences is not even, and is
    refused."""
    affine = oblique()
    affine[2, 2] = 0.45
    for extra, even in ((0.0, True), (0.3, False)):
        folder = tmp_path / f"series{extra}"
        write_series(folder, volume.values, affine, names=[f"{k:02d}" for k in range(16)])
        for k in range(16):
            image_of = pydicom.dcmread(folder / f"{k:02d}")
            x, y, z = image_of.ImagePositionPatient
            image_of.ImagePositionPatient = [x, y, f"{np.floor(10 * float(z) + 0.5) / 10 + extra * (k > 8):.1f}"]
            image_of.save_as(folder / f"{k:02d}")
        if even:
            assert volumes.read(folder).image.spacing_mm[2] == pytest.approx(0.45, abs=0.01)
        else:
            with pytest.raises(InputError, match="(?s)not evenly apart.*after image 9"):
                volumes.read(folder)


def test_ten_images_are_a_series(volume, tmp_path):
    write_series(tmp_path / "ten", volume.values[..., :10], oblique())
    assert volumes.read(tmp_path / "ten").image.values.shape[2] == 10
    write_series(tmp_path / "nine", volume.values[..., :9], oblique())
    with pytest.raises(InputError, match="(?s)no DICOM series.*9 images.*10 images or more"):
        volumes.read(tmp_path / "nine")


def test_images_of_two_reconstructions_are_told_apart_by_what_differs(volume, tmp_path):
    uid = write_series(tmp_path / "mixed", volume.values, oblique(), names=[f"{k:02d}" for k in range(16)])
    for spacing, alike in (("0.4005", True), ("0.42", False)):
        one = pydicom.dcmread(tmp_path / "mixed" / "03")
        one.PixelSpacing = [spacing, "0.35"]
        one.save_as(tmp_path / "mixed" / "03")
        if alike:
            assert volumes.read(tmp_path / "mixed", uid).image.values.shape[2] == 16
        else:
            with pytest.raises(InputError, match="PixelSpacing from 0.4 to 0.42"):
                volumes.read(tmp_path / "mixed")


@pytest.mark.parametrize("tilt, straight", [(0.0009, True), (0.0012, False)])
def test_axes_may_be_off_by_what_moves_no_vessel(volume, tmp_path, tilt, straight):
    affine = np.diag([*SPACING, 1.0])
    affine[0, 2] = tilt * SPACING[2]
    nibabel.save(nibabel.Nifti1Image(volume.values, affine), tmp_path / "ct.nii")
    if straight:
        assert volumes.read(tmp_path / "ct.nii").image.spacing_mm == pytest.approx(SPACING, rel=1e-4)
    else:
        with pytest.raises(InputError, match="(?s)right angles.*0.07 degrees off.*dcm2niix"):
            volumes.read(tmp_path / "ct.nii")


@pytest.mark.parametrize("fat, enough", [(0.02, True), (0.005, False)])
def test_a_closely_cropped_heart_has_a_hundredth_of_fat(volume, tmp_path, fat, enough):
    values = np.full((20, 20, 25), 60, np.float32)
    values.flat[np.random.default_rng(1).permutation(values.size)[: int(fat * values.size)]] = -80
    nibabel.save(nibabel.Nifti1Image(values, np.diag([*SPACING, 1.0])), tmp_path / "ct.nii")
    if enough:
        volumes.read(tmp_path / "ct.nii")
    else:
        with pytest.raises(InputError, match="(?s)no CT numbers.*below 60 HU.*cropped"):
            volumes.read(tmp_path / "ct.nii")


def test_what_is_no_volume_is_refused(volume, tmp_path):
    with pytest.raises(InputError, match="no such CT volume"):
        volumes.read(tmp_path / "none.nii")
    (tmp_path / "text.nii").write_text(json.dumps({"not": "a volume"}))
    with pytest.raises(InputError, match="not a NIfTI"):
        volumes.read(tmp_path / "text.nii")
    affine = np.diag([*SPACING, 1.0])
    nibabel.save(nibabel.Nifti1Image(np.stack([volume.values] * 3, axis=3), affine), tmp_path / "phases.nii")
    with pytest.raises(InputError, match="one phase"):
        volumes.read(tmp_path / "phases.nii")
    nibabel.save(nibabel.Nifti1Image(volume.values + 1024, affine), tmp_path / "raw.nii")
    with pytest.raises(InputError, match="no CT numbers"):
        volumes.read(tmp_path / "raw.nii")
    for padding in (0, -2000):  # value in the corners outside the scanner's circle, where nothing was measured
        padded = volume.values + 1024
        padded[:6] = padding
        nibabel.save(nibabel.Nifti1Image(padded, affine), tmp_path / "padded.nii")
        with pytest.raises(InputError, match="(?s)no CT numbers.*intercept"):
            volumes.read(tmp_path / "padded.nii")
    sheared = affine.copy()
    sheared[0, 2] = 0.1
    nibabel.save(nibabel.Nifti1Image(volume.values, sheared), tmp_path / "tilted.nii")
    with pytest.raises(InputError, match="right angles"):
        volumes.read(tmp_path / "tilted.nii")
    nibabel.save(nibabel.Nifti1Image(volume.values, None), tmp_path / "nowhere.nii")
    with pytest.raises(InputError, match="no place in space"):
        volumes.read(tmp_path / "nowhere.nii")


@pytest.mark.parametrize("name, keep", [("ct.nii", 900), ("ct.nii", 1), ("ct.nii.gz", 600), ("ct.nii.gz", 40)])
def test_a_volume_that_is_cut_off_is_refused(volume, tmp_path, name, keep):
    image.write(volume, tmp_path / name, "phantom")
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[:-1] if keep == 1 else whole[:keep])
    with pytest.raises(InputError):
        volumes.read(tmp_path / name)


def test_header_is_nifti_with_two_frames_and_millimetres(volume, tmp_path):
    image.write(volume, tmp_path / "ct.nii", "phantom")
    head = (tmp_path / "ct.nii").read_bytes()[:352]
    assert head[344:348] == b"n+1\0"
    qform, sform = np.frombuffer(head, "<i2", 2, 252)
    assert qform > 0 and sform > 0 and head[123] & 7 == 2  # both qform and sform are set; unit code 2: mm
    assert np.allclose(np.frombuffer(head, "<f4", 3, 268), volume.origin_mm)
    rows = np.frombuffer(head, "<f4", 12, 280).reshape(3, 4)
    assert np.allclose(rows[:, :3], np.diag(volume.spacing_mm), atol=1e-6)
    assert np.allclose(rows[:, 3], volume.origin_mm, atol=1e-5)


def test_values_are_clipped_to_twelve_bits(volume, tmp_path):
    volume.values[0, 0, 0], volume.values[1, 1, 1] = 9000, -4000
    image.write(volume, tmp_path / "ct.nii.gz", "phantom")
    assert gzip.open(tmp_path / "ct.nii.gz").read(4) == b"\x5c\x01\0\0"
    back = volumes.read(tmp_path / "ct.nii.gz").image
    assert back.values.max() == 3071 and back.values.min() == -1024


def test_interpolation_meets_voxels_and_a_linear_field(volume):
    centres = np.stack(np.meshgrid(*[volume.centres(k) for k in range(3)], indexing="ij"), axis=-1)
    assert np.allclose(volume.interpolator()(centres), volume.values, atol=0.1)
    volume.values = centres @ np.array([3.0, -2.0, 5.0])
    middle = volume.origin_mm + volume.spacing_mm * [6.3, 7.6, 8.1]
    assert volume.interpolator()(middle[None])[0] == pytest.approx(middle @ [3.0, -2.0, 5.0], abs=0.1)


def test_a_part_of_a_volume_lies_where_it_did(volume):
    middle = volume.origin_mm + 6 * SPACING
    part = volume.cropped(middle[None], 1.0)
    assert part.values.shape < volume.values.shape
    assert part.values[tuple(part.index(middle)[0])] == volume.values[6, 6, 6]
    assert volume.cropped(middle[None], 100.0).values.shape == volume.values.shape

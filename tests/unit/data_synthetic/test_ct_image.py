import json

import numpy as np
import pytest

from common.errors import InputError
from data_synthetic.ct import image


@pytest.fixture
def volume():
    values = np.random.default_rng(3).normal(100, 200, (7, 9, 11)).astype(np.float32)
    return image.Image(values, np.array([-12.35, 4.2, 7.7]), np.array([0.35, 0.4, 0.5]))


@pytest.mark.parametrize("name", ["ct.nii", "ct.nii.gz"])
def test_round_trip_keeps_values_place_and_spacing(volume, tmp_path, name):
    image.write(volume, tmp_path / name, "phantom")
    back = image.read(tmp_path / name)
    assert np.array_equal(back.values, np.rint(volume.values))
    assert np.allclose(back.origin_mm, volume.origin_mm, atol=1e-6)
    assert np.array_equal(back.spacing_mm, volume.spacing_mm)


def test_header_is_nifti_with_two_frames_and_millimetres(volume, tmp_path):
    image.write(volume, tmp_path / "ct.nii", "phantom")
    head = (tmp_path / "ct.nii").read_bytes()[:352]
    assert head[344:348] == b"n+1\0"
    qform, sform = np.frombuffer(head, "<i2", 2, 252)
    assert qform > 0 and sform > 0 and head[123] & 7 == 2  # both frames stand; unit code 2: mm
    assert np.allclose(np.frombuffer(head, "<f4", 3, 268), volume.origin_mm)
    rows = np.frombuffer(head, "<f4", 12, 280).reshape(3, 4)
    assert np.allclose(rows[:, :3], np.diag(volume.spacing_mm), atol=1e-6)
    assert np.allclose(rows[:, 3], volume.origin_mm, atol=1e-5)


def test_values_are_clipped_to_twelve_bits(volume, tmp_path):
    volume.values[0, 0, 0], volume.values[1, 1, 1] = 9000, -4000
    image.write(volume, tmp_path / "ct.nii", "phantom")
    back = image.read(tmp_path / "ct.nii")
    assert back.values.max() == 3071 and back.values.min() == -1024


def test_interpolation_meets_voxels_and_a_linear_field(volume):
    centres = np.stack(np.meshgrid(*[volume.centres(k) for k in range(3)], indexing="ij"), axis=-1)
    assert np.allclose(volume.interpolator()(centres), volume.values, atol=0.1)
    volume.values = centres @ np.array([3.0, -2.0, 5.0])
    middle = volume.origin_mm + volume.spacing_mm * [3.3, 4.6, 5.1]
    assert volume.interpolator()(middle[None])[0] == pytest.approx(middle @ [3.0, -2.0, 5.0], abs=0.1)


def test_what_is_no_volume_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        image.read(tmp_path / "none.nii")
    (tmp_path / "text.nii").write_text(json.dumps({"not": "a volume"}))
    with pytest.raises(InputError, match="not a NIfTI"):
        image.read(tmp_path / "text.nii")


def test_a_rotated_volume_is_refused(volume, tmp_path):
    image.write(volume, tmp_path / "ct.nii", "phantom")
    data = bytearray((tmp_path / "ct.nii").read_bytes())
    data[256:260] = np.float32(0.3).tobytes()  # quatern_b
    (tmp_path / "ct.nii").write_bytes(data)
    with pytest.raises(InputError, match="rotated"):
        image.read(tmp_path / "ct.nii")


@pytest.mark.parametrize("name, keep", [("ct.nii", 900), ("ct.nii", 1), ("ct.nii.gz", 600), ("ct.nii.gz", 40)])
def test_a_volume_that_is_cut_off_is_refused(volume, tmp_path, name, keep):
    """VTK would read zeros for what is missing."""
    image.write(volume, tmp_path / name, "phantom")
    whole = (tmp_path / name).read_bytes()
    assert image.read(tmp_path / name).values.shape == (7, 9, 11)
    (tmp_path / name).write_bytes(whole[:-1] if keep == 1 else whole[:keep])
    with pytest.raises(InputError):
        image.read(tmp_path / name)

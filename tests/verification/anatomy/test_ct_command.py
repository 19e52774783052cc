"""A phantom stored as in archives, as oblique NIfTI and as DICOM, gives the same lumen as its own file."""

import importlib.util
import json
import pathlib
import subprocess

import nibabel
import numpy as np
import pytest
from scipy.spatial import cKDTree

from anatomy import __main__ as command
from common import vtp
from common import volume as image
from data_synthetic.ct import phantom, vessel

HERE = pathlib.Path(__file__).resolve().parents[2]


def module(path):
    spec = importlib.util.spec_from_file_location(pathlib.Path(path).stem, HERE / path)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


TUBES = module("unit/data_synthetic/ct_tubes.py")
VOLUMES = module("unit/anatomy/test_ct_volumes.py")


def radius(z):
    """A throat of 0.8 mm in a tube of 1.5 mm."""
    return 1.5 - 0.35 * (1 + np.cos(np.pi * np.clip(np.abs(z - 9) / 4, 0, 1)))


@pytest.fixture(scope="module")
def scanned(tmp_path_factory):
    """Folder with the phantom's own ct.nii, its Image, the tube's direction; calcium on one side of the throat."""
    poly, direction = TUBES.tube(radius, length_mm=18.0)
    points = vtp.points(poly)
    across = np.cross(direction, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    along = points @ direction
    calcified = (np.abs(along - 9) < 3) & ((points - along[:, None] * direction) @ across > 0)
    thickness = np.where(calcified, 1.6, 1.5 - radius(along))
    kind = np.where(calcified, 3, (thickness > 0.01).astype(int)).astype(np.int32)
    for name, values in (("plaque_thickness_mm", thickness), ("plaque_type", kind)):
        vtp.add_array(poly.GetPointData(), name, values)
    settings = TUBES.settings()["phantom"]
    volume = phantom.add_noise(phantom.render(vessel.from_surface(poly, "tube"), settings), settings)
    folder = tmp_path_factory.mktemp("ct")
    image.write(volume, folder / "ct.nii", "phantom")
    volume.values = np.rint(volume.values)
    return folder, volume, direction, across


def found(folder, path, ends, name):
    """(points, arrays, document) of the lumen in a volume."""
    arguments = ["ct", str(path), "--out", str(folder / name)]
    for option, point in zip(("--inlet", "--outlet"), ends):
        arguments += [option, *(f"{x:.6f}" for x in point)]
    command.main(arguments)
    poly = vtp.read_triangles(folder / name / "lumen.vtp", "")
    data = poly.GetPointData()
    arrays = [np.array(data.GetArray(key)) for key in ("plaque_thickness_mm", "plaque_type")]
    return vtp.points(poly), arrays, json.loads((folder / name / "segmentation.json").read_text())


@pytest.fixture(scope="module")
def own(scanned):
    folder, _, direction, _ = scanned
    return found(folder, folder / "ct.nii", (0 * direction, 18 * direction), "own")


def moved(volume, turn):
    """Affine (4, 4) of the volume turned and put elsewhere, and the function that moves points with it."""
    turned, shift = VOLUMES.rotation(*turn), np.array([40.0, -180.0, 1650.0])
    affine = np.eye(4)
    affine[:3, :3] = turned * volume.spacing_mm
    affine[:3, 3] = turned @ volume.origin_mm + shift
    return affine, lambda points: np.asarray(points) @ turned.T + shift


@pytest.mark.slow
@pytest.mark.parametrize("form", ["nifti", "nifti reversed", "dicom"])
def test_the_same_lumen_wherever_the_volume_lies(scanned, own, form):
    folder, volume, direction, _ = scanned
    affine, move = moved(volume, (14, -9, 25))
    path, values = folder / f"{form}.nii.gz", volume.values
    if form == "dicom":
        path = folder / "series"
        VOLUMES.write_series(path, values, affine, slope=0.5, intercept=-1024.0)
    else:
        if form == "nifti reversed":
            values = values[::-1].transpose(2, 0, 1)
            flip = np.diag([-1.0, 1, 1, 1])
            flip[0, 3] = volume.values.shape[0] - 1
            affine = affine @ flip @ np.eye(4)[:, [2, 0, 1, 3]]
        nibabel.save(nibabel.Nifti1Image(values.astype(np.int16), affine), path)
    points, arrays, document = found(folder, path, move([0 * direction, 18 * direction]), form.replace(" ", "_"))
    there, _, first = own
    assert np.abs(cKDTree(points).query(move(there))[0]).max() < 0.15  # a vertex is as near as the mesh is fine
    assert document["blood_hu"] == pytest.approx(first["blood_hu"], abs=1)
    radii = [np.array(d["branches"][0]["equivalent_radius_mm"]) for d in (document, first)]
    s = [np.array(d["branches"][0]["s_mm"]) for d in (document, first)]
    assert np.interp(s[1], s[0], radii[0]) == pytest.approx(radii[1], abs=0.02)
    assert [w["code"] for w in document["warnings"]] == [w["code"] for w in first["warnings"]]


def test_calcium_is_found_where_it_is_and_warned_of(scanned, own):
    _, _, direction, across = scanned
    points, (thickness, kind), document = own
    along = points @ direction
    side = (points - along[:, None] * direction) @ across / np.maximum(radius(along), 0.1)
    sheet = (np.abs(along - 9) < 2) & (side > 0.5)
    assert (kind[sheet] == 3).mean() > 0.95
    assert np.median(thickness[sheet & (kind == 3)]) == pytest.approx(1.6, abs=0.3)
    elsewhere = (np.abs(along - 9) > 4.5) | (side < -0.5)
    assert (kind[elsewhere] != 3).all()
    wall = elsewhere & (along > 0.5) & (along < 17.5)
    assert np.isnan(thickness[wall]).all()
    assert "calcium_or_metal" in [w["code"] for w in document["warnings"]]


def test_what_ct_does_not_know_is_derived_from_the_narrowing(scanned, own, binary):
    folder, _, direction, across = scanned
    call = [binary("lumen"), "process", folder / "own" / "lumen.vtp", "--inlet", "0,0,0", "--out", folder / "anatomy"]
    subprocess.run(call, check=True, capture_output=True)
    poly = vtp.read_triangles(folder / "anatomy" / "lumen.vtp", "")
    points, data = vtp.points(poly), poly.GetPointData()
    thickness = np.array(data.GetArray("plaque_thickness_mm"))
    kind = np.array(data.GetArray("plaque_type"))
    assert np.isfinite(thickness).all()
    along = points @ direction
    side = (points - along[:, None] * direction) @ across / np.maximum(radius(along), 0.1)
    throat = np.abs(along - 9) < 1
    assert (kind[throat & (side > 0.6)] == 3).mean() > 0.9
    soft = throat & (side < -0.6)
    assert (kind[soft] == 1).all() and thickness[soft].mean() == pytest.approx(0.6, abs=0.2)

"""Limits of the readers of surfaces and masks: plausible files just within a limit, and the messages for files beyond
it."""

import gzip

import masks
import numpy as np
import pytest


def capped_tube(path, around, radius=1.5, length=12.0):
    """ASCII PLY of a straight tube whose ends are one polygon each, as modelling programs fill them."""
    z = np.linspace(0, length, 41)
    angle = 2 * np.pi * np.arange(around) / around
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    points = [f"{x:.6f} {y:.6f} {height:.6f}" for height in z for x, y in ring]
    faces = []
    for k in range(len(z) - 1):
        for i in range(around):
            a, b = k * around + i, k * around + (i + 1) % around
            faces += [f"3 {a} {b} {b + around}", f"3 {a} {b + around} {a + around}"]
    last = (len(z) - 1) * around
    faces.append(" ".join(map(str, [around, *range(around)[::-1]])))
    faces.append(" ".join(map(str, [around, *range(last, last + around)])))
    head = ["ply", "format ascii 1.0", *["comment of the program that wrote it"] * 1200]
    head += [f"element vertex {len(points)}", *(f"property float {x}" for x in "xyz"), f"element face {len(faces)}"]
    path.write_text("\n".join([*head, "property list int int vertex_indices", "end_header", *points, *faces]) + "\n")
    return path


def test_polygons_of_255_corners(lumen, tmp_path):
    """VTK counts the corners of a polygon in one byte, so it would read 256 as 0."""
    done = lumen(capped_tube(tmp_path / "tube.ply", 255), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    done = lumen(capped_tube(tmp_path / "tube.ply", 256), tmp_path / "other")
    assert done.returncode == 2 and "256 numbers in one list" in done.stderr and "triangulate" in done.stderr


def drawn(shape=(82, 50, 24), spacing=0.4, radius=1.6, ends=((15, 20, 11), (66, 30, 12))):
    """(labels, matrix) of one straight vessel."""
    matrix = masks.affine([spacing] * 3)
    a, b = (spacing * np.array(end, float) for end in ends)
    return masks.capsules(masks.voxels(shape, matrix), [(a, b, radius, radius)]).astype(int), matrix


def taken(lumen, mask, out, *options):
    done = lumen(mask, out, *options)
    assert done.returncode == 0, done.stderr


def test_a_long_header_of_3d_slicer_is_read(lumen, tmp_path):
    """The header of a segmentation with a hundred segments has over a thousand lines, some of thousands of
    characters."""
    path = masks.nrrd(tmp_path / "mask.seg.nrrd", *drawn())
    head, voxels = path.read_bytes().split(b"\n\n", 1)
    keys = [f"Segment{k}_{name}:=value".encode() for k in range(120) for name in ("Color", "Extent", "ID", "Name")]
    more = [*keys * 3, b"Segmentation_ConversionParameters:=" + 9000 * b"x"]
    path.write_bytes(b"\n".join([head, *more]) + b"\n\n" + voxels)
    taken(lumen, path, tmp_path / "out")
    path.write_bytes(b"\n".join([head, b"Segment\0"]) + b"\n\n" + voxels)
    done = lumen(path, tmp_path / "other")
    assert done.returncode == 2 and "a control character" in done.stderr


def test_overlapping_segments_of_3d_slicer_are_refused_with_their_remedy(lumen, tmp_path):
    path = masks.nrrd(tmp_path / "mask.seg.nrrd", *drawn())
    whole = path.read_bytes().replace(b"dimension: 3", b"dimension: 4").replace(b"sizes: ", b"sizes: 2 ")
    path.write_bytes(whole.replace(b"space directions: ", b"space directions: none "))
    done = lumen(path, tmp_path / "out")
    assert done.returncode == 2 and "not three-dimensional" in done.stderr and "labelmap" in done.stderr


def test_a_volume_of_many_slices_is_read(lumen, tmp_path):
    """A micro-CT has 9000 slices. A header with more than 65535 is damaged."""
    labels, matrix = drawn((9000, 14, 14), 0.4, 1.4, ((4000, 7, 7), (4040, 7, 7)))
    for name in (".nii.gz", ".nrrd"):
        taken(lumen, masks.WRITERS[name](tmp_path / f"mask{name}", labels, matrix), tmp_path / f"out{name}")
    whole = (tmp_path / "mask.nrrd").read_bytes()
    (tmp_path / "mask.nrrd").write_bytes(whole.replace(b"sizes: 9000", b"sizes: 65536"))
    done = lumen(tmp_path / "mask.nrrd", tmp_path / "other")
    assert done.returncode == 2 and "65535 along an axis" in done.stderr


@pytest.mark.slow
def test_an_empty_volume_packs_as_well_as_it_can(lumen, tmp_path):
    """A short vessel in a large image compresses very well, nearly by deflate's limit of 1032 to 1."""
    labels, matrix = drawn((280, 260, 160))
    mask = masks.nifti(tmp_path / "mask.nii.gz", labels, matrix)
    assert 2 * labels.size > 850 * mask.stat().st_size
    taken(lumen, mask, tmp_path / "out")
    whole = gzip.open(mask).read()
    mask.write_bytes(gzip.compress(whole[:2000]))  # a valid gzip file, but with too few voxels
    done = lumen(mask, tmp_path / "other")
    assert done.returncode == 2 and "the header promises" in done.stderr


def test_voxels_of_a_tenth_of_a_millimetre_in_metres(lumen, tmp_path):
    """The volume of a voxel is 1e-12 cubic metres, which is plausible. Voxels without a volume are refused."""
    labels, matrix = drawn((90, 60, 44), 0.1, 1.2, ((20, 28, 22), (70, 30, 22)))
    small = np.diag([1e-3, 1e-3, 1e-3, 1]) @ matrix
    taken(lumen, masks.nrrd(tmp_path / "mask.nrrd", labels, small), tmp_path / "out", "--units", "m")
    flat = matrix.copy()
    flat[:3, 2] = flat[:3, 1]
    done = lumen(masks.nrrd(tmp_path / "mask.nrrd", labels, flat), tmp_path / "other")
    assert done.returncode == 2 and "no volume" in done.stderr


def test_a_mask_cropped_to_its_vessel(lumen, tmp_path):
    """A straight vessel fills pi / 4 of its bounding box, which is accepted. A label that fills more than nine tenths
    of the image is refused."""
    across = np.hypot(*np.meshgrid(*2 * [np.arange(-5, 6)])) < 5.6
    labels = np.repeat(across[None].astype(int), 60, axis=0)
    assert 0.75 < labels.mean() < 0.9
    taken(lumen, masks.nifti(tmp_path / "mask.nii", labels, masks.affine([0.3] * 3)), tmp_path / "out")
    filled = np.ones_like(labels)
    filled[:3] = 0  # 95 %
    done = lumen(masks.nifti(tmp_path / "mask.nii", filled, masks.affine([0.3] * 3)), tmp_path / "other")
    assert done.returncode == 2 and "fills the image" in done.stderr and "--label" in done.stderr


def test_a_spur_of_the_segmentation_is_no_lost_narrowing(lumen, tmp_path):
    """A thread of one voxel ends in a lump of 2 x 2 x 2 voxels. The lump's surface is separate, and is dropped."""
    labels, matrix = drawn((206, 50, 24), ends=((15, 20, 11), (190, 20, 11)))
    labels[40, 22:34, 11] = 1
    labels[40:42, 34:36, 11:13] = 1
    taken(lumen, masks.nifti(tmp_path / "mask.nii", labels, matrix), tmp_path / "out")


def test_a_coordinate_that_is_no_number_is_named(lumen, tmp_path):
    corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9.0]])
    corners[3, 1] = np.nan
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    rows = [np.zeros(3, "<f4").tobytes() + corners[face].astype("<f4").tobytes() + b"\0\0" for face in faces]
    (tmp_path / "one.stl").write_bytes(bytes(80) + np.int32(len(faces)).tobytes() + b"".join(rows))
    done = lumen(tmp_path / "one.stl", tmp_path / "out")
    assert done.returncode == 2 and "not a finite number" in done.stderr and "at 0, nan, 9" in done.stderr


def test_what_is_no_mask_is_named_with_its_voxel(lumen, tmp_path):
    labels, matrix = drawn()
    path = masks.nrrd(tmp_path / "mask.nrrd", labels, matrix)
    values = labels.astype("<f4")
    values[3, 2, 1] = 0.5
    head = path.read_bytes().split(b"\n\n", 1)[0].replace(b"type: short", b"type: float")
    path.write_bytes(head + b"\n\n" + values.tobytes(order="F"))
    done = lumen(path, tmp_path / "out")
    assert done.returncode == 2 and "0.500000 at voxel 3, 2, 1" in done.stderr and "labelmap" in done.stderr


@pytest.mark.parametrize("radius", [0.45, 5.0])
def test_a_thin_branch_and_an_ectatic_artery_are_of_plausible_scale(lumen, tmp_path, radius):
    path = capped_tube(tmp_path / "tube.ply", 48, radius, 14 * max(radius, 1))
    taken(lumen, path, tmp_path / "out")

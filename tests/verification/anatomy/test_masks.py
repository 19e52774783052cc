"""Labelled masks of known vessels: every format and orientation, the surface's bias, and what must be refused."""

import csv
import json

import lofts
import masks
import numpy as np
import pytest
import surfaces

TURN = np.array([[np.cos(0.4), -np.sin(0.4), 0], [np.sin(0.4), np.cos(0.4), 0], [0, 0, 1.0]])


def vessel(matrix, shape, ends=((15, 20, 11), (66, 30, 12)), radii=(1.6, 1.3)):
    """(labels, start, end) of a straight cone between two voxel indices; start and end are points in mm."""
    a, b = (matrix[:3, :3] @ np.array(index) + matrix[:3, 3] for index in ends)
    return masks.capsules(masks.voxels(shape, matrix), [(a, b, *radii)]).astype(int), a, b


def measured(out, a, b, radii):
    """(distances from the axis in mm, areas over the true area) of the sections away from the ends."""
    with (out / "sections.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["flag"] == "ok"]
    x = np.array([[float(row[k]) for k in ("x_mm", "y_mm", "z_mm")] for row in rows])
    length = np.linalg.norm(b - a)
    along = (x - a) @ (b - a) / length
    off = np.linalg.norm(x - a - along[:, None] * (b - a) / length, axis=1)
    radius = radii[0] + (radii[1] - radii[0]) * along / length
    return off, np.array([float(row["area_mm2"]) for row in rows]) / (np.pi * radius**2)


@pytest.mark.parametrize("hand", [1, -1], ids=["right-handed", "left-handed"])
@pytest.mark.parametrize("suffix", masks.WRITERS)
def test_formats_and_orientations(lumen, tmp_path, suffix, hand):
    matrix = masks.affine([0.35, 0.4, 0.5], TURN @ np.diag([1, 1, hand]), [-5, 7, -3])
    labels, a, b = vessel(matrix, (82, 50, 24))
    done = lumen(masks.WRITERS[suffix](tmp_path / f"mask{suffix}", 3 * labels, matrix), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    off, ratio = measured(tmp_path / "out", a, b, (1.6, 1.3))
    assert off.max() < 0.1  # a quarter of a voxel; a wrong origin, order or sign gives millimetres
    assert abs(ratio.mean() - 1) < 0.03 and ratio.std() < 0.04
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    assert "normals turned outward" not in [repair["what"] for repair in summary["repairs"]]


OBLIQUE = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]


@pytest.mark.parametrize("hand", [1, -1])
@pytest.mark.parametrize("form", ["qform", "sform before another qform"])
def test_nifti_forms(lumen, tmp_path, form, hand):
    """Slices of 0.8 mm lie obliquely, by the qform or by an sform. An sform counts even if there is another qform."""
    matrix = masks.affine([0.35, 0.35, 0.8], OBLIQUE @ np.diag([1, 1, hand]), [-50, 17, -33])
    labels, a, b = vessel(matrix, (82, 56, 20), ((12, 20, 8), (66, 36, 11)))
    options = {"qform": matrix, "use_sform": False}
    if form != "qform":
        options = {"qform": masks.affine([0.35, 0.35, 0.8], OBLIQUE, [9, 9, 9])}
    done = lumen(masks.nifti(tmp_path / "mask.nii", labels, matrix, **options), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    off, ratio = measured(tmp_path / "out", a, b, (1.6, 1.3))
    assert off.max() < 0.2  # a quarter of the longest voxel edge
    assert abs(ratio.mean() - 1) < 0.05 and "border" not in done.stderr


def test_a_lumen_cut_along_by_the_border_is_said(lumen, tmp_path):
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 24), ((15, 20, 2), (66, 20, 2)))
    assert lumen(masks.nifti(tmp_path / "mask.nii", labels, matrix), tmp_path / "out").returncode == 0
    repairs = json.loads((tmp_path / "out" / "anatomy.json").read_text())["repairs"]
    assert ("lumen cut by the image's border", labels[:, :, 0].sum()) in [(r["what"], r["count"]) for r in repairs]


def test_a_lumen_of_one_voxel_is_refused(lumen, tmp_path):
    labels = np.zeros((60, 20, 20), int)
    labels[10:50, 9, 9] = 1
    done = lumen(masks.nifti(tmp_path / "mask.nii", labels, masks.affine([0.4] * 3)), tmp_path / "out")
    assert done.returncode == 2 and "too thin for the mask's voxels" in done.stderr and "mask.nii" in done.stderr


@pytest.mark.parametrize("voxels", [1.25, 1.5, 1.75, 2.5])
def test_a_lumen_of_few_voxels_is_said_with_its_place(lumen, tmp_path, voxels):
    matrix = masks.affine([0.5] * 3)
    labels, a, b = vessel(matrix, (62, 36, 38), ((9.3, 12.1, 12.7), (52.2, 23.4, 24.9)), (0.5 * voxels,) * 2)
    done = lumen(masks.nrrd(tmp_path / "mask.nrrd", labels, matrix), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    off, ratio = measured(tmp_path / "out", a, b, (0.5 * voxels,) * 2)
    assert len(ratio) > 20 and abs(ratio.mean() - 1) < 0.1 and off.max() < 0.25
    warned = "lumen: warning: lumen of few voxels" in done.stderr
    assert warned or (voxels > 2 and np.abs(ratio - 1).max() < 0.2)  # never silently wrong
    if voxels < 2:
        said = float(done.stderr.split("the narrowest ")[1].split(" voxels")[0])
        assert said == pytest.approx(voxels * np.sqrt(ratio.min()), rel=0.02)


def test_few_voxels_at_the_end_of_a_healthy_vessel_are_noted(lumen, tmp_path):
    """The radius falls from 1.6 to 0.9 mm: below two voxels of 0.5 mm over the last few mm, but without a narrowing."""
    matrix = masks.affine([0.5] * 3)
    labels, *_ = vessel(matrix, (122, 36, 38), ((10.3, 15.1, 16.7), (110.2, 19.4, 20.9)), (1.6, 0.9))
    done = lumen(masks.nrrd(tmp_path / "mask.nrrd", labels, matrix), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    (note,) = [one for one in summary["repairs"] if one["what"] == "lumen of few voxels"]
    assert all(lesion["mla_error_percent"] == 0 for lesion in summary["lesions"]) and not note["warning"]
    assert "warning: lumen of few voxels" not in done.stderr


@pytest.mark.parametrize(
    "grid, voxels, percent",
    [(0.35, 1.35, 50), (0.35, 1.75, 25), (0.2, 2.8, 0), (None, 1.6, 0)],
    ids=["lost", "coarse", "fine", "no grid"],
)
def test_a_surface_of_few_voxels_says_its_error(process, tmp_path, grid, voxels, percent):
    """The surface file does not say that it was contoured from voxels, but the grid shows. The same throat without a
    grid has no such error."""
    throat = 0.35 * voxels if grid is None else grid * voxels
    radius = lofts.narrowed(1.5, 100 * (1 - throat / 1.5), 12, 8)
    points, triangles = surfaces.tube(surfaces.arc(0.05), radius, 24, edge=0.25)
    if grid:
        points, triangles = lofts.contoured(points, triangles, grid)
    summary, _ = process(surfaces.write(tmp_path / "lumen.stl", points, triangles), tmp_path / "out")
    lesion = summary["lesions"][0]
    off = 100 * abs(lesion["mla_mm2"] / (np.pi * throat**2) - 1)
    assert lesion["mla_error_percent"] == percent and off < max(10, percent)
    said = [one["detail"] for one in summary["repairs"] if one["what"] == "lumen of few voxels"]
    assert len(said) == (grid == 0.35) and all("voxels of 0.35 mm" in text for text in said)


@pytest.mark.parametrize("radius", [1.0, 1.5])
def test_area_is_not_biased(lumen, tmp_path, radius):
    """A single Gaussian filter of the same width would lose 7 % of the area at R = 1 mm, and 3 % at R = 1.5 mm."""
    ratios = []
    for seed in range(2):
        directions = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
        matrix = masks.affine([0.35] * 3, directions, np.random.default_rng(seed).uniform(-20, 20, 3))
        labels, a, b = vessel(matrix, (62, 36, 38), ((9.3, 12.1, 12.7), (52.2, 23.4, 24.9)), (radius, radius))
        done = lumen(masks.nrrd(tmp_path / "mask.nrrd", labels, matrix), tmp_path / "out")
        assert done.returncode == 0, done.stderr
        ratios.append(measured(tmp_path / "out", a, b, (radius, radius))[1].mean())
    assert np.mean(ratios) == pytest.approx(1, abs=0.02)


def test_the_label_is_chosen(lumen, tmp_path):
    matrix = masks.affine([0.4] * 3)
    labels, a, b = vessel(matrix, (82, 50, 24))
    labels[:, :6, :] = 7  # another structure
    mask = masks.nifti(tmp_path / "mask.nii", labels, matrix)
    done = lumen(mask, tmp_path / "out")
    assert done.returncode == 2 and "several labels" in done.stderr and "7 (" in done.stderr
    assert lumen(mask, tmp_path / "out", "--label", 1).returncode == 0
    assert measured(tmp_path / "out", a, b, (1.6, 1.3))[0].mean() < 0.05
    done = lumen(mask, tmp_path / "other", "--label", 4)
    assert done.returncode == 2 and "no such label" in done.stderr


def test_background_and_images_are_no_masks(lumen, tmp_path):
    """The lumen's complement, a full image and CT values are refused. A short message says what they are."""
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 24))
    for wrong, said in (
        (1 - labels, "fills the image"),
        (0 * labels + 1, "fills the image"),
        (1000 * labels + np.arange(labels.size).reshape(labels.shape) % 700, "several labels"),
    ):
        done = lumen(masks.nifti(tmp_path / "mask.nii", wrong, matrix), tmp_path / "out")
        assert done.returncode == 2 and said in done.stderr, done.stderr
        assert done.stderr.count("error:") == 1 and len(done.stderr) < 1000
    done = lumen(masks.nifti(tmp_path / "mask.nii", labels, matrix), tmp_path / "out", "--label", 0)
    assert done.returncode == 2 and "label" in done.stderr


def test_islands_are_dropped_and_said(lumen, tmp_path):
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 24))
    labels[4:7, 4:7, 4:7] = 1
    assert lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "out").returncode == 0
    repairs = json.loads((tmp_path / "out" / "anatomy.json").read_text())["repairs"]
    assert ("islands of the mask dropped", 1) in [(r["what"], r["count"]) for r in repairs]


@pytest.mark.parametrize("inlet, x_mm", [(None, 10), ("6,8,12.5", 10), ("6,14,4.5", 8)])
def test_the_inlet_chooses_between_two_vessels_of_a_label(lumen, tmp_path, inlet, x_mm):
    """A label may hold both coronary trees. Without an inlet the larger vessel is kept."""
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 44), ((15, 20, 31), (66, 30, 32)))
    labels |= vessel(matrix, (82, 50, 44), ((15, 35, 11), (56, 35, 11)))[0]
    done = lumen(
        masks.nifti(tmp_path / "mask.nii", labels, matrix), tmp_path / "out", *(["--inlet", inlet] if inlet else [])
    )
    assert done.returncode == 0, done.stderr
    assert "warning: another vessel left out" in done.stderr and "--inlet in it chooses it" in done.stderr
    ends = json.loads((tmp_path / "out" / "anatomy.json").read_text())["ends"]
    assert (ends[0]["centre_mm"][2] > 8.5) == (x_mm == 10)


def test_divided_voxels_are_no_finer_image(lumen, tmp_path):
    """Voxels are halved to keep a throat that is lost between them. The error is still the error of whole voxels."""
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 24), radii=(0.75, 0.7))
    coarse = lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "out")
    half = masks.affine([0.2] * 3)
    halved = np.kron(labels, np.ones((2, 2, 2), int))
    fine = lumen(masks.meta(tmp_path / "half.mha", halved, half), tmp_path / "half")
    assert "voxels of the mask are divided (2)" in fine.stderr and "divided" not in coarse.stderr
    for done in (coarse, fine):
        assert "below 2 voxels of 0.4 mm in radius" in done.stderr, done.stderr


@pytest.mark.parametrize("wall, told", [(False, True), (True, False)], ids=["branches", "wall"])
def test_labels_that_one_vessel_goes_on_into_are_told(lumen, tmp_path, wall, told):
    """If each branch has a label, the given label is only a part of the lumen. A label of the wall is no lumen."""
    matrix = masks.affine([0.4] * 3)
    labels, a, b = vessel(matrix, (82, 50, 24))
    if wall:
        outer = masks.capsules(masks.voxels((82, 50, 24), matrix), [(a, b, 2.4, 2.1)]).astype(int)
        labels = np.where(labels == 1, 1, 2 * outer)
    else:
        labels[40:] *= 2
    done = lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "out", "--label", "1")
    assert done.returncode == 0, done.stderr
    assert ("warning: the lumen's label touches others: label 1 goes on into 2;" in done.stderr) == told
    if not told:
        return
    whole = lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "whole", "--label", "1,2")
    assert whole.returncode == 0 and "touches others" not in whole.stderr, whole.stderr
    lumen(masks.meta(tmp_path / "one.mha", np.minimum(labels, 1), matrix), tmp_path / "one")
    assert (tmp_path / "whole" / "lumen.vtp").read_bytes() == (tmp_path / "one" / "lumen.vtp").read_bytes()


@pytest.mark.parametrize("axis, slices", [(0, 1), (0, 3), (1, 1)])
def test_a_vessel_with_empty_slices_is_refused(lumen, tmp_path, axis, slices):
    """Otherwise the part behind the gap would be left out, and the outlet at the gap would look like a lesion."""
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 24))
    np.moveaxis(labels, axis, 0)[(48, 25)[axis] :][:slices] = 0
    done = lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "out")
    assert done.returncode == 2 and "the vessel is cut by slices without its label" in done.stderr, done.stderr
    assert f"{slices} empty, and" in done.stderr and "fill the slices" in done.stderr


@pytest.mark.parametrize("size, told", [(2, False), (3, True)])
def test_a_cavity_counts_as_lumen(lumen, tmp_path, size, told):
    """Calcium that was cut out of the label leaves a cavity. It must not be refused as a separate piece of lumen."""
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 24))
    whole = lumen(masks.meta(tmp_path / "whole.mha", labels, matrix), tmp_path / "whole")
    at = np.rint(np.mean(np.argwhere(labels), axis=0)).astype(int)
    assert labels[tuple(at)]
    labels[tuple(slice(k - 1, k - 1 + size) for k in at)] = 0
    done = lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "out")
    assert done.returncode == whole.returncode == 0, done.stderr
    assert ("warning: cavities of the mask filled" in done.stderr) == told
    assert (tmp_path / "out" / "lumen.vtp").read_bytes() == (tmp_path / "whole" / "lumen.vtp").read_bytes()


def test_a_gap_in_the_vessel_alone_is_said(lumen, tmp_path):
    """Another vessel goes through the empty slice, so it was segmented. The part behind it may be a third vessel."""
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 44), ((15, 15, 31), (66, 20, 32)))
    labels[48] = 0
    labels |= vessel(matrix, (82, 50, 44), ((15, 35, 11), (56, 35, 11)))[0]
    done = lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "out", "--inlet", "6,6,12.5")
    assert done.returncode == 0, done.stderr
    said = [line for line in done.stderr.splitlines() if "another vessel left out" in line]
    assert any("it is 0.8 from it at (19.6," in line and "fill the gap in the mask" in line for line in said), said


def test_pieces_that_touch_by_corners_are_one_vessel(lumen, tmp_path):
    """Most segmentation tools count pieces that touch by corners as one piece."""
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (82, 50, 24))
    i, j = np.meshgrid(np.arange(82), np.arange(50), indexing="ij")
    labels[i + j == 65] = 0  # the parts on both sides touch only by edges of voxels
    done = lumen(masks.meta(tmp_path / "mask.mha", labels, matrix), tmp_path / "out")
    assert done.returncode == 0 and "left out" not in done.stderr, done.stderr
    summary = json.loads((tmp_path / "out" / "anatomy.json").read_text())
    assert summary["branches"][0]["length_mm"] > 18
    assert "voxels filled where the label touches itself by corners only" in [r["what"] for r in summary["repairs"]]


def test_a_lost_throat_is_refused_with_its_place(lumen, tmp_path):
    matrix = masks.affine([0.5] * 3)
    labels, *_ = vessel(matrix, (70, 40, 24), ((10, 20, 12), (60, 20, 12)), (1.6, 1.6))
    labels[34:37] = 0
    labels[34:37, 20, 12] = 1  # one voxel wide
    done = lumen(masks.nifti(tmp_path / "mask.nii", labels, matrix), tmp_path / "out")
    assert done.returncode == 2 and "narrowing of the mask is lost" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("suffix", masks.WRITERS)
def test_broken_masks_are_refused(lumen, tmp_path, suffix):
    matrix = masks.affine([0.4] * 3)
    labels, *_ = vessel(matrix, (40, 30, 24), ((10, 15, 12), (30, 15, 12)))
    mask = masks.WRITERS[suffix](tmp_path / f"mask{suffix}", labels, matrix)
    whole = mask.read_bytes()
    for content in (whole[: len(whole) // 2], whole[:100], b"", b"not a mask"):
        mask.write_bytes(content)
        done = lumen(mask, tmp_path / "out")
        assert done.returncode == 2 and done.stderr.count("error:") == 1, done.stderr
    masks.WRITERS[suffix](mask, 0 * labels, matrix)
    done = lumen(mask, tmp_path / "out")
    assert done.returncode == 2 and "mask is empty" in done.stderr
    masks.WRITERS[suffix](mask, labels, 0.001 * np.diag([1, 1, 1, 1000]) @ matrix)
    done = lumen(mask, tmp_path / "out")
    assert done.returncode == 2 and "declare units m" in done.stderr

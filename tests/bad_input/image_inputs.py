"""Labelled masks and CT volumes that are damaged, of another kind or hostile, and unusual ones that are accepted."""

import gzip
import json
import zlib

import masks
import nibabel
import numpy as np

from input_cases import input_case, lumen, module

MATRIX = masks.affine([0.5] * 3)


def labels_of_a_tube(shape=(40, 18, 18), ends=((-3, 4.5, 4.5), (30, 4.5, 4.5)), radius=1.7):
    """Labels with 1 in a straight vessel along x that runs through the whole image, else 0."""
    return masks.capsules(masks.voxels(shape, MATRIX), [(*ends, radius, radius)]).astype(int)


def mask(path, labels=None, matrix=MATRIX):
    labels = labels_of_a_tube() if labels is None else labels
    suffix = ".nii.gz" if path.name.endswith(".nii.gz") else path.suffix
    return masks.WRITERS[suffix](path, labels, matrix)


def changed(path, old, new):
    """Replaces a text in a file, which must hold it; returns the path."""
    whole = path.read_bytes()
    assert old in whole
    path.write_bytes(whole.replace(old, new, 1))
    return path


@input_case("a mask without a label")
def _(folder):
    return lumen("check", mask(folder / "mask.nii", 0 * labels_of_a_tube()))


@input_case("a mask of two structures")
def _(folder):
    labels = labels_of_a_tube()
    labels[:, :3] = 7
    return lumen("check", mask(folder / "mask.nii", labels))


@input_case("a label that the mask does not have")
def _(folder):
    return lumen("check", mask(folder / "mask.nii"), "--label", "4")


@input_case("the CT itself in place of its mask")
def _(folder):
    labels = labels_of_a_tube()
    return lumen("check", mask(folder / "mask.nii", 400 * labels - np.arange(labels.size).reshape(labels.shape) % 90))


@input_case("a mask whose background is the label")
def _(folder):
    return lumen("check", mask(folder / "mask.nii", 1 - labels_of_a_tube(radius=0.8)))


@input_case("NIfTI that promises more voxels than it holds")
def _(folder):
    whole = mask(folder / "mask.nii").read_bytes()
    (folder / "mask.nii").write_bytes(whole[:-400])
    return lumen("check", folder / "mask.nii")


@input_case("NIfTI of 32767 voxels each way in 300 bytes")
def _(folder):
    whole = bytearray(mask(folder / "mask.nii").read_bytes()[:400])
    whole[42:48] = 3 * b"\xff\x7f"
    (folder / "mask.nii").write_bytes(whole)
    return lumen("check", folder / "mask.nii")


def compressed(folder, damage=lambda packed: packed):
    """A MetaImage whose compressed voxels were changed by `damage`."""
    path = mask(folder / "mask.mha")
    head, voxels = path.read_bytes().split(b"ElementDataFile = LOCAL\n", 1)
    packed = damage(zlib.compress(voxels))
    head += b"CompressedData = True\nCompressedDataSize = %d\nElementDataFile = LOCAL\n" % len(packed)
    path.write_bytes(head + packed)
    return path


@input_case("a compressed MetaImage with damaged voxels")
def _(folder):
    return lumen("check", compressed(folder, lambda packed: b"\0" + packed[1:]))


@input_case("a compressed MetaImage that was cut off")
def _(folder):
    return lumen("check", compressed(folder, lambda packed: packed[:-40]))


@input_case("a compressed MetaImage")
def _(folder):
    return lumen("process", compressed(folder))


@input_case("a gzip bomb in place of a mask")
def _(folder):
    (folder / "mask.nii.gz").write_bytes(gzip.compress(bytes(300_000_000), 9))
    return lumen("check", folder / "mask.nii.gz")


@input_case("NIfTI with four dimensions, a film")
def _(folder):
    film = np.stack([labels_of_a_tube()] * 2, axis=-1).astype(np.int16)
    nibabel.save(nibabel.Nifti1Image(film, MATRIX), folder / "mask.nii")
    return lumen("check", folder / "mask.nii")


@input_case("NRRD whose voxels have no size")
def _(folder):
    return lumen("check", changed(mask(folder / "mask.nrrd"), b"(0.5,0,0)", b"(0,0,0)"))


@input_case("NRRD whose voxels have a size that is not a number")
def _(folder):
    return lumen("check", changed(mask(folder / "mask.nrrd"), b"(0.5,0,0)", b"(nan,0,0)"))


@input_case("NRRD that takes its voxels from the system's files")
def _(folder):
    path = changed(mask(folder / "mask.nrrd"), b"encoding: raw\n", b"encoding: raw\ndata file: /etc/passwd\n")
    return lumen("check", path)


@input_case("NRRD that takes its voxels from a device without end")
def _(folder):
    path = changed(mask(folder / "mask.nrrd"), b"encoding: raw\n", b"encoding: raw\ndata file: /dev/zero\n")
    return lumen("check", path)


def as_text(folder, kind, beside):
    """An NRRD mask of type `kind` with its labels as text, in a file beside the header or in the same file."""
    labels = labels_of_a_tube()
    text = " ".join(map(str, labels.ravel(order="F"))) + "\n"
    head = mask(folder / "mask.nrrd", labels).read_bytes().split(b"\n\n")[0].decode()
    head = head.replace("type: short", f"type: {kind}").replace("encoding: raw", "encoding: text")
    if beside:
        (folder / "mask.txt").write_text(text)
        (folder / "mask.nhdr").write_text(f"{head}\ndata file: mask.txt\n\n")
    else:
        (folder / "mask.nrrd").write_text(f"{head}\n\n{text}")
    return folder / ("mask.nhdr" if beside else "mask.nrrd")


@input_case("NRRD with labels as text behind the header")
def _(folder):
    return lumen("check", as_text(folder, "short", beside=False))


@input_case("NRRD with labels of one byte as text in a file of their own")
def _(folder):
    return lumen("check", as_text(folder, "uchar", beside=True))


@input_case("MetaImage whose voxels are in a file that is gone")
def _(folder):
    head = mask(folder / "mask.mha").read_bytes().split(b"LOCAL\n")[0]
    (folder / "mask.mhd").write_bytes(head + b"gone.raw\n")
    return lumen("check", folder / "mask.mhd")


@input_case("MetaImage of two dimensions")
def _(folder):
    path = changed(mask(folder / "mask.mha"), b"NDims = 3", b"NDims = 2")
    return lumen("check", path)


@input_case("a lumen of one voxel")
def _(folder):
    labels = np.zeros((40, 18, 18), int)
    labels[:, 9, 9] = 1
    return lumen("check", mask(folder / "mask.nii", labels))


@input_case("a mask in metres declared as millimetres")
def _(folder):
    return lumen("check", mask(folder / "mask.nrrd", matrix=np.diag([1e-3, 1e-3, 1e-3, 1]) @ MATRIX))


def volume(path, blood=400.0, fat=-80.0, noise=8.0, affine=MATRIX, dtype=np.int16):
    """Writes a NIfTI volume in HU: a vessel along x in fat."""
    labels = masks.capsules(masks.voxels((48, 30, 30), MATRIX), [((3, 7, 7), (20, 7, 7), 1.6, 1.6)])
    values = np.where(labels, blood, fat) + noise * np.random.default_rng(1).standard_normal(labels.shape)
    nibabel.save(nibabel.Nifti1Image(values.astype(dtype), affine), path)
    return path


def ct(folder, path, inlet=(5, 7, 7), outlets=((18, 7, 7),), more=()):
    ends = ["--inlet", *inlet]
    for outlet in outlets:
        ends += ["--outlet", *outlet]
    return module("anatomy", "ct", path, *ends, *more, "--out", folder / "out")


@input_case("a CT volume that is not there")
def _(folder):
    return ct(folder, folder / "ct.nii")


@input_case("a text file in place of a CT volume")
def _(folder):
    (folder / "ct.nii").write_text("not a volume\n" * 60)
    return ct(folder, folder / "ct.nii")


@input_case("a CT volume that was cut off")
def _(folder):
    whole = volume(folder / "ct.nii.gz").read_bytes()
    (folder / "ct.nii.gz").write_bytes(whole[: len(whole) // 2])
    return ct(folder, folder / "ct.nii.gz")


@input_case("a folder without DICOM files")
def _(folder):
    (folder / "series").mkdir()
    (folder / "series" / "readme.txt").write_text("the images are elsewhere")
    return ct(folder, folder / "series")


@input_case("a CT inlet outside the volume")
def _(folder):
    return ct(folder, volume(folder / "ct.nii"), inlet=(-5, 7, 7))


@input_case("a CT inlet in the fat")
def _(folder):
    return ct(folder, volume(folder / "ct.nii"), inlet=(5, 2, 12))


@input_case("CT points of DICOM's convention with NIfTI")
def _(folder):
    path = volume(folder / "ct.nii", affine=masks.affine([0.5] * 3, origin=(-10.0, -5.0, 0.0)))
    return ct(folder, path, inlet=(5, -2, 7), outlets=((-8, -2, 7),))


@input_case("a CT vessel of one end")
def _(folder):
    return ct(folder, volume(folder / "ct.nii"), outlets=())


@input_case("a CT vessel whose ends are one point")
def _(folder):
    return ct(folder, volume(folder / "ct.nii"), outlets=((5, 7, 7),))


@input_case("a CT without contrast")
def _(folder):
    return ct(folder, volume(folder / "ct.nii", blood=-70))


@input_case("a CT whose rescale intercept is lost")
def _(folder):
    return ct(folder, volume(folder / "ct.nii", blood=1424, fat=944))


@input_case("a CT of magnetic resonance's kind, floats that are not finite")
def _(folder):
    return ct(folder, volume(folder / "ct.nii", blood=np.nan, dtype=np.float32))


@input_case("CT settings with a key of another section")
def _(folder):
    (folder / "ct.yaml").write_text("segmentation: {rings: 3}\n")
    return ct(folder, volume(folder / "ct.nii"), more=["--settings", folder / "ct.yaml"])


@input_case("CT end points that are text")
def _(folder):
    (folder / "ends.json").write_text(json.dumps({"ends": [{"centre_mm": "5, 7, 7"}, {"centre_mm": "18, 7, 7"}]}))
    return module("anatomy", "ct", volume(folder / "ct.nii"), "--ends", folder / "ends.json", "--out", folder / "out")


# Inputs that are unusual, but lumens.


@input_case("a mask with blanks and an umlaut in its name")
def _(folder):
    return lumen("process", mask(folder / "Gefäß 1.nii.gz"))


@input_case("a label of 2000 as segmentation programs number them")
def _(folder):
    return lumen("process", mask(folder / "mask.nrrd", 2000 * labels_of_a_tube()))


@input_case("a mask of a left-handed frame")
def _(folder):
    return lumen("process", mask(folder / "mask.nii", matrix=np.diag([-1, 1, 1, 1]) @ MATRIX))


@input_case("NRRD with labels as text in a file of their own")
def _(folder):
    return lumen("process", as_text(folder, "short", beside=True))


@input_case("a mask with an island beside the vessel")
def _(folder):
    labels = labels_of_a_tube()
    labels[20:22, 1:3, 1:3] = 1
    return lumen("process", mask(folder / "mask.mha", labels))


@input_case("a mask in metres, so declared")
def _(folder):
    path = mask(folder / "mask.nrrd", matrix=np.diag([1e-3, 1e-3, 1e-3, 1]) @ MATRIX)
    return lumen("process", path, "--units", "m")


@input_case("a CT volume of floats")
def _(folder):
    return ct(folder, volume(folder / "ct.nii.gz", dtype=np.float32))


@input_case("a CT volume that lies far from the origin")
def _(folder):
    matrix = masks.affine([0.5] * 3, origin=(-120.0, 80.0, 900.0))
    return ct(folder, volume(folder / "ct.nii", affine=matrix), (-115, 87, 907), ((-102, 87, 907),))

"""Labelled masks of known vessels as NIfTI, NRRD and MetaImage, written byte by byte from the formats' definitions."""

import gzip
import struct

import numpy as np
from scipy.spatial.transform import Rotation


def nifti(path, labels, affine, qform=None, use_sform=True):
    """NIfTI-1 (n+1) of labels (nx, ny, nz) with the 4 x 4 voxel-to-mm `affine` as sform; gzip by the suffix .gz.

    `qform`: another one, given as quaternion, with qfac -1 where it is left-handed; `use_sform` False: the only one.
    """
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *labels.shape, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)  # int16
    struct.pack_into("<8f", header, 76, 1, *np.linalg.norm(affine[:3, :3], axis=0), 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    struct.pack_into("<B", header, 123, 2)  # mm
    struct.pack_into("<2h", header, 252, qform is not None, use_sform)
    if qform is not None:
        turn = qform[:3, :3] / np.linalg.norm(qform[:3, :3], axis=0)
        qfac = np.sign(np.linalg.det(turn))
        quaternion = Rotation.from_matrix(turn * [1, 1, qfac]).as_quat()
        struct.pack_into("<f", header, 76, qfac)
        struct.pack_into("<6f", header, 256, *(quaternion[:3] * np.sign(quaternion[3])), *qform[:3, 3])
    if use_sform:
        struct.pack_into("<12f", header, 280, *affine[:3].ravel())
    header[344:348] = b"n+1\0"
    data = bytes(header) + labels.astype("<i2").tobytes(order="F")
    path.write_bytes(gzip.compress(data, mtime=0) if path.suffix == ".gz" else data)
    return path


def nrrd(path, labels, affine):
    """NRRD 4 with space directions and origin, raw int16."""
    columns = " ".join("(" + ",".join(f"{x:.12g}" for x in affine[:3, j]) + ")" for j in range(3))
    origin = ",".join(f"{x:.12g}" for x in affine[:3, 3])
    sizes = " ".join(map(str, labels.shape))
    header = (
        f"NRRD0004\n# test\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {sizes}\n"
        f"space directions: {columns}\nkinds: domain domain domain\nendian: little\nencoding: raw\n"
        f"space origin: ({origin})\n\n"
    )
    path.write_bytes(header.encode() + labels.astype("<i2").tobytes(order="F"))
    return path


def meta(path, labels, affine):
    """MetaImage, header and voxels in one file, with a DICOM tag and a field of ITK's as its writer keeps them."""
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    turn = " ".join(f"{x:.12g}" for x in (affine[:3, :3] / spacing).T.ravel())
    header = (
        "ObjectType = Image\nNDims = 3\n0008|0005 = ISO_IR 100\nITK_InputFilterName = NrrdImageIO\n"
        "BinaryData = True\nBinaryDataByteOrderMSB = False\n"
        f"TransformMatrix = {turn}\nOffset = {' '.join(f'{x:.12g}' for x in affine[:3, 3])}\n"
        f"ElementSpacing = {' '.join(f'{x:.12g}' for x in spacing)}\n"
        f"DimSize = {' '.join(map(str, labels.shape))}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
    )
    path.write_bytes(header.encode() + labels.astype("<i2").tobytes(order="F"))
    return path


WRITERS = {".nii": nifti, ".nii.gz": nifti, ".nrrd": nrrd, ".mha": meta}


def affine(spacing, directions=np.eye(3), origin=(0, 0, 0)):
    """4 x 4 voxel-to-mm matrix of voxel edges (3,) mm, unit columns `directions` and the first voxel's centre."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.asarray(directions) * np.asarray(spacing)
    matrix[:3, 3] = origin
    return matrix


def voxels(shape, matrix):
    """Centres (nx, ny, nz, 3) in mm of a grid's voxels."""
    index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    return index @ matrix[:3, :3].T + matrix[:3, 3]


def capsules(points, segments):
    """True where a point (..., 3) lies within a straight cone with half-ball ends (start, end, r0, r1)."""
    inside = np.zeros(points.shape[:-1], bool)
    for a, b, r0, r1 in segments:
        a, b = np.asarray(a, float), np.asarray(b, float)
        length = np.linalg.norm(b - a)
        t = (b - a) / length
        along = np.clip((points - a) @ t, 0, length)
        inside |= np.linalg.norm(points - a - along[..., None] * t, axis=-1) < r0 + (r1 - r0) * along / length
    return inside

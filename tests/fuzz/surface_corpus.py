"""Seeds and seeded mutants of the surfaces and masks that the anatomy reads; as a program it writes the seeds.

The first byte of each file is the number of its suffix, as the target fuzz_surface takes it.
"""

import argparse
import pathlib
import random
import tempfile

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from fuzz_corpus import mutate_bytes, vtp_encodings

SUFFIXES = (".stl", ".vtp", ".ply", ".obj", ".nii", ".nrrd", ".mha")


def tube():
    """A closed tube of radius 1.5 mm and 12 mm length as triangles."""
    line = vtk.vtkLineSource()
    line.SetPoint2(0, 0, 12)
    wall = vtk.vtkTubeFilter()
    wall.SetInputConnection(line.GetOutputPort())
    wall.SetRadius(1.5)
    wall.SetNumberOfSides(12)
    wall.CappingOn()
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputConnection(wall.GetOutputPort())
    triangles.Update()
    return triangles.GetOutput()


def mask(kind=np.uint8):
    """The labels of a tube, 12 x 12 x 16 voxels of 0.5 mm."""
    x, y, _ = np.meshgrid(*(np.arange(n) for n in (12, 12, 16)), indexing="ij")
    inside = (np.hypot(x - 5.5, y - 5.5) < 3.4).astype(kind)
    image = vtk.vtkImageData()
    image.SetDimensions(inside.shape)
    image.SetSpacing(0.5, 0.5, 0.5)
    values = numpy_to_vtk(inside.ravel(order="F"), deep=True)
    values.SetName("labels")
    image.GetPointData().SetScalars(values)
    return image


def _written(writer, data, suffix, **switches):
    """The bytes that a VTK writer makes of the data. switches: {method of the writer: its arguments}."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / f"file{suffix}"
        writer.SetInputData(data)
        writer.SetFileName(str(file))
        for name, value in switches.items():
            getattr(writer, name)(*value)
        writer.Write()
        return file.read_bytes()


def _nrrd(image):
    """The image as an uncompressed NRRD file."""
    head = "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 12 16\nencoding: raw\n"
    head += "space directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\nkinds: domain domain domain\nspace origin: (0,0,0)\n\n"
    return head.encode() + bytes(memoryview(image.GetPointData().GetScalars()))


def seeds():
    """{name: bytes}: files that are read without a complaint, each after the byte that names its suffix."""
    surface, image = tube(), mask()
    found = {}
    for form, call in (("text", "SetFileTypeToASCII"), ("binary", "SetFileTypeToBinary")):
        found[f"{form}.stl"] = _written(vtk.vtkSTLWriter(), surface, ".stl", **{call: ()})
        found[f"{form}.ply"] = _written(vtk.vtkPLYWriter(), surface, ".ply", **{call: ()})
    found["text.obj"] = _written(vtk.vtkOBJWriter(), surface, ".obj")
    found |= {f"{name}.vtp": content for name, content in vtp_encodings(surface).items() if name.endswith("32")}
    found["mask.nii"] = _written(vtk.vtkNIFTIImageWriter(), image, ".nii")
    found["wide.nii"] = _written(vtk.vtkNIFTIImageWriter(), mask(np.int16), ".nii")
    found["mask.mha"] = _written(vtk.vtkMetaImageWriter(), image, ".mha", SetCompression=(False,))
    found["packed.mha"] = _written(vtk.vtkMetaImageWriter(), image, ".mha", SetCompression=(True,))
    found["raw.nrrd"] = _nrrd(image)
    return {name: bytes([SUFFIXES.index(pathlib.Path(name).suffix)]) + content for name, content in found.items()}


def mutants(of, count, seed):
    """Yields `count` mutants (bytes) of seeds {name: bytes}. The first byte, which names the format, stays."""
    numbers = random.Random(f"surface {seed}")
    for _ in range(count):
        content = of[numbers.choice(sorted(of))]
        yield content[:1] + mutate_bytes(content[1:], numbers)


def main():
    """Writes DIR/surface.SUFFIX/NAME, a folder for each format."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder")
    out = parser.parse_args().out
    for name, content in seeds().items():
        folder = out / f"surface{pathlib.Path(name).suffix}"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()

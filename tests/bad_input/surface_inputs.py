"""Surfaces that are damaged, of another kind or out of place, and unusual ones that are accepted as lumens."""

import gzip
import os
import struct

import numpy as np
import surfaces

from input_cases import input_case, lumen


def points_and_triangles(radius=1.5, length=14.0, edge=0.7, **options):
    """(points, triangles) of a straight capped tube along x. Lengths are in mm."""
    return surfaces.tube(surfaces.straight, lambda s: radius + 0 * s, length, edge, **options)


def tube(path, scale=1.0, **options):
    """Writes the tube of points_and_triangles to a file."""
    points, triangles = points_and_triangles(**options)
    return surfaces.write(path, points * scale, triangles)


def bytes_of(folder, suffix):
    return tube(folder / f"whole{suffix}").read_bytes()


def check_bytes(folder, name, content):
    (folder / name).write_bytes(content)
    return lumen("check", folder / name)


@input_case("a surface that is not there")
def _(folder):
    return lumen("check", folder / "none.stl")


@input_case("a folder in place of a surface")
def _(folder):
    (folder / "tube.stl").mkdir()
    return lumen("check", folder / "tube.stl")


@input_case("a link to a surface that is gone")
def _(folder):
    (folder / "tube.stl").symlink_to(folder / "gone.stl")
    return lumen("check", folder / "tube.stl")


@input_case("a link to itself")
def _(folder):
    (folder / "tube.stl").symlink_to(folder / "tube.stl")
    return lumen("check", folder / "tube.stl")


@input_case("a named pipe that nobody writes to")
def _(folder):
    os.mkfifo(folder / "tube.stl")
    return lumen("check", folder / "tube.stl")


@input_case("an empty file")
def _(folder):
    return check_bytes(folder, "tube.stl", b"")


@input_case("a web page saved as STL")
def _(folder):
    return check_bytes(folder, "tube.stl", b"<!DOCTYPE html>\n<html><body>404 Not Found</body></html>\n" * 9)


@input_case("a Git LFS pointer instead of its file")
def _(folder):
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + 64 * b"a" + b"\nsize 684\n"
    return check_bytes(folder, "tube.stl", pointer)


@input_case("a gzip-compressed STL without .gz")
def _(folder):
    return check_bytes(folder, "tube.stl", gzip.compress(bytes_of(folder, ".stl")))


@input_case("a format that is not read")
def _(folder):
    return check_bytes(folder, "tube.step", b"ISO-10303-21;\n")


@input_case("STL that says it has four thousand million triangles")
def _(folder):
    whole = bytearray(bytes_of(folder, ".stl"))
    struct.pack_into("<I", whole, 80, 2**32 - 1)
    return check_bytes(folder, "tube.stl", bytes(whole))


@input_case("text STL that was cut off")
def _(folder):
    facet = b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    return check_bytes(folder, "tube.stl", b"solid tube\n" + 30 * facet)


@input_case("PLY that says it has a thousand million points")
def _(folder):
    whole = bytes_of(folder, ".ply")
    count = whole.split(b"element vertex ")[1].split(b"\n")[0]
    return check_bytes(folder, "tube.ply", whole.replace(b"vertex " + count, b"vertex 1000000000", 1))


@input_case("PLY of points alone, a scanner's cloud")
def _(folder):
    head = (
        b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    )
    return check_bytes(folder, "tube.ply", head + b"0 0 0\n1 0 0\n0 1 0\n0 0 9\n")


@input_case("OBJ whose faces name a point that is not there")
def _(folder):
    return check_bytes(folder, "tube.obj", b"v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\nf 1 2 4\n")


@input_case("VTP that was cut off")
def _(folder):
    whole = bytes_of(folder, ".vtp")
    return check_bytes(folder, "tube.vtp", whole[: len(whole) // 2])


@input_case("VTP with XML entities that multiply")
def _(folder):
    names = "abcdefghij"
    laughs = "".join(f'<!ENTITY {b} "{9 * f"&{a};"}">' for a, b in zip(names, names[1:]))
    head = f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "lol">{laughs}]>'
    body = '<VTKFile type="PolyData" version="1.0"><PolyData><Piece NumberOfPoints="&j;"/></PolyData></VTKFile>'
    return check_bytes(folder, "tube.vtp", (head + body).encode())


@input_case("VTP that says it has 10^18 points")
def _(folder):
    whole = bytes_of(folder, ".vtp")
    count = whole.split(b'NumberOfPoints="')[1].split(b'"')[0]
    old = b'NumberOfPoints="' + count
    return check_bytes(folder, "tube.vtp", whole.replace(old, b'NumberOfPoints="' + 18 * b"9", 1))


@input_case("a surface in metres declared as millimetres")
def _(folder):
    return lumen("check", tube(folder / "tube.stl", 0.001))


@input_case("a surface in millimetres declared as metres")
def _(folder):
    return lumen("check", tube(folder / "tube.stl"), "--units", "m")


@input_case("a unit that is none of three")
def _(folder):
    return lumen("check", tube(folder / "tube.stl"), "--units", "inch")


@input_case("a coordinate that is not a number")
def _(folder):
    points, triangles = points_and_triangles()
    points[7, 1] = np.nan
    return lumen("check", surfaces.write(folder / "tube.stl", points, triangles))


@input_case("a ball, which has no ends")
def _(folder):
    points, triangles = surfaces.tree([((0, 0, 0), (0.5, 0, 0), 2.0, 2.0)], rounded=True)
    return lumen("process", surfaces.write(folder / "ball.stl", points, triangles))


@input_case("a flat sheet")
def _(folder):
    x, y = (a.ravel() for a in np.meshgrid(np.arange(20.0), np.arange(20.0)))
    a = np.array([20 * j + i for j in range(19) for i in range(19)])
    triangles = np.vstack([np.column_stack([a, a + 1, a + 20]), np.column_stack([a + 1, a + 21, a + 20])])
    return lumen("check", surfaces.write(folder / "sheet.stl", np.column_stack([x, y, 0 * x]), triangles))


@input_case("two vessels of one size side by side")
def _(folder):
    points, triangles = points_and_triangles()
    both = np.vstack([points, points + [0, 9, 0]])
    two = np.vstack([triangles, triangles + len(points)])
    return lumen("check", surfaces.write(folder / "two.stl", both, two))


@input_case("an inlet far from the vessel")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--inlet", "99,99,99")


@input_case("an inlet of two coordinates")
def _(folder):
    return lumen("check", tube(folder / "tube.stl"), "--inlet", "1,2")


@input_case("an inlet with decimal commas")
def _(folder):
    return lumen("check", tube(folder / "tube.stl"), "--inlet", "0,5,0,5,0,5")


@input_case("an inlet that is not a number")
def _(folder):
    return lumen("check", tube(folder / "tube.stl"), "--inlet", "nan,0,0")


@input_case("one point for inlet and outlet")
def _(folder):
    return lumen("check", tube(folder / "tube.stl"), "--inlet", "0,0,0", "--outlet", "0,0,0")


@input_case("a label for a surface")
def _(folder):
    return lumen("check", tube(folder / "tube.stl"), "--label", "1")


@input_case("a cap that is not there")
def _(folder):
    return lumen(
        "check", tube(folder / "tube.stl", capped=False), "--cap", folder / "in.stl", "--cap", folder / "b.stl"
    )


def cap(path, x, radius=1.5):
    """Writes a disc across the x axis as a cap file."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = np.column_stack([0 * angle + x, radius * np.cos(angle), radius * np.sin(angle)])
    k = np.arange(24)
    fan = np.column_stack([0 * k + 24, k, (k + 1) % 24])
    return surfaces.write(path, np.vstack([rim, [[x, 0, 0]]]), fan)


@input_case("a cap that lies at no opening")
def _(folder):
    caps = cap(folder / "in.stl", 0), cap(folder / "out.stl", 30)
    return lumen("check", tube(folder / "tube.stl", capped=False), "--cap", caps[0], "--cap", caps[1])


@input_case("the whole surface as its own cap")
def _(folder):
    surface = tube(folder / "tube.stl", capped=False)
    return lumen("check", surface, "--cap", surface, "--cap", surface)


@input_case("an edge length of nothing")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--edge", "0")


@input_case("an edge length that is not a number")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--edge", "nan")


@input_case("an edge length of a thousandth of a micrometre")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--edge", "1e-6")


@input_case("sections every nanometre")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--spacing", "1e-6")


@input_case("an inlet extended by a million radii")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--extend-inlet", "1e6")


@input_case("a file in place of the folder for results")
def _(folder):
    (folder / "out").write_text("mine")
    return lumen("process", tube(folder / "tube.stl"))


@input_case("an earlier state that is no anatomy.json")
def _(folder):
    (folder / "like.json").write_text('{"schema": "vci-anatomy-1", "ends": 3}')
    return lumen("process", tube(folder / "tube.stl"), "--like", folder / "like.json")


@input_case("an earlier state of another vessel")
def _(folder):
    end = {"name": "inlet", "region_id": 1, "kind": "inlet", "branch": "main", "centre_mm": [500, 0, 0]}
    (folder / "like.json").write_text('{"schema": "vci-anatomy-1", "ends": [%s]}' % str(end).replace("'", '"'))
    return lumen("process", tube(folder / "tube.stl"), "--like", folder / "like.json")


# Inputs that are unusual, but lumens.


@input_case("a surface in centimetres, so declared")
def _(folder):
    return lumen("process", tube(folder / "tube.stl", 0.1), "--units", "cm")


@input_case("a surface in metres, so declared")
def _(folder):
    return lumen("process", tube(folder / "tube.vtp", 0.001), "--units", "m")


@input_case("a surface with open ends")
def _(folder):
    return lumen("process", tube(folder / "tube.ply", capped=False))


@input_case("a surface whose normals point inward")
def _(folder):
    points, triangles = points_and_triangles()
    return lumen("process", surfaces.write(folder / "tube.obj", points, triangles[:, ::-1]))


@input_case("a name with blanks, quotes, a dollar sign and an umlaut")
def _(folder):
    return lumen("process", tube(folder / "Müller's $HOME; rm -rf `tube` %s%n\n2.stl"))


@input_case("a name that begins with a dash, behind --")
def _(folder):
    (folder / "here").mkdir()
    tube(folder / "here" / "-tube.stl")
    command = lumen("process", folder / "here" / "-tube.stl")
    return ["env", "-C", folder / "here", command[0], "process", "--out", folder / "out", "--", "-tube.stl"]


@input_case("an upper-case ending")
def _(folder):
    return lumen("process", tube(folder / "tube.stl").rename(folder / "TUBE.STL"))


@input_case("a link to a surface")
def _(folder):
    tube(folder / "tube.stl")
    (folder / "link.stl").symlink_to("tube.stl")
    return lumen("process", folder / "link.stl")


@input_case("binary STL whose header begins with solid")
def _(folder):
    whole = bytearray(bytes_of(folder, ".stl"))
    whole[:80] = b"solid made by a program".ljust(80)
    (folder / "tube.stl").write_bytes(whole)
    return lumen("process", folder / "tube.stl")


@input_case("a vessel a metre away from the origin")
def _(folder):
    points, triangles = points_and_triangles()
    return lumen("process", surfaces.write(folder / "tube.vtp", points + [700, -600, 400], triangles))


@input_case("edges of two millimetres")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--edge", "2")


@input_case("sections every twentieth of a millimetre")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--spacing", "0.05")


@input_case("sections every two millimetres")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--spacing", "2")


@input_case("an inlet extended by half a radius")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--extend-inlet", "0.5")


@input_case("an inlet extended by twenty radii")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--extend-inlet", "20")


@input_case("an end named by a point two millimetres off")
def _(folder):
    return lumen("process", tube(folder / "tube.stl"), "--inlet", "15,1,1", "--outlet", "-1,1,1")


@input_case("caps in files of their own")
def _(folder):
    caps = cap(folder / "in.stl", 14), cap(folder / "out.stl", 0)
    return lumen("process", tube(folder / "tube.stl", capped=False), "--cap", caps[0], "--cap", caps[1])


@input_case("a cap file whose rim lies in no plane")
def _(folder):
    points, triangles = points_and_triangles()
    first, last = ((triangles == len(points) - k).any(axis=1) for k in (2, 1))
    rim = np.unique(triangles[last])[:-1]
    points[rim, 0] += 0.3 * np.sin(2 * np.arctan2(points[rim, 2], points[rim, 1]))
    caps = [surfaces.write(folder / f"{k}.stl", points, triangles[at]) for k, at in enumerate((first, last))]
    return lumen("process", surfaces.write(folder / "tube.stl", points, triangles), "--cap", caps[0], "--cap", caps[1])


@input_case("a torn corner: triangles that share no points")
def _(folder):
    points, triangles = points_and_triangles()
    return lumen(
        "process",
        surfaces.write(folder / "tube.vtp", points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)),
    )


@input_case("each triangle twice")
def _(folder):
    points, triangles = points_and_triangles()
    return lumen("process", surfaces.write(folder / "tube.stl", points, np.vstack([triangles, triangles])))


@input_case("a hole of one triangle in the wall")
def _(folder):
    points, triangles = points_and_triangles()
    return lumen("process", surfaces.write(folder / "tube.stl", points, np.delete(triangles, 150, axis=0)))


@input_case("a fragment beside the vessel")
def _(folder):
    points, triangles = points_and_triangles()
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]]) + [7, 6, 0]
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]) + len(points)
    return lumen(
        "process", surfaces.write(folder / "tube.stl", np.vstack([points, corners]), np.vstack([triangles, faces]))
    )

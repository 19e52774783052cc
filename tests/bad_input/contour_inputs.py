"""Contour tables of a pull-back that are foreign, damaged or doubtful, and unusual ones that are accepted."""

import gzip

import numpy as np

from input_cases import input_case, module


def rows(frames=12, points=24, radius=1.5, step=0.5, scale=1.0, centre=4.0):
    """[(frame, x, y, z)] of round outlines 0.5 mm apart about x = centre, y = 4."""
    angle = 2 * np.pi * np.arange(points) / points
    return [
        (k, scale * (centre + radius * np.cos(a)), scale * (4 + radius * np.sin(a)), scale * step * k)
        for k in range(frames)
        for a in angle
    ]


def text(table, divider=",", head="frame,x_mm,y_mm,z_mm\n", ending="\n"):
    lines = [divider.join(f"{value:.4f}" if i else f"{value}" for i, value in enumerate(row)) for row in table]
    return head + ending.join(lines) + ending


def contours(folder, content, *options, name="lumen.csv"):
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return module("anatomy", "contours", folder / name, *options, "--out", folder / "out")


def closed(table, frame):
    """The rows of one frame, with the first row repeated at the end."""
    of_frame = [row for row in table if row[0] == frame]
    return [*of_frame, of_frame[0]]


def spots():
    """Two deposits of calcium in frame 5, 3.5 mm apart."""
    return [[row for row in rows(radius=0.2, centre=x) if row[0] == 5] for x in (2.25, 5.75)]


def calcium(folder, content):
    """`anatomy contours` of the lumen with an outer wall and with a calcium table of this content."""
    (folder / "outer.csv").write_text(text(rows(radius=2.2)))
    (folder / "calcium.csv").write_text(content)
    return contours(folder, text(rows()), "--outer-wall", folder / "outer.csv", "--calcium", folder / "calcium.csv")


@input_case("a contour table that is not there")
def _(folder):
    return module("anatomy", "contours", folder / "lumen.csv", "--out", folder / "out")


@input_case("an empty contour table")
def _(folder):
    return contours(folder, "")


@input_case("a contour table of names alone")
def _(folder):
    return contours(folder, "frame,x_mm,y_mm,z_mm\n")


@input_case("a spreadsheet in place of a contour table")
def _(folder):
    return contours(folder, b"PK\x03\x04" + bytes(range(256)) * 4)


@input_case("a compressed contour table that was cut off")
def _(folder):
    return contours(folder, gzip.compress(text(rows()).encode())[:200], name="lumen.csv.gz")


@input_case("contours with decimal commas")
def _(folder):
    return contours(folder, text(rows(), ";").replace(".", ","))


@input_case("contours of three columns")
def _(folder):
    return contours(folder, text([row[:3] for row in rows()], head="frame,x,y\n"))


@input_case("contours in image pixels")
def _(folder):
    return contours(folder, text(rows(radius=80, scale=1)))


@input_case("contours in metres declared as millimetres")
def _(folder):
    return contours(folder, "\n".join(",".join(f"{v:.7f}" for v in row) for row in rows(scale=1e-3)))


@input_case("contours in centimetres by the names of their columns, declared as millimetres")
def _(folder):
    return contours(folder, text(rows(scale=0.1), head="frame,x_cm,y_cm,z_cm\n"))


@input_case("contours in micrometres by the names of their columns")
def _(folder):
    return contours(folder, text(rows(scale=1000), head="frame,x_um,y_um,z_um\n"))


@input_case("contours of which a frame that is not there is left out")
def _(folder):
    return contours(folder, text(rows()), "--drop-frame", "99")


@input_case("contours whose columns are x, y, z, frame without names")
def _(folder):
    return contours(folder, text([(f"{x:.4f}", y, z, f) for f, x, y, z in rows()], head=""))


@input_case("contours with a second line of names")
def _(folder):
    return contours(folder, text(rows(), head="frame,x,y,z\n-,mm,mm,mm\n"))


@input_case("a contour that crosses itself")
def _(folder):
    table = rows()
    table[30], table[40] = (1, *table[40][1:]), (1, *table[30][1:])
    return contours(folder, text(table))


@input_case("contours of which one frame is listed twice")
def _(folder):
    return contours(folder, text(rows() + [row for row in rows() if row[0] == 5]))


@input_case("contours with a branch in a frame of the lumen")
def _(folder):
    lumen, branch = (closed(table, 5) for table in (rows(), rows(radius=0.5, centre=6.2)))
    return contours(folder, text([row for row in rows() if row[0] != 5] + lumen + branch))


@input_case("two deposits of calcium in one line")
def _(folder):
    return calcium(folder, text([row for spot in spots() for row in spot]))


@input_case("calcium within the lumen")
def _(folder):
    return calcium(folder, text([row for row in rows(radius=0.2) if row[0] == 5]))


@input_case("calcium with another origin than the lumen")
def _(folder):
    return calcium(folder, text(rows(radius=0.2, centre=0)))


@input_case("a contour of six points")
def _(folder):
    return contours(folder, text(rows(points=6)))


@input_case("two contours alone")
def _(folder):
    return contours(folder, text(rows(frames=2)))


@input_case("contours of which two lie at one place")
def _(folder):
    return contours(folder, text([row if row[0] != 5 else (*row[:3], 2.0) for row in rows()]))


@input_case("a contour that is not in one plane")
def _(folder):
    table = rows()
    table[60] = (*table[60][:3], table[60][3] + 0.4)
    return contours(folder, text(table))


@input_case("a contour point that is not a number")
def _(folder):
    return contours(folder, text(rows()).replace("4.0000", "nan", 1))


@input_case("a range of z from high to low")
def _(folder):
    return contours(folder, text(rows()), "--z-range", "5", "1")


@input_case("a healthy wall in words")
def _(folder):
    return contours(folder, text(rows()), "--healthy-wall", "thin")


@input_case("an outer wall of another pull-back")
def _(folder):
    (folder / "outer.csv").write_text(text([(f, x, y, z + 0.2) for f, x, y, z in rows(radius=2)]))
    return contours(folder, text(rows()), "--outer-wall", folder / "outer.csv")


@input_case("an outer wall inside the lumen")
def _(folder):
    (folder / "outer.csv").write_text(text(rows(radius=1.0)))
    return contours(folder, text(rows()), "--outer-wall", folder / "outer.csv")


@input_case("a landmark of a centreline that is not given")
def _(folder):
    (folder / "marks.csv").write_text("frame,x,y,z\n3,4,5.5,1.5\n")
    return contours(folder, text(rows()), "--landmarks", folder / "marks.csv", "--landmark-point", "1", "2", "3")


# Inputs that are unusual, but valid pull-backs.


@input_case("two deposits of calcium, numbered in a fifth column")
def _(folder):
    table = [(*row, number) for number, spot in enumerate(spots()) for row in spot]
    return calcium(folder, text(table, head="frame,x_mm,y_mm,z_mm,deposit\n"))


@input_case("two deposits of calcium, each ending on its first point")
def _(folder):
    return calcium(folder, text([row for spot in spots() for row in closed(spot, 5)]))


@input_case("contours divided by tabs, with Windows line ends and a byte-order mark")
def _(folder):
    return contours(folder, ("\ufeff" + text(rows(), "\t", ending="\r\n")).encode())


@input_case("contours with remarks and empty lines")
def _(folder):
    table = text(rows())
    return contours(folder, "# from our own program\n\n" + table.replace("\n5,", "\n# frame 5\n\n5,", 1))


@input_case("contours whose columns are named in another order")
def _(folder):
    return contours(folder, text([(z, x, y, f) for f, x, y, z in rows()], head="z_mm,x_mm,y_mm,frame\n"))


@input_case("contours of six named columns, one of words")
def _(folder):
    table = [("left main", f, 0.9, x, y, z) for f, x, y, z in rows()]
    return contours(folder, text(table, head="vessel,frame,quality,x_mm,y_mm,z_mm\n"))


@input_case("contours whose frames are out of order")
def _(folder):
    return contours(folder, text(sorted(rows(), key=lambda row: (row[0] * 7 % 12))))


@input_case("contours that run clockwise")
def _(folder):
    return contours(folder, text(sorted(rows(), key=lambda row: -np.arctan2(row[2] - 4, row[1] - 4))))


@input_case("contours whose last point is the first again")
def _(folder):
    table = rows()
    closed = [row for k in range(12) for row in [*table[24 * k : 24 * k + 24], table[24 * k]]]
    return contours(folder, text(closed))


@input_case("a compressed contour table")
def _(folder):
    return contours(folder, gzip.compress(text(rows()).encode()), name="lumen.csv.gz")


@input_case("contours with z below zero that rises from the proximal end")
def _(folder):
    return contours(folder, text([(f, x, y, z - 90) for f, x, y, z in rows()]), "--z-from", "proximal")


@input_case("contours in centimetres, so declared")
def _(folder):
    return contours(folder, text(rows(scale=0.1), head="frame,x_cm,y_cm,z_cm\n"), "--units", "cm")

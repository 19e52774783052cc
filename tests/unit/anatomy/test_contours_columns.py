"""The columns of contour tables: by their names where these are known, else frame, x, y, z."""

import numpy as np
import pytest
from contour_tables import text, tube

from anatomy.contours.reading import tables
from common.errors import InputError

ROWS = [line.split(",") for line in text(tube([1.5, 1.4, 1.5])).split()]
USUAL = "frame,x,y,z"


def found(tmp_path, head, order, divider=",", units="mm", quote="", more=()):
    """The rows read from a table with a line of names, and columns in the order of `order` (of frame, x, y, z)."""
    lines = [divider.join(f"{quote}{[*row, *more][k]}{quote}" for k in order) for row in ROWS]
    (tmp_path / "lumen.csv").write_text("\n".join([head, *lines]) + "\n")
    return tables.read_rows(tmp_path / "lumen.csv", units)


@pytest.mark.parametrize(
    "head, order",
    [
        (USUAL, (0, 1, 2, 3)),
        ("z,x,y,frame", (3, 1, 2, 0)),
        ("frame,y,x,z", (0, 2, 1, 3)),
        ("x_mm,y_mm,z_mm,Frame", (1, 2, 3, 0)),
        ("Z [mm], X [mm], Y [mm], slice", (3, 1, 2, 0)),
        ("frame_nr,z (mm),x (mm),y (mm)", (0, 3, 1, 2)),
        ("a,b,c,d", (0, 1, 2, 3)),
        ("id,x,y,z", (0, 1, 2, 3)),
        ("Time of the pull-back", (0, 1, 2, 3)),
    ],
)
def test_columns_are_read_by_their_names(tmp_path, head, order):
    """Formerly a table of z, x, y, frame was read as frame, x, y, z. The areas were those of another vessel."""
    assert found(tmp_path, head, order)[:, :4] == pytest.approx(np.array(ROWS, float))


@pytest.mark.parametrize(
    "head, said", [(USUAL, False), ("", False), ("frame_nr,z (mm),x (mm),y (mm)", False), ("Nr,U,V,W", True)]
)
def test_names_that_are_not_known_are_told(tmp_path, head, said):
    """The columns are then read in the usual order, which may not be that of the table."""
    found(tmp_path, head, (0, 1, 2, 3))
    assert bool(tables.unknown_names_warning(tmp_path / "lumen.csv")) == said


def test_a_fifth_column_may_stand_anywhere(tmp_path):
    rows = found(tmp_path, "deposit,z,y,x,frame", (4, 3, 2, 1, 0), more=[7])
    assert rows[:, :4] == pytest.approx(np.array(ROWS, float)) and (rows[:, 4] == 7).all()
    with pytest.raises(InputError, match="(?s)no column is named frame.*line 1"):
        found(tmp_path, "slice,z,y,x,deposit", (0, 3, 2, 1, 4), more=[7])
    assert found(tmp_path, "slice,x,y,z,deposit", (0, 1, 2, 3, 4), more=[7])[0, 4] == 7


@pytest.mark.parametrize(
    "head, places",
    [("frame,x,y,z,angle", (0, 1, 2, 3, 4)), ("point,frame,x,y,z", (4, 0, 1, 2, 3)), (",frame,x,y,z", (4, 0, 1, 2, 3))],
)
def test_a_fifth_column_that_numbers_no_outline_is_not_read(tmp_path, head, places):
    rows = found(tmp_path, head, places, more=[7])
    assert rows[:, :4] == pytest.approx(np.array(ROWS, float)) and (rows[:, 4] == 0).all()


@pytest.mark.parametrize(
    "head, cells, number",
    [
        ("frame,x,y,z,quality,area", "{0},{1},{2},{3},0.9,7.1", 0),
        ("id,frame,point,x_mm,y_mm,z_mm", "1,{0},3,{1},{2},{3}", 0),
        ("label,frame,x,y,z", "left main,{0},{1},{2},{3}", 0),
        ("frame;note;x;y;z;deposit", "{0};;{1};{2};{3};7", 7),
        ("frame,x,y,z,,area", "{0},{1},{2},{3},5,7.1", 0),
        ('"label" "z" "y" "x" "frame" "more"', '"left main" {3} {2} {1} {0} nan', 0),
    ],
)
def test_named_columns_are_read_from_among_others(tmp_path, head, cells, number):
    """Formerly tables with six columns, or with words in columns that are not read, were refused."""
    (tmp_path / "lumen.csv").write_text("\n".join([head, *(cells.format(*row) for row in ROWS)]) + "\n")
    rows = tables.read_rows(tmp_path / "lumen.csv", "mm")
    assert rows[:, :4] == pytest.approx(np.array(ROWS, float)) and (rows[:, 4] == number).all()
    assert tables.unknown_names_warning(tmp_path / "lumen.csv") is None


def test_what_is_read_of_several_columns_must_be_numbers_in_all_lines(tmp_path):
    lines = [",".join([*row, "0.9", "7.1"]) for row in ROWS]
    for damaged in ("23,n/a,5,1.0,0.9,7.1", "23,4,5,1.0,0.9"):
        (tmp_path / "lumen.csv").write_text("\n".join(["frame,x,y,z,quality,area", *lines, damaged]) + "\n")
        with pytest.raises(InputError, match=f"(?s)not a number.*line {len(lines) + 2}"):
            tables.read_rows(tmp_path / "lumen.csv", "mm")
    (tmp_path / "lumen.csv").write_text("\n".join(["z,y,x,frame,quality,area", lines[0][:-4], *lines]) + "\n")
    with pytest.raises(InputError, match="(?s)line 2.*a field for each name"):
        tables.read_rows(tmp_path / "lumen.csv", "mm")
    (tmp_path / "lumen.csv").write_text("\n".join(["a,b,c,d,e,f", *lines]) + "\n")
    with pytest.raises(InputError, match="(?s)not a point of a contour.*line 2.*four numbers"):
        tables.read_rows(tmp_path / "lumen.csv", "mm")


@pytest.mark.parametrize("wander, what", [(0, "one plane"), (0.01, "too few points")])
def test_columns_in_another_order_without_names_are_told(tmp_path, wander, what):
    """Each x is taken for a frame, so frames have few points. The message says that the order of the columns is the
    likely cause."""
    rows = [(float(x) + wander * float(z), y, z, frame) for frame, x, y, z in ROWS]
    (tmp_path / "lumen.csv").write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    with pytest.raises(InputError, match=f"(?s){what}.*Without names frame, x, y, z over them"):
        tables.read_outlines(tmp_path / "lumen.csv", "mm", "lumen")


@pytest.mark.parametrize("head, named", [("frame,x_cm,y_cm,z_cm", "cm"), ("frame,x,y,z [um]", "um"), (USUAL, "")])
def test_units_in_the_names_are_those_declared(tmp_path, head, named):
    assert len(found(tmp_path, head, (0, 1, 2, 3), units=named or "cm"))
    if named:
        remedy = {"cm": "--units cm", "um": "multiply x, y, z by 0.001.*--units mm"}[named]  # um cannot be declared
        with pytest.raises(InputError, match=f"(?s)state other units.*column.*{named}, declared mm.*{remedy}"):
            found(tmp_path, head, (0, 1, 2, 3))
    with pytest.raises(InputError, match="image pixels"):
        found(tmp_path, "frame,x_px,y_px,z_mm", (0, 1, 2, 3))


@pytest.mark.parametrize("divider", [",", ";", "\t", " "])
def test_quoted_fields_are_read(tmp_path, divider):
    head = divider.join(f'"{name}"' for name in ("z", "x", "y", "frame"))
    rows = found(tmp_path, head, (3, 1, 2, 0), divider, quote='"')
    assert rows[:, :4] == pytest.approx(np.array(ROWS, float))


def test_a_second_line_of_names_has_its_remedy(tmp_path):
    with pytest.raises(InputError, match="(?s)a second line of names.*line 2.*-,mm,mm,mm.*one line of names.*--units"):
        found(tmp_path, USUAL + "\n-,mm,mm,mm", (0, 1, 2, 3))
    with pytest.raises(InputError, match="(?s)not a number.*line 2"):
        found(tmp_path, USUAL + "\n3,1.5,n/a,0", (0, 1, 2, 3))

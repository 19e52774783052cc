"""Contour tables and what is made from them: reading, checks, rings and plaque."""

import gzip

import numpy as np
import pytest

from contour_tables import circle, sector, text, tube

from anatomy.contours import loft, pullback, rings, run
from anatomy.contours.reading import outlines, tables
from common import vtp
from common.errors import InputError


@pytest.mark.parametrize("separator", [",", "\t", ";", " "])
def test_reads_any_separator_with_or_without_names(tmp_path, separator):
    body = text(tube([1.5, 1.4, 1.5]), separator)
    for head in ("", separator.join(["frame", "x", "y", "z"]) + "\r\n", "# of a pull-back\n", "\ufeff"):
        path = tmp_path / "lumen.csv"
        path.write_text(head + body, encoding="utf-8")
        found = tables.read_outlines(path, "mm", "lumen")
        assert list(found) == [3, 13, 23]
        assert found[13][0] == 1.0 and len(found[13][1]) == 60


def test_reads_compressed_tables_and_other_units(tmp_path):
    scaled = {name: (z / 10, outline / 10) for name, (z, outline) in tube([1.5, 1.4, 1.5]).items()}
    path = tmp_path / "lumen.csv.gz"
    path.write_bytes(gzip.compress(text(scaled).encode()))
    found = tables.read_outlines(path, "cm", "lumen")
    assert found[13][0] == pytest.approx(1.0)
    assert outlines.area_mm2(found[13][1]) == pytest.approx(np.pi * 1.4**2, rel=0.002)


def test_outlines_run_counter_clockwise_whichever_way_they_were_drawn(table):
    found = tables.read_outlines(table(tube([1.5, 1.4, 1.5], turn=-1)), "mm", "lumen")
    assert all(outlines.area_mm2(outline) > 0 for _, outline in found.values())


def test_refuses_what_is_no_table_of_outlines(table, tmp_path):
    good = tube([1.5, 1.4, 1.5])
    eight = circle(1.5, 8)
    figure_of_eight = np.column_stack([np.sin(t := np.linspace(0, 2 * np.pi, 40, False)), np.sin(t) * np.cos(t)])
    broken = {
        "cross": ({**good, 13: (1.0, figure_of_eight)}, "crosses itself"),
        "few": ({**good, 13: (1.0, circle(1.5, 7))}, "too few points"),
        "pixels": ({name: (z, 30 * outline) for name, (z, outline) in good.items()}, "too wide"),
        "wider than any": ({**good, 13: (1.0, circle(7.6))}, "15.2 mm"),
        "speck": ({**good, 13: (1.0, circle(0.09))}, "hardly any area"),
    }
    for frames, what in broken.values():
        with pytest.raises(InputError, match=what):
            tables.read_outlines(table(frames), "mm", "lumen")
    # just within the limits: eight points, an aneurysm of 14.8 mm, a lumen of 0.2 mm
    inside = {1: (0.0, eight), 2: (1.0, circle(7.4)), 3: (2.0, circle(0.1))}
    assert len(tables.read_outlines(table(inside), "mm", "lumen")) == 3
    path = tmp_path / "words.csv"
    path.write_text("1,2,3,4\n1,2,3\n")
    with pytest.raises(InputError, match="line 2"):
        tables.read_rows(path, "mm")
    path.write_text("1,2,3,4\n1,2,3,nan\n")
    with pytest.raises(InputError, match="line 2"):
        tables.read_rows(path, "mm")
    path.write_text("1,2,3,4\n1,2,3,five\n")
    with pytest.raises(InputError, match="not a number"):
        tables.read_rows(path, "mm")


def test_points_listed_twice_are_refused(table):
    """If a frame's points were read twice, its area would be doubled and its calcium would vanish."""
    one, good = circle(1.5), tube([1.5, 1.4, 1.5])
    doubled = {
        "open": np.vstack([one, one]),
        "closed": np.vstack([one, one[:1], one]),
        "in part": np.vstack([one[:30], one[10:]]),
    }
    for outline in doubled.values():
        with pytest.raises(InputError, match="(?s)listed twice.*frame 13.*list each once"):
            tables.read_outlines(table({**good, 13: (1.0, outline)}, closed=False), "mm", "lumen")
    with pytest.raises(InputError, match="(?s)several outlines in one frame.*frame 13.*listed once"):
        tables.read_outlines(table({**good, 13: (1.0, np.vstack([one, one[:1], one]))}), "mm", "lumen")
    # Accepted: a spike without width, as outlines of pixels have, and an outline that ends one point too late.
    spike, late = np.vstack([one[:30], one[29:30] * 1.01, one[29:]]), np.vstack([one, one[:2]])
    for outline in (spike, late):
        found = tables.read_outlines(table({**good, 13: (1.0, outline)}, closed=False), "mm", "lumen")
        assert outlines.area_mm2(found[13][1]) == pytest.approx(outlines.area_mm2(one), rel=1e-3)


@pytest.mark.parametrize("closed, what", [(True, "several outlines in one frame"), (False, "two outlines in one")])
def test_a_lumen_and_a_branch_in_one_frame_are_refused(table, closed, what):
    """They almost touch. Read as one outline, the lumen would have the area of both."""
    lumen, branch = circle(1.5, start=0.0), circle(0.8, centre=(6.4, 5.0), start=np.pi)
    rows = [np.vstack([part, part[:1]]) if closed else part for part in (lumen, branch)]
    frames = {**tube([1.5, 1.4, 1.5]), 13: (1.0, np.vstack(rows))}
    with pytest.raises(InputError, match=f"(?s){what}.*frame 13.*side branches have their own table"):
        tables.read_outlines(table(frames, closed=False), "mm", "lumen")


@pytest.mark.parametrize("count", [24, 60, 400])
def test_a_lumen_at_a_branch_s_mouth_is_one_outline(table, count):
    """The outline is two circles joined by a neck of 0.6 mm, and begins at the neck."""
    angle = np.linspace(-np.pi + np.arcsin(0.3 / 0.9), np.pi - np.arcsin(0.3 / 0.9), count // 2, endpoint=False)
    lobe = np.column_stack([np.sqrt(0.9**2 - 0.3**2) + 0.9 * np.cos(angle), 0.9 * np.sin(angle)])
    frames = {**tube([1.5, 1.4, 1.5]), 13: (1.0, np.vstack([lobe, -lobe]))}
    found = tables.read_outlines(table(frames, closed=False), "mm", "lumen")
    assert len(found[13][1]) == 2 * (count // 2)


def test_the_number_of_an_outline_stands_in_all_lines_or_in_none(tmp_path):
    path = tmp_path / "words.csv"
    path.write_text("1,2,3,4,1\n1,2,3,4\n")
    with pytest.raises(InputError, match="(?s)line 2.*a fifth, the outline's number, in all lines"):
        tables.read_rows(path, "mm")


def test_frames_that_cannot_be_one_pull_back_are_refused(table):
    with pytest.raises(InputError, match="too few frames"):
        pullback.read({"lumen": table(tube([1.5, 1.4]))})
    twice = {**tube([1.5, 1.4, 1.5]), 99: (1.0, circle(1.2))}
    with pytest.raises(InputError, match="two frames at one place"):
        pullback.read({"lumen": table(twice)})
    assert len(pullback.read({"lumen": table(twice)}, drop_frames=[99]).frames) == 3
    moved = {name: (z + 0.5, outline) for name, (z, outline) in tube([1.8] * 3).items()}
    with pytest.raises(InputError, match="one frame at two places"):
        pullback.read({"lumen": table(tube([1.5] * 3)), "outer_wall": table(moved, "wall.csv")})


def test_frames_of_a_fast_catheter_and_rounded_tables_are_one_pull_back(table):
    """The catheter takes 60 frames a second at 0.5 mm/s. Tables with z rounded to two decimals belong together."""
    fast = {k: (k / 120, circle(1.5)) for k in range(3)}
    assert len(pullback.read({"lumen": table(fast)}).frames) == 3
    close = {k: (0.004 * k, circle(1.5)) for k in range(3)}
    with pytest.raises(InputError, match="(?s)two frames at one place.*drop_frames"):
        pullback.read({"lumen": table(close)})
    for shift, same in ((0.009, True), (0.011, False)):
        walls = {name: (z + shift, outline) for name, (z, outline) in tube([1.8] * 3).items()}
        files = {"lumen": table(tube([1.5] * 3)), "outer_wall": table(walls, "wall.csv")}
        if same:
            assert all(frame.outer_wall is not None for frame in pullback.read(files).frames)
        else:
            with pytest.raises(InputError, match="one frame at two places"):
                pullback.read(files)


def test_a_frame_lies_in_one_plane_but_for_rounding(table):
    path = table(tube([1.5, 1.4, 1.5]))
    lines = path.read_text().splitlines()
    for off, plane in ((0.009, True), (0.011, False)):
        frame, x, y, z = lines[70].split(",")
        path.write_text("\n".join([*lines[:70], f"{frame},{x},{y},{float(z) + off}", *lines[71:]]))
        if plane:
            assert len(tables.read_outlines(path, "mm", "lumen")) == 3
        else:
            with pytest.raises(InputError, match="(?s)do not lie in one plane.*frame 13.*1 to 1.011 mm"):
                tables.read_outlines(path, "mm", "lumen")


def test_frames_are_ordered_from_distal_to_proximal(table):
    files = {"lumen": table(tube([1.0, 1.2, 1.4, 1.6]))}
    distal = pullback.read(files)
    assert [frame.name for frame in distal.frames] == [3, 13, 23, 33]
    proximal = pullback.read(files, z_from="proximal")
    assert [frame.name for frame in proximal.frames] == [33, 23, 13, 3]
    assert [frame.name for frame in pullback.read(files, z_range_mm=(0.5, 3.5)).frames] == [13, 23, 33]


@pytest.mark.parametrize("z_from, inlet_z", [("distal", 4.0), ("proximal", 0.0)])
def test_a_straight_lumen_lies_in_the_tables_own_z(table, tmp_path, z_from, inlet_z):
    """A bump at +y and a narrowing at z = 1 stay where they are, from whichever end z rises."""
    frames = tube([1.5, 1.0, 1.5, 1.5, 1.5], centre=(0.0, 0.0))
    bump = 0.5 * np.exp(-(((circle(1, centre=(0, 0)) - (0, 1)) / 0.3) ** 2).sum(axis=1))
    frames = {name: (z, outline * (1 + bump[:, None])) for name, (z, outline) in frames.items()}
    document = run.run({"lumen": table(frames)}, tmp_path / "out", reading={"z_from": z_from})
    assert [row["z_mm"] for row in document["frames"]] == sorted((0, 1, 2, 3, 4), reverse=z_from == "proximal")
    surface = vtp.read_triangles(tmp_path / "out" / "lumen.vtp", "")
    points, triangles = vtp.points_and_triangles(surface)
    assert loft.volume_mm3(points, triangles) > 0
    region = np.array(surface.GetCellData().GetArray("region_id"))
    assert points[triangles[region == loft.INLET]][..., 2] == pytest.approx(inlet_z)
    wall = points[np.unique(triangles[region == loft.WALL])]
    away = np.hypot(*wall[:, :2].T)
    x, y, _ = wall[away.argmax()]
    assert y > 1.9 and abs(x) < 0.1
    assert wall[away.argmin(), 2] == pytest.approx(1.0)


def test_a_gap_between_frames_is_said(table):
    assert pullback.read({"lumen": table(tube([1.5] * 4, spacing=2.0))}).warnings == []
    assert "no frame between" in pullback.read({"lumen": table(tube([1.5] * 4, spacing=2.5))}).warnings[0]


def test_points_of_rings_correspond_wherever_the_outlines_begin():
    one = rings.ring_from_outline(circle(1.5, start=0.3), 90)
    other = rings.ring_from_outline(circle(1.5, start=4.1), 90)
    assert np.abs(one - other).max() < 0.001
    angle = np.arctan2(*(one[0] - (4.0, 5.0))[::-1])
    assert abs(angle) < 0.001


def test_between_frames_nothing_is_narrower_than_both(table, tmp_path):
    """Two frames are slits at a right angle. Rings halfway between their points would enclose much less."""
    angle = 2 * np.pi * np.arange(80) / 80
    slit = np.column_stack([1.8 * np.cos(angle), 0.5 * np.sin(angle)])
    frames = {1: (0.0, slit), 2: (1.0, slit), 3: (2.0, slit[:, ::-1] * [1, -1]), 4: (3.0, slit[:, ::-1] * [1, -1])}
    pull = pullback.read({"lumen": table(frames)})
    lofted = run.loft_pullback(pull, run.frame_placement.straight_placement(pull))
    around = lofted["frame_rings"].shape[1]
    areas = [
        outlines.area_mm2(ring) for ring in lofted["points"][: len(lofted["z_mm"]) * around, :2].reshape(-1, around, 2)
    ]
    assert np.array(areas) == pytest.approx(np.pi * 0.9, rel=0.001)


@pytest.mark.parametrize("first, last", [(20, 110), (150, 390), (5, 354)])
def test_calcium_counts_round_the_lumen_whatever_its_depth(table, tmp_path, first, last):
    calcium = {23: (2.0, sector(1.3, 1.5, first, last))}
    files = {"lumen": table(tube([1.5, 1.5, 1.0, 1.5, 1.5])), "outer_wall": table(tube([1.7] * 5), "wall.csv")}
    files["calcium"] = table(calcium, "calcium.csv")
    document = run.run(files, tmp_path / "out")
    arcs = [frame["calcium_arc_deg"] for frame in document["frames"]]
    assert arcs[2] == pytest.approx(last - first, abs=6) and arcs[:2] + arcs[3:] == [0, 0, 0, 0]
    shadow = any("shadow" in warning for warning in document["warnings"])
    assert shadow == (last - first > 93) or last - first == 90


def raw(parts, numbered=False, closed=False, frame=23, z=2.0):
    """Table rows of one frame with its outlines one after the other. closed: each ends with its first point again."""
    rows = []
    for number, part in enumerate(parts):
        for x, y in np.vstack([part, part[:1]]) if closed else part:
            rows.append(f"{frame},{x:.5f},{y:.5f},{z}" + f",{number}" * numbered)
    return "\n".join(rows) + "\n"


@pytest.fixture
def with_calcium(table, tmp_path):
    """with_calcium(rows) -> calcium's arc in degrees in frame 23 of a vessel of radius 1.5 mm in a wall of 2.4 mm."""

    def make(rows):
        files = {"lumen": table(tube([1.5] * 5)), "outer_wall": table(tube([2.4] * 5), "wall.csv")}
        files["calcium"] = tmp_path / "calcium.csv"
        files["calcium"].write_text(rows)
        return run.run(files, tmp_path / "out")["frames"][2]["calcium_arc_deg"]

    return make


SHEETS = [sector(1.6, 1.9, 20, 110), sector(1.6, 1.8, 200, 260)]
NODULES = [
    circle(0.25, 30, (4 + x, 6.9), start) for x, start in ((-0.5, 0.0), (0.5, np.pi))
]  # each nodule's outline begins on the side of the other


@pytest.mark.parametrize("how", [{"numbered": True}, {"closed": True}, {"numbered": True, "closed": True}])
@pytest.mark.parametrize("deposits, arc", [(SHEETS, 150), (NODULES, 30)])
def test_several_deposits_of_a_frame(with_calcium, how, deposits, arc):
    alone = [with_calcium(raw([deposit])) for deposit in deposits]
    assert with_calcium(raw(deposits, **how)) == pytest.approx(sum(alone), abs=0.1)
    assert with_calcium(raw([*deposits, deposits[0]], **how)) == pytest.approx(sum(alone), abs=0.1), "one of them twice"
    assert sum(alone) == pytest.approx(arc, abs=10)  # the points of a ring are 4.5 degrees apart, so an arc is inexact


FACING = [sector(1.8, 1.6, 110, 20), sector(1.6, 1.8, 140, 200)]  # each outline begins and ends beside the other one


@pytest.mark.parametrize(
    "deposits, what",
    [(SHEETS, "crosses itself"), (NODULES, "two outlines in one"), (FACING, "two outlines in one")],
)
def test_deposits_that_cannot_be_told_apart_are_refused(with_calcium, deposits, what):
    """The line round both nodules does not cross itself. Read as one outline, it would put calcium between them."""
    with pytest.raises(InputError, match=f"(?s){what}.*calcium.csv: calcium, frame 23.*fifth column"):
        with_calcium(raw(deposits))


def test_a_ring_of_calcium_is_one_deposit(with_calcium):
    """A ring may be two lines, with or without a step back to the first point, or a disc. A sheet may begin midway."""
    ring = np.vstack([circle(1.9), circle(1.9)[:1], circle(1.6, turn=-1), circle(1.6)[:1]])
    for rows in (raw([ring]), raw([ring], closed=True), raw([circle(1.9)])):
        assert with_calcium(rows) == pytest.approx(360, abs=0.1)
    assert with_calcium(raw([np.roll(sector(1.6, 1.75, 20, 110), 30, axis=0)])) == pytest.approx(90, abs=6)


@pytest.mark.parametrize("outside_mm, taken", [(0.29, True), (0.31, False)])
def test_calcium_outside_its_outer_wall_is_refused(with_calcium, outside_mm, taken):
    deposit = raw([sector(2.0, 2.4 + outside_mm, 20, 110)])
    if taken:
        assert with_calcium(deposit) > 80
    else:
        with pytest.raises(InputError, match="(?s)calcium runs outside the outer wall.*calcium.csv: frame 23.*0.31 mm"):
            with_calcium(deposit)


@pytest.mark.parametrize("reach, taken", [(1.45, False), (1.55, True)])
def test_calcium_within_the_lumen_is_refused(table, tmp_path, reach, taken):
    """No ray into the wall would meet it, so it would be lost. A nodule that reaches out of the lumen is fine."""
    files = {"lumen": table(tube([1.5] * 5)), "outer_wall": table(tube([1.9] * 5), "wall.csv")}
    files["calcium"] = table({23: (2.0, sector(1.1, reach, 20, 60))}, "calcium.csv")
    if taken:
        assert run.run(files, tmp_path / "out")["frames"][2]["calcium_arc_deg"] > 30
    else:
        with pytest.raises(InputError, match="(?s)calcium lies within the lumen.*frame 23.*drop_frames: .23."):
            run.run(files, tmp_path / "out")


def test_a_frame_to_leave_out_must_be_in_a_table(table):
    """Otherwise a misspelt frame would stay in. Frames outside z_range_mm, or of another table, may be named too."""
    lumen, wall = tube([1.5] * 5), {99: (9.0, circle(1.9)), **tube([1.9] * 5)}
    files = {"lumen": table(lumen), "outer_wall": table(wall, "wall.csv")}
    with pytest.raises(InputError, match="(?s)no such frame to leave out.*drop_frames.*98; the tables have 6 frames"):
        pullback.read(files, drop_frames=[23, 98])
    pull = pullback.read(files, drop_frames=[23.0, 43, 99], z_range_mm=(-0.5, 3.5))
    assert [frame.name for frame in pull.frames] == [3, 13, 33] and pull.warnings == []


def test_calcium_without_an_outer_wall_is_refused(table, tmp_path):
    files = {"lumen": table(tube([1.5] * 5)), "calcium": table({23: (2.0, sector(1.6, 1.9, 0, 90))}, "calcium.csv")}
    with pytest.raises(InputError, match="without an outer wall"):
        run.run(files, tmp_path / "out")


def test_thinned_tables_keep_their_areas(table, tmp_path):
    source = table({1: (0.0, circle(1.5, 500)), 2: (0.5, circle(1.0, 500)), 3: (1.0, circle(1.2, 500))})
    tables.write_thinned(source, tmp_path / "thin.csv", 125)
    found = tables.read_outlines(tmp_path / "thin.csv", "mm", "lumen")
    assert [len(outline) for _, outline in found.values()] == [125] * 3
    assert outlines.area_mm2(found[1][1]) == pytest.approx(np.pi * 1.5**2, rel=0.0005)


@pytest.mark.parametrize("how", [{"numbered": True}, {"closed": True}])
def test_thinned_tables_keep_several_outlines(tmp_path, how):
    (tmp_path / "calcium.csv").write_text(raw(SHEETS, **how))
    tables.write_thinned(tmp_path / "calcium.csv", tmp_path / "thin.csv", 40)
    (several,) = (found[1] for found in tables.read_regions(tmp_path / "thin.csv", "mm", "calcium").values())
    assert [len(outline) for outline in several] == [40, 40]
    for outline, sheet in zip(several, SHEETS):
        assert outlines.area_mm2(outline) == pytest.approx(abs(outlines.area_mm2(sheet)), rel=0.04)

"""Side branches cut off close behind their parent's wall: outlets as CT trees have them."""

import json

import pytest
import surfaces

MAIN = ((0, 0, 0), (24, 0, 0), 2.0, 1.8)


def with_stub(path, length, radius=1.0):
    """A vessel with a side branch that stands out of its wall (radius 1.9 mm there) by `length` mm."""
    stub = ((12, 0, 0), (12, 1.9 + length, 0), radius, radius)
    return surfaces.write(path, *surfaces.tree([MAIN, stub], spacing=0.2, reach=1.3))


@pytest.mark.parametrize("length", [2.0, 1.0, 0.5])
def test_a_stub_is_an_outlet(process, tmp_path, length):
    summary, rows = process(with_stub(tmp_path / "stub.vtp", length), tmp_path / "out", "--inlet", "0,0,0")
    assert [end["name"] for end in summary["ends"]] == ["inlet", "outlet1", "outlet2"]
    side = summary["branches"][1]
    assert side["parent"] == "main" and side["s_on_parent_mm"] == pytest.approx(12, abs=0.3)
    assert side["length_mm"] == pytest.approx(1.9 + length, abs=0.1)  # from the parent's axis
    assert summary["ends"][2]["diameter_mm"] == pytest.approx(2, abs=0.1)
    assert [row for row in rows if row["branch"] == "side1"]
    assert not [lesion for lesion in summary["lesions"] if lesion["branch"] == "side1"]


def test_a_face_of_the_wall_is_no_branch(lumen, tmp_path):
    """An opening flush with the wall, as a false end is."""
    done = lumen(with_stub(tmp_path / "flush.vtp", 0.1), tmp_path / "out")
    assert done.returncode == 2
    assert "an end lies in the wall of another vessel" in done.stderr and "name the ends" in done.stderr
    assert not (tmp_path / "out" / "anatomy.json").exists()


@pytest.mark.parametrize("out, told", [(2.6, 1), (4.5, 0)], ids=["short", "longer"])
@pytest.mark.parametrize("lean", [-3, 0, 3])
def test_a_closed_stub_is_told_or_an_end_whichever_way_it_leans(lumen, tmp_path, lean, out, told):
    """It stands out by little in distance along the surface from the end that it leans towards."""
    main, stub = ((0, 0, 0), (24, 0, 0), 1.5, 1.3), ((12, 0, 0), (12 + lean, out, 0), 0.7, 0.7)
    surface = surfaces.write(tmp_path / "stub.vtp", *surfaces.tree([main, stub], inner=(1,)))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("warning: stub left closed") == told
    assert len(json.loads((tmp_path / "out" / "anatomy.json").read_text())["ends"]) == 3 - told


def test_a_dilatation_is_no_stub(lumen, tmp_path):
    sac = ((12, 0, 0), (12, 0.7, 0), 1.6, 1.6)
    surface = surfaces.write(tmp_path / "sac.vtp", *surfaces.tree([((0, 0, 0), (24, 0, 0), 1.5, 1.3), sac], inner=(1,)))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 0 and "left closed" not in done.stderr

"""Side branches that are cut off close behind their parent's wall, as in trees from CT."""

import json

import numpy as np
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
    """The opening is flush with the wall, as a false end would be."""
    done = lumen(with_stub(tmp_path / "flush.vtp", 0.1), tmp_path / "out")
    assert done.returncode == 2
    assert "an end lies in the wall of another vessel" in done.stderr and "name the ends" in done.stderr
    assert not (tmp_path / "out" / "anatomy.json").exists()


@pytest.mark.parametrize("out, told", [(2.6, 1), (4.5, 0)], ids=["short", "longer"])
@pytest.mark.parametrize("lean", [-3, 0, 3])
def test_a_closed_stub_is_told_or_an_end_whichever_way_it_leans(lumen, tmp_path, lean, out, told):
    """A stub hardly stands out in the distance along the surface from the end that it leans towards. So the distance
    from the other end counts too."""
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


def fork(out):
    """A stem of radius 1.75 and two branches of 1.3, `out` mm long, closed by balls."""
    branches = [((12, 0, 0), (12 + out, sign * 0.6 * out, 0), 1.3, 1.25) for sign in (1, -1)]
    return surfaces.tree([((0, 0, 0), (12, 0, 0), 1.75, 1.75), *branches], rounded=True)


def short_left_main(length):
    """Left main of radius 2.2 with two branches, of radii 1.75 and 1.5 that taper to 1.35 and 1.2; closed by balls."""
    ends = (length + 24, 12, 3), (length + 9, -18, -2)
    branches = [((length, 0, 0), ends[0], 1.75, 1.35), ((length, 0, 0), ends[1], 1.5, 1.2)]
    return surfaces.tree([((0, 0, 0), (length, 0, 0), 2.2, 2.2), *branches], rounded=True)


@pytest.mark.slow
@pytest.mark.parametrize("length", [2.0, 3.0])
def test_a_left_main_shorter_than_wide_is_the_inlet_once_named(lumen, tmp_path, length):
    """The left main counts as a stub. Without its name, the largest of the other ends would become the inlet."""
    surface = surfaces.write(tmp_path / "left.vtp", *short_left_main(length))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 2 and "a closed stub is wider than every end" in done.stderr
    assert "--inlet" in done.stderr and not (tmp_path / "out" / "anatomy.json").exists()
    done = lumen(surface, tmp_path / "named", "--inlet", "-2,0,0")
    assert done.returncode == 0, done.stderr
    ends = json.loads((tmp_path / "named" / "anatomy.json").read_text())["ends"]
    assert [end["name"] for end in ends] == ["inlet", "outlet1", "outlet2"]
    assert ends[0]["diameter_mm"] == pytest.approx(4.4, abs=0.2) and ends[0]["centre_mm"][0] < length + 1


@pytest.mark.slow
def test_two_tips_of_one_wide_dome_are_one_end(lumen, tmp_path):
    """The dome of a left main is wider than the mean vessel and has two tips. Formerly it was cut at one tip, and then
    the other tip was not found."""
    stem, ends = ((0, 0, 0), (5, 0, 0), 2.25, 2.25), ((45, 18, 3), (25, -35, -2))
    branches = [((5, 0, 0), end, 1.0, 0.7) for end in ends] + [((25, 9, 1.5), (35, -6, 8), 0.8, 0.7)]
    surface = surfaces.write(tmp_path / "left.vtp", *surfaces.tree([stem, *branches], rounded=True))
    done = lumen(surface, tmp_path / "out", "--inlet", "0,0,0")
    assert done.returncode == 0, done.stderr
    ends = json.loads((tmp_path / "out" / "anatomy.json").read_text())["ends"]
    assert len(ends) == 4 and ends[0]["diameter_mm"] == pytest.approx(4.5, abs=0.1)


@pytest.mark.slow
def test_a_left_main_longer_than_wide_is_the_inlet(lumen, tmp_path):
    done = lumen(surfaces.write(tmp_path / "left.vtp", *short_left_main(7.0)), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    ends = json.loads((tmp_path / "out" / "anatomy.json").read_text())["ends"]
    assert ends[0]["diameter_mm"] == pytest.approx(4.4, abs=0.2) and ends[0]["centre_mm"][0] < 1


def test_an_occluded_branch_explains_the_step_of_the_vessel_that_goes_on(lumen, tmp_path):
    """A left main of 4.5 mm, the stump of an occluded branch of 3.6 mm, and a vessel of 3.2 mm with a lesion of 40 %.
    The step to .71 of the diameter is deeper than at a fork into two equal branches. At the stump's mouth sections are
    wider than the left main."""
    stem, stump = ((0, 0, 0), (10, 0, 0), 2.25, 2.25), ((10, 0, 0), (13, 3, 0), 1.8, 1.8)
    along = np.array([0, 9, 12, 15, 45.0])[:, None] * (0.9, -np.sqrt(0.19), 0) + (10, 0, 0)
    radii = [1.6, 1.6, 0.96, 1.6, 1.5]
    vessel = [(along[k], along[k + 1], radii[k], radii[k + 1]) for k in range(4)]
    surface = surfaces.write(tmp_path / "left.vtp", *surfaces.tree([stem, stump, *vessel], inner=range(5)))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 0 and "stub left closed" in done.stderr
    assert "reference steps down where no branch leaves" in done.stderr
    (lesion,) = json.loads((tmp_path / "out" / "anatomy.json").read_text())["lesions"]
    assert lesion["diameter_stenosis_percent"] == pytest.approx(40, abs=2)
    assert lesion["s_mla_mm"] == pytest.approx(22, abs=1)


def test_an_inlet_named_at_an_end_leaves_a_stub_closed(lumen, tmp_path):
    """The inlet's point is within reach of an end and of the stub, but nearer to the end."""
    main, stub = ((0, 0, 0), (24, 0, 0), 1.5, 1.3), ((3, 0, 0), (3, 2.6, 0), 0.9, 0.9)
    surface = surfaces.write(tmp_path / "stub.vtp", *surfaces.tree([main, stub], inner=(1,)))
    done = lumen(surface, tmp_path / "out", "--inlet", "0,0,0")
    assert done.returncode == 0, done.stderr
    assert len(json.loads((tmp_path / "out" / "anatomy.json").read_text())["ends"]) == 2


@pytest.mark.parametrize("out", [3, 4])
def test_a_fork_cut_close_behind_it_loses_no_outlet_in_silence(lumen, tmp_path, out):
    """Once one tip is cut flat, the other tip lies beyond all ends. This is refused."""
    done = lumen(surfaces.write(tmp_path / "fork.vtp", *fork(out)), tmp_path / "out")
    assert done.returncode == 2 and "the lumen goes on beyond its ends" in done.stderr


def test_a_fork_cut_farther_behind_it_has_two_outlets(lumen, tmp_path):
    done = lumen(surfaces.write(tmp_path / "fork.vtp", *fork(6)), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    ends = json.loads((tmp_path / "out" / "anatomy.json").read_text())["ends"]
    assert [end["diameter_mm"] for end in ends[1:]] == [pytest.approx(2.5, abs=0.1)] * 2

"""Shapes that are hard for the anatomy: narrow forks, ends side by side, thin branches, throats, hairpins, rings."""

import csv
import json

import numpy as np
import pytest
import surfaces


@pytest.fixture
def measured(lumen, tmp_path):
    """measured(surface, name, *options) -> (CompletedProcess, summary or None, rows by branch) of `lumen process`."""

    def run(surface, name, *options):
        out = tmp_path / name
        done = lumen(surface, out, *options)
        rows = {}
        if done.returncode == 0:
            with (out / "sections.csv").open() as file:
                for row in csv.DictReader(file):
                    rows.setdefault(row["branch"], []).append(row)
        summary = json.loads((out / "anatomy.json").read_text()) if done.returncode == 0 else None
        return done, summary, rows

    return run


def positions(rows):
    return np.array([[float(row[k]) for k in ("x_mm", "y_mm", "z_mm")] for row in rows])


def values(rows, name, flag="ok"):
    return np.array([float(row[name]) for row in rows if row["flag"] == flag])


def towards(degrees, length, start):
    return tuple(np.add(start, [length * np.cos(np.radians(degrees)), length * np.sin(np.radians(degrees)), 0]))


def test_daughters_at_twelve_degrees(measured, tmp_path):
    fork, radii = (12.0, 0.0, 0.0), (1.2, 1.0)
    daughters = [(fork, towards(angle, length, fork), r, r) for angle, length, r in ((6, 25, 1.2), (-6, 23, 1.0))]
    points = surfaces.tree([((0, 0, 0), fork, 1.6, 1.3), *daughters], inner=(0,))
    done, summary, rows = measured(surfaces.write(tmp_path / "fork.vtp", *points), "out")
    assert done.returncode == 0, done.stderr
    assert [b["name"] for b in summary["branches"]] == ["main", "side1"]
    assert summary["mesh"]["min_angle_deg"] >= 30  # at the carina, too
    # where the daughters' walls part
    apart = 12 + sum(radii) / (2 * np.sin(np.radians(6)))
    for name, (a, b, r, _) in zip(("main", "side1"), daughters):
        free = [row for row in rows[name] if float(row["x_mm"]) > apart + 1]
        along = np.subtract(b, a) / np.linalg.norm(np.subtract(b, a))
        x = positions(free) - a
        off = np.linalg.norm(x - np.outer(x @ along, along), axis=1)
        assert off.mean() < 0.03 and off.max() < 0.15
        area = values(free, "area_mm2") / (np.pi * r**2)
        assert len(area) > 10 and abs(area.mean() - 1) < 0.01 and area.std() < 0.01
    assert 10 < summary["branches"][1]["s_on_parent_mm"] < apart


@pytest.mark.slow
def test_outlets_side_by_side(measured, tmp_path):
    """Two outlets with 0.3 mm between their walls, one of which runs on past the other."""
    r, side = 0.9, 0.9 + 0.15
    segments = [((0, 0, 0), (13, 0, 0), 1.5, 1.4)]
    for sign, stop in ((1, 24), (-1, 26)):
        segments += [((12, 0, 0), (16, sign * 1.6, 0), r, r), ((16, sign * 1.6, 0), (20, sign * side, 0), r, r)]
        segments += [((20, sign * side, 0), (stop, sign * side, 0), r, r)]
    tree = surfaces.tree(segments, spacing=0.1, inner=(0, 1, 2, 4, 5), reach=1.15)
    done, summary, rows = measured(surfaces.write(tmp_path / "y.vtp", *tree), "out", "--edge", 0.25)
    assert done.returncode == 0, done.stderr
    ends = [np.array(end["centre_mm"]) for end in summary["ends"][1:]]
    assert ends[0] == pytest.approx([26, -side, 0], abs=0.05) and ends[1] == pytest.approx([24, side, 0], abs=0.05)
    for name, sign in (("main", -1), ("side1", 1)):
        free = [row for row in rows[name] if 21 < float(row["x_mm"])]
        x = positions(free)
        assert np.hypot(x[:, 1] - sign * side, x[:, 2]).max() < 0.05
        area = values(free, "area_mm2")
        assert len(area) > 3 and abs(area.mean() / (np.pi * r**2) - 1) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.5, 0.75])
def test_thin_branch_keeps_its_area_in_later_passes(measured, tmp_path, radius):
    side = ((10, 0, 0), (10 + 9 * np.cos(1.0), 9 * np.sin(1.0), 0), radius, radius)
    segments = [((0, 0, 0), (22, 0, 0), 1.6, 1.5), side]
    points, triangles = surfaces.tree(segments, spacing=0.15)
    tree = surfaces.onto_cones(points, segments), triangles
    done, summary, rows = measured(surfaces.write(tmp_path / "tree.vtp", *tree), "pre")
    assert done.returncode == 0, done.stderr
    state, like = tmp_path / "pre" / "lumen.vtp", tmp_path / "pre" / "anatomy.json"
    means = [values(rows["side1"], "area_mm2").mean() / (np.pi * radius**2)]
    for name in ("second", "third"):
        done, later, rows = measured(state, name, "--like", like)
        assert done.returncode == 0, done.stderr
        assert [b["name"] for b in later["branches"]] == ["main", "side1"]
        assert later["mesh"]["min_angle_deg"] >= 30
        means.append(values(rows["side1"], "area_mm2").mean() / (np.pi * radius**2))
        state = tmp_path / name / "lumen.vtp"
    assert np.abs(np.array(means) - 1).max() < 0.01, means


def test_throat_of_a_third_of_a_millimetre(measured, tmp_path):
    def radius(s):
        inside = np.abs(s - 12) < 4
        return 1.5 - 1.2 * np.where(inside, np.cos(np.pi * (s - 12) / 8) ** 2, 0)

    surface = surfaces.write(tmp_path / "throat.stl", *surfaces.tube(surfaces.arc(0.05), radius, 24, 0.1))
    done, summary, rows = measured(surface, "out", "--spacing", 0.25)
    assert done.returncode == 0, done.stderr
    lesion = summary["lesions"][0]
    assert lesion["mld_mm"] == pytest.approx(0.6, rel=0.03) and lesion["diameter_stenosis_percent"] == pytest.approx(
        80, abs=0.7
    )
    s = values(rows["main"], "s_mm")
    ratio = values(rows["main"], "area_mm2") / (np.pi * radius(s if s[0] < 12 else 24 - s) ** 2)
    assert abs(ratio.mean() - 1) < 0.01
    assert summary["mesh"]["min_angle_deg"] >= 30


@pytest.mark.parametrize("stenosis", [0.9, 0.95])
def test_thread_like_throat(measured, tmp_path, stenosis):
    """Throats with radii of 0.16 and 0.08 mm are too narrow for the wanted edge. They get a finer mesh and have the
    right area."""

    def radius(s):
        return 1.6 * (1 - stenosis * np.where(np.abs(s - 8) < 4, np.cos(np.pi * (s - 8) / 8) ** 2, 0))

    surface = surfaces.write(tmp_path / "throat.stl", *surfaces.tube(surfaces.straight, radius, 16, 0.2))
    done, summary, rows = measured(surface, "out", "--edge", 0.4)
    assert done.returncode == 0, done.stderr
    lesion = summary["lesions"][0]
    assert lesion["mld_mm"] == pytest.approx(3.2 * (1 - stenosis), rel=0.02)
    assert lesion["diameter_stenosis_percent"] == pytest.approx(100 * stenosis, abs=0.5)
    assert summary["mesh"]["min_angle_deg"] >= 30 and summary["mesh"]["smallest_edge_mm"] < 1.2 * 1.6 * (1 - stenosis)
    x = positions(rows["main"])
    assert np.hypot(x[:, 1], x[:, 2]).mean() < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("edge", [0.2, 0.4])
def test_hairpin_does_not_fuse(measured, tmp_path, edge):
    """The legs are 0.3 mm apart. The result has the full length and volume, or an error is raised. The legs never
    fuse."""
    axis, length = surfaces.hairpin(12, 0.3, 1.2)
    surface = surfaces.write(tmp_path / "hairpin.vtp", *surfaces.tube(axis, lambda s: 1.2 + 0 * s, length, 0.2))
    done, summary, rows = measured(surface, "out", "--edge", edge)
    if edge > 0.3 and done.returncode != 0:
        assert done.returncode == 3 and "cross itself" in done.stderr and "smaller edge" in done.stderr
        return
    assert done.returncode == 0, done.stderr
    assert summary["branches"][0]["length_mm"] == pytest.approx(length, rel=0.01)
    assert summary["mesh"]["volume_mm3"] == pytest.approx(np.pi * 1.2**2 * length, rel=0.03)
    assert values(rows["main"], "area_mm2") == pytest.approx(np.pi * 1.2**2, rel=0.03)


def test_vessels_that_fuse_to_a_ring_are_refused(measured, tmp_path):
    segments = [((0, 0, 0), (30, 0, 0), 1.6, 1.4), ((8, 0, 0), (15, 6, 0), 1, 1), ((15, 6, 0), (22, 0, 0), 1, 1)]
    tree = surfaces.tree(segments, inner=(1, 2))
    done, *_ = measured(surfaces.write(tmp_path / "ring.vtp", *tree), "out")
    assert done.returncode == 2 and "forms a ring" in done.stderr and "Euler number 0" in done.stderr
    x, y, z = map(float, done.stderr.split("near (")[1].split(")")[0].split(", "))
    assert 5 < x < 25 and -2 < y < 8 and abs(z) < 2  # on the ring, not at an end


def test_noise_as_large_as_the_triangles_is_refused_early(measured, tmp_path):
    """The surface has tens of handles. It is refused before the search for self-intersections, which took up to 20
    s."""
    segments = [((0, 0, 0), (12, 0, 0), 1.6, 1.4)]
    done, *_ = measured(surfaces.write(tmp_path / "n.vtp", *surfaces.tree(segments, spacing=0.13, noise=0.1)), "out")
    assert done.returncode == 2 and "rings, as no coronary tree does" in done.stderr
    assert "noise as large as its triangles" in done.stderr and "lumen: self-intersections" not in done.stderr

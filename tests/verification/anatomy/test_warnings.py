"""Defects that do not stop the program give a warning with their place. Sound surfaces give none."""

import json

import numpy as np
import pytest
import surfaces


@pytest.fixture
def said(lumen, tmp_path):
    """said(points, triangles, *options) -> (standard error, rows of sections.csv); asserts success."""

    def run(points, triangles, *options):
        surface = surfaces.write(tmp_path / "s.vtp", points, triangles)
        done = lumen(surface, tmp_path / "out", *options)
        assert done.returncode == 0, done.stderr
        with (tmp_path / "out" / "sections.csv").open() as file:
            head, *rows = [line.strip().split(",") for line in file]
        return done.stderr, [dict(zip(head, row)) for row in rows]

    return run


def place_in(text, what):
    """The first place "(x, y, z) mm" in the line of standard error that says `what`."""
    line = next(line for line in text.splitlines() if what in line)
    return np.array([float(x) for x in line.split(" (")[-1].split("at (")[-1].split(")")[0].split(", ")])


def areas(rows):
    return np.array([float(row["area_mm2"]) for row in rows if row["flag"] == "ok"])


@pytest.mark.parametrize("capped", [True, False])
def test_oval_ends_are_not_taken_for_rounded_ones(said, capped):
    points, triangles = surfaces.tube(surfaces.arc(0.05), lambda s: 1.5 + 0 * s, 20, 0.3, capped=capped)
    errors, _ = said(points * [1, 1, 2.2], triangles)
    assert "rounded end" not in errors and "short tip" not in errors


def test_a_rounded_end_that_the_points_leave_out_is_warned_of_with_its_place(said):
    tree = [((0, 0, 0), (20, 0, 0), 1.5, 1.5), ((10, 0, 0), (10, 7, 0), 1.0, 1.0)]
    (p, t), (q, u) = surfaces.tree(tree), surfaces.tree(tree, rounded=True)
    t, u = t[p[t].mean(axis=1)[:, 1] < 4], u[q[u].mean(axis=1)[:, 1] > 4]
    errors, _ = said(np.vstack([p, q]), np.vstack([t, u + len(p)]), "--outlet", "20,0,0")
    assert "warning: end without a point left closed" in errors
    assert abs(np.linalg.norm(place_in(errors, "left closed") - [10, 7, 0]) - 1) < 0.1  # on the half ball
    errors, _ = said(p, surfaces.tree(tree)[1])
    assert "left closed" not in errors


@pytest.mark.parametrize("edge, height", [(0.4, 1.0), (0.4, -0.7), (0.2, 0.6)])
def test_a_single_vertex_that_stands_out_is_put_back(said, edge, height):
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20, edge)
    errors, rows = said(points, triangles)
    assert "spike" not in errors
    clean = areas(rows)
    v = np.linalg.norm(points - [10, 1.5, 0], axis=1).argmin()
    points[v, 1:] *= 1 + height / 1.5
    errors, rows = said(points, triangles)
    assert "repair: spikes flattened (1)" in errors
    assert np.linalg.norm(place_in(errors, "spikes flattened") - points[v]) < 0.01
    assert areas(rows) == pytest.approx(clean, rel=2e-3)


def test_a_dilatation_is_no_reference(lumen, tmp_path):
    """A vessel has a bulge of 60 % and a narrowing beside it. There is one lesion, measured against the healthy
    vessel."""

    def radius(s):
        return 1.5 + 0.9 * np.exp(-(((s - 13) / 3) ** 2)) - 0.6 * np.exp(-(((s - 28) / 2) ** 2))

    surface = surfaces.write(tmp_path / "s.vtp", *surfaces.tube(surfaces.straight, radius, 40, 0.3))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "warning: ectasia left out of the reference: main" in done.stderr
    lesions = json.loads((tmp_path / "out" / "anatomy.json").read_text())["lesions"]
    assert len(lesions) == 1
    assert lesions[0]["reference_diameter_mm"] == pytest.approx(3.0, rel=0.01)
    assert lesions[0]["diameter_stenosis_percent"] == pytest.approx(40, abs=1)


def test_vessel_healthy_between_two_narrowings_is_no_dilatation(said):
    def radius(s):
        return 1.5 - 0.5 * np.exp(-(((s - 9) / 3) ** 2)) - 0.5 * np.exp(-(((s - 21) / 3) ** 2))

    errors, _ = said(*surfaces.tube(surfaces.straight, radius, 30, 0.3))
    assert "dilatation" not in errors


@pytest.mark.parametrize("off_mm, told", [(0.0, False), (0.03, True)])
def test_a_cap_that_is_nearly_flat_is_noted_not_warned_of(said, off_mm, told):
    """The cap's rim is off its plane by up to 2 % of the radius. A cap that is less flat is cut like a rounded end."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20, 0.3)
    rim = np.isclose(points[:, 0], 20) & (np.hypot(points[:, 1], points[:, 2]) > 1)
    points[rim, 0] += off_mm * np.sign(points[rim, 1]) * np.sign(points[rim, 2])
    errors, rows = said(points, triangles)
    assert ("repair: caps flattened" in errors) == told and "warning: caps flattened" not in errors
    assert areas(rows) == pytest.approx(np.pi * 1.5**2, rel=0.01)


@pytest.mark.parametrize("inlet, told", [(2.1, True), (1.8, False)])
def test_a_lesion_beside_an_end_that_is_wider_than_the_reference(said, inlet, told):
    """Before the lesion the vessel is wider than behind it, as at a branch that is missing in the file."""

    def radius(s):
        healthy = np.where(s < 4.2, inlet, 1.7)
        return healthy - 0.85 * np.exp(-(((s - 4.2) / 1.2) ** 2))

    errors, _ = said(*surfaces.tube(surfaces.straight, radius, 26, 0.25))
    assert ("warning: end wider than the reference" in errors) == told


def test_noise_at_the_inlet_is_no_narrowing(said):
    """Noise moves the axis off the middle at the inlet. The largest sphere round the axis is there a third narrower
    than the lumen."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.8 - 0.55 * s / 40, 40, 0.25)
    points = np.asarray(points) + 0.03 * np.random.default_rng(1).standard_normal(np.shape(points))
    errors, _ = said(points, triangles, "--inlet", "0,0,0")
    assert "narrowing at an end" not in errors


@pytest.mark.parametrize("throat, told", [(0.0, True), (8.0, False)])
def test_a_lesion_on_the_inlet_itself(said, throat, told):
    """A stenosis of 60 % lies in the plane of the ostium, where no section is measured."""

    def radius(s):
        return 1.6 - 0.96 * np.exp(-(((s - throat) / 1.5) ** 2))

    points, triangles = surfaces.tube(surfaces.straight, radius, 26, 0.25)
    errors, _ = said(points, triangles, "--inlet", "0,0,0")
    assert ("warning: narrowing at an end" in errors) == told


@pytest.mark.parametrize("named", [False, True])
def test_an_inlet_that_only_its_width_names(said, named):
    """The ostium is narrowed, so the outlet is the larger end. If the user names the inlet, there is no warning."""

    def radius(s):
        return 1.8 - 0.02 * s - 0.7 * np.exp(-((s / 3) ** 2))

    points, triangles = surfaces.tube(surfaces.straight, radius, 26, 0.25)
    errors, rows = said(points, triangles, *(["--inlet", "0,0,0"] if named else []))
    assert ("warning: inlet chosen by its width alone" in errors) == (not named)
    assert ("the vessel widens from it" in errors) == (not named)
    assert (float(rows[0]["x_mm"]) < 13) == named


@pytest.mark.parametrize("throat, told", [(0.0, True), (9.0, False)])
def test_an_inlet_larger_only_because_the_other_end_is_narrowed(said, throat, told):
    """The vessel hardly tapers, so only the narrowed end gives a hint. A lesion away from the end does not put the
    inlet in doubt."""

    def radius(s):
        return 1.6 - 0.006 * s - 0.5 * np.exp(-(((s - throat) / 3) ** 2))

    errors, rows = said(*surfaces.tube(surfaces.straight, radius, 40, 0.25))
    assert ("before it narrows to" in errors) == told
    assert (float(rows[0]["x_mm"]) > 20) == told


@pytest.mark.parametrize(
    "radius, taper, length, told",
    [(1.7, 0.012, 30, True), (1.7, 0.008, 30, False), (1.7, 0.012, 15, False), (1.2, 0.012, 30, False)],
)
def test_a_taper_steeper_than_coronaries_have(said, radius, taper, length, told):
    """A steep taper may be diffuse disease, so there is a warning. There is none for a short stretch, which says too
    little, or a small branch, which tapers more."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: radius * (1 - taper * s), length, 0.25)
    errors, _ = said(points, triangles)
    assert ("warning: reference tapers steeply" in errors) == told


@pytest.mark.parametrize("inlet, told", [("0,0,0", False), ("40,0,0", True)])
def test_an_inlet_that_was_named_at_a_far_narrower_end(said, inlet, told):
    """The user probably named the wrong end. There is a warning, but the user's choice is kept."""
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.9 - 0.015 * s, 40, 0.25)
    errors, rows = said(points, triangles, "--inlet", inlet)
    assert ("warning: inlet narrower than an outlet" in errors) == told
    assert (float(rows[0]["x_mm"]) > 20) == told


@pytest.mark.parametrize("apart, told", [(3.2, True), (12.0, False)])
def test_another_vessel_fused_along_the_lumen(said, apart, told):
    """A vein touches the artery over some length. Its lumen may hide a lesion, so there is a warning. There is none for
    a side branch, which leaves at once."""
    artery = ((0, 0, 0), (40, 0, 0), 1.6, 1.4)
    vein = [((14, 3.2, 0), (28, 3.2, 0), 1.9, 1.9)] if told else [((14, 0, 0), (28, apart, 0), 1.2, 1.1)]
    errors, _ = said(*surfaces.tree([artery, *vein], inner=(1,) if told else ()), "--inlet", "0,0,0")
    assert ("warning: another vessel may be fused to the lumen" in errors) == told


@pytest.mark.parametrize("lean, told", [(-14, True), (14, False)])
def test_a_vessel_that_turns_back_into_a_graft(said, lean, told):
    """The longest path from the inlet turns back into the graft. The sections where it turns are false."""
    artery, graft = ((0, 0, 0), (34, 0, 0), 1.6, 1.3), ((22, 0, 0), (22 + lean, 16, 0), 1.3, 1.3)
    errors, _ = said(*surfaces.tree([artery, graft]), "--inlet", "0,0,0")
    assert ("warning: a vessel turns back at a branch" in errors) == told


def test_a_closed_end_among_open_ones_is_said(lumen, tmp_path):
    """A branch that ends blindly, as behind an occlusion, must not become an outlet with flow unnoticed."""
    main, blind = ((0, 0, 0), (24, 0, 0), 1.5, 1.3), ((12, 0, 0), (16, 8, 0), 0.9, 0.9)
    surface = surfaces.write(tmp_path / "blind.vtp", *surfaces.tree([main, blind], inner=(1,)))
    done = lumen(surface, tmp_path / "out")
    assert done.returncode == 0 and "warning: closed end among open ones" in done.stderr, done.stderr
    done = lumen(surface, tmp_path / "named", "--inlet", "0,0,0", "--outlet", "24,0,0")
    assert done.returncode == 0 and "closed end among open ones" not in done.stderr, done.stderr
    assert len(json.loads((tmp_path / "named" / "anatomy.json").read_text())["ends"]) == 2

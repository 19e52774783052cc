"""Volume meshes of tubes: volume, tags, quality, repair of folds and slivers, and the refusal of bad meshes."""

import dataclasses
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.spatial.transform import Rotation

import tubes
from common.errors import ComputationError
from flow.discretisation import spaces
from flow.geometry import centreline, curving, folds, refine, surface, tags, tet10
from flow.meshing import hybrid, mesh, size_field, slivers, volume_mesh
from flow import settings as settings_module


def _not_swept(patch):
    """Replaces the first attempt of the mesher by one that finds nothing to sweep."""

    def no_spans(*_):
        raise hybrid.NoSpans("not wanted here")

    first, *others = mesh.ATTEMPTS
    patch.setattr(mesh, "ATTEMPTS", (dataclasses.replace(first, make_cells=no_spans), *others))


@pytest.fixture(scope="module")
def built():
    """A bent, narrowed tube in cells of one size in all directions."""
    radius = tubes.lesion(1.5, 0.4, 8, 8)
    tube = tubes.tube(16, radius, 0.5, tubes.arc(0.05))
    tree = centreline.Tree([tubes.centre_branch(16, radius, tubes.arc(0.05))])
    with pytest.MonkeyPatch.context() as patch:
        _not_swept(patch)
        return tube, mesh.build(tube, tree, 2.0, settings_module.make(**tubes.NO_EXTENSIONS))


def _volume(quadratic):
    """Volume in mm3. det J is cubic in a cell, so the mean of its Bezier coefficients is the exact mean of det J."""
    lattice = tet10._POINTS
    jacobian = np.einsum("tnx,pnr->tpxr", quadratic.points[quadratic.tetrahedra], tet10.gradients(lattice))
    bezier = np.linalg.det(jacobian) @ tet10._TO_BEZIER.T
    return bezier.mean(axis=1).sum() / 6.0


def test_curved_volume_is_that_of_the_smooth_vessel(built):
    tube, (quadratic, _) = built
    s = np.linspace(0, 16, 4001)
    exact = trapezoid(np.pi * tubes.lesion(1.5, 0.4, 8, 8)(s) ** 2, s)
    straight = tube.volume_mm3()
    assert abs(straight - exact) / exact > 0.01
    assert abs(_volume(quadratic) - exact) / exact < 0.001


def test_quality_is_reported_and_good(built):
    _, (_, report) = built
    quality = report["quality"]
    assert quality["gamma_min"] > 0.1
    assert quality["jacobian_ratio_min"] > 0.3
    assert quality["curved_edges"] > 1000 and quality["straightened_edges"] == 0
    swept = report["swept"]
    assert (swept["way"], swept["cells"], swept["spans"], swept["moved"]) == ("isotropic", 0, [], [])
    assert swept["reason"] == "swept: not wanted here" and swept["cost"] == mesh.ISOTROPIC_COST


def test_mesh_file_has_the_tags(built, tmp_path):
    _, (quadratic, report) = built
    mesh.write(quadratic, tmp_path / "mesh.msh")
    space = spaces.read(tmp_path / "mesh.msh")
    assert space.outlet_tags == [tags.physical_tag(2)]
    assert len(space.nodes()[1]) == report["cells"]
    assert space.area(tags.PHYSICAL_INLET) == pytest.approx(np.pi * 1.5e-3**2, rel=1e-4)
    assert space.dofs == report["dofs"]


def test_a_folded_element_is_straightened():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.05]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    flat = surface.Surface(points, faces, np.array([0, 0, 0, 0]))
    edges, _ = flat.edges()
    bowed = points[edges].mean(axis=1) + np.array([0, 0, 0.1])  # through the opposite corner
    quadratic = curving.curve(faces, flat.region, points, np.array([[0, 1, 2, 3]]), edges, bowed)
    assert quadratic.straightened_edges > 0
    assert tet10.jacobian_bounds(quadratic.points[quadratic.tetrahedra])[0].min() > 0


def test_jacobian_bounds_enclose_samples():
    rng = np.random.default_rng(3)
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    nodes = np.concatenate([corners, corners[tet10.EDGES].mean(axis=1)])[None] + 0.05 * rng.normal(size=(20, 10, 3))
    lower, upper = tet10.jacobian_bounds(nodes)
    lam = rng.dirichlet(np.ones(4), size=200)
    determinant = np.linalg.det(np.einsum("tnx,pnr->tpxr", nodes, tet10.gradients(lam)))
    assert (determinant >= lower[:, None] - 1e-12).all() and (determinant <= upper[:, None] + 1e-12).all()
    assert (lower < upper).all()


def test_refinement_reaches_its_target_on_the_surface():
    tube = tubes.tube(10, lambda s: 1.5, 0.8)
    finer = refine.refine(tube, lambda points: np.full(len(points), 0.3))
    surface.check(finer, "refined")
    edges, _ = finer.edges()
    length = np.linalg.norm(finer.points[edges[:, 0]] - finer.points[edges[:, 1]], axis=1)
    assert length.max() < 1.4 * 0.3 + 1e-12
    wall = np.unique(finer.triangles[finer.region == 0])
    assert np.abs(np.hypot(*finer.points[wall, 1:].T) - 1.5).max() < 0.003


@pytest.mark.slow
def test_the_same_surface_gives_the_same_mesh_everywhere(repo_root, tmp_path):
    """The mesh has the same bytes in another folder, for another user, with other memory addresses, on another kind of
    processor."""
    surface, branches = tubes.fork(length=12.0, at=5.0, side_length=5.0, edge_mm=0.5)
    # The vessel is turned. Along an axis some products would be exact and hide differences of rounding.
    turn = Rotation.from_euler("xyz", [0.3, 0.5, 0.7]).as_matrix()
    for part in (surface, *branches):
        part.points = np.round(part.points @ turn.T, 9)
    tubes.write_case(tmp_path / "lumen", surface, branches, {"side1": ("main", 5.0)})
    folder = tmp_path / ("another folder" * 8)
    folder.mkdir()
    for name in (".gmshrc", ".gmsh-options"):  # gmsh reads these files in a user's home
        (folder / name).write_text("Mesh.MeshSizeFactor = 0.5;\nMesh.Algorithm3D = 4;\n")
    here = {"PATH": os.environ["PATH"], "PYTHONPATH": str(repo_root), "PYTHONHASHSEED": "1", "OMP_NUM_THREADS": "1"}
    elsewhere = {
        **dict.fromkeys(("TMPDIR", "HOME"), str(folder)),
        **{"PYTHONHASHSEED": "77", "OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "LANG": "de_DE.UTF-8"},
        **{"MALLOC_MMAP_THRESHOLD_": "64", "PYTHONMALLOC": "malloc", "USER": "another"},  # objects at random addresses
        **{
            "OPENBLAS_CORETYPE": "Prescott",
            "NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX2 FMA3 AVX F16C",
        },
    }
    found = []
    for cwd, environment in ((repo_root, here), (folder, {**here, **elsewhere})):
        out = tmp_path / f"out{len(found)}"
        out.mkdir()
        lumen = [str(tmp_path / "lumen" / name) for name in ("lumen.vtp", "centreline.vtp")]
        command = [sys.executable, "-m", "flow", "mesh", lumen[0], "--centreline", lumen[1], "--rings", "3"]
        subprocess.run([*command, "--out", str(out / "mesh.msh")], cwd=cwd, env=environment, check=True)
        found.append([(out / name).read_bytes() for name in ("mesh.msh", "mesh.json")])
    report = json.loads(found[0][1])
    assert 0 < report["swept"]["cells"] < report["cells"]  # both kinds of cells are compared
    assert found[0] == found[1]


def test_layers_that_nothing_swept_has_are_not_claimed(monkeypatch, capsys):
    _not_swept(monkeypatch)
    tree = centreline.Tree([tubes.centre_branch(5, lambda s: 1.5)])
    wanted = settings_module.make(wall_layers=3, **tubes.NO_EXTENSIONS)
    _, report = mesh.build(tubes.tube(5, lambda s: 1.5), tree, 1.5, wanted)
    assert report["wall_layers"] == 1
    assert "not wanted here" in report["swept"]["reason"] and "3 were asked for" in report["swept"]["reason"]
    assert "no wall_layers, 3 were asked for" in capsys.readouterr().err


def _with_a_fold(whole):
    """A tube with a fold: an edge of its wall is split near one end, and the edge from there to that end is flipped.
    The two facets beside it then lie on each other. Radius correction left three such folds in a real tree."""
    edges, side = whole.edges()
    middles = whole.points[edges].mean(axis=1)
    k = int(np.argmin(np.linalg.norm(middles - [2.5, 1.5, 0.0], axis=1)))
    a, b = edges[k]
    first, second = np.flatnonzero((side == k).any(axis=1))
    order = whole.triangles[first].tolist()
    if order[(order.index(a) + 1) % 3] != b:
        first, second = second, first
    (c,), (d,) = (np.setdiff1d(whole.triangles[facet], edges[k]) for facet in (first, second))
    m = len(whole.points)
    points = np.concatenate([whole.points, 0.85 * whole.points[[a]] + 0.15 * whole.points[[b]]])
    rest = np.delete(np.arange(len(whole.triangles)), [first, second])
    new = [[m, b, c], [b, m, d], [a, d, c], [d, m, c]]  # flat: [a, m, c], [m, a, d] instead of the last two
    return surface.Surface(
        points,
        np.concatenate([whole.triangles[rest], new]),
        np.concatenate([whole.region[rest], np.zeros(4, whole.region.dtype)]),
    )


def test_a_fold_of_the_surface_is_flattened():
    tree = centreline.Tree([tubes.centre_branch(5, lambda s: 1.5)])
    sizes = size_field.SizeField(tree, 1.5, 0.1)
    folded = _with_a_fold(tubes.tube(5, lambda s: 1.5))
    surface.check(folded, "folded")
    with pytest.raises(ComputationError):
        volume_mesh.fill(folded, sizes)
    flat = folds.unfold(folded)
    surface.check(flat, "unfolded")
    assert (flat.triangles != folded.triangles).any(axis=1).sum() == 2
    assert flat.volume_mm3() == pytest.approx(folded.volume_mm3(), rel=1e-4)
    points, tetrahedra = volume_mesh.fill(flat, sizes)
    assert tet10.six_volumes(points, tetrahedra).sum() / 6 == pytest.approx(flat.volume_mm3())
    assert folds.unfold(flat) is flat  # the sharp edges at caps are not taken for folds


def test_a_sliver_is_split_where_it_can_be():
    """A flat tetrahedron lies on two others, under a wall. All its corners are on the surface."""
    points = np.array([[0, 0, 0], [1, 0, 0.0], [0, 1, 0], [1, 1, 0], [0.5, 0.5, -1.0]], float)
    points[[0, 3], 2] -= 1e-3  # the square's diagonal 0-3 runs just below the other diagonal, an edge of the surface
    cells = tet10.orient_positive(points, np.array([[0, 3, 1, 2], [0, 3, 1, 4], [0, 3, 2, 4]]))
    assert curving.gamma(points[cells]).min() < 0.02
    edges = np.array([[1, 2], [0, 1], [1, 3], [3, 2], [2, 0], [0, 4], [1, 4], [2, 4], [3, 4]])
    more, split = slivers.split_slivers(points, cells, edges, 0.02)
    assert len(more) == 6 and curving.gamma(more[split]).min() >= 0.02
    volume = tet10.six_volumes(points, cells).sum()
    assert tet10.six_volumes(more, split).sum() == pytest.approx(volume) and tet10.count_overlapping(split) == 0


def test_a_sliver_is_refused_with_its_place(monkeypatch):
    monkeypatch.setattr(volume_mesh, "LEAST_GAMMA", 0.9)
    tree = centreline.Tree([tubes.centre_branch(5, lambda s: 1.5)])
    with pytest.raises(ComputationError, match="sliver(.|\n)*tetrahedron at(.|\n)*gamma"):
        volume_mesh.fill(tubes.tube(5, lambda s: 1.5), size_field.SizeField(tree, 1.5, 0.1))


def test_gmsh_fills_the_next_surface_after_a_failure(tmp_path):
    """A job that fails says why. A program that was killed is started again."""
    tree = centreline.Tree([tubes.centre_branch(5, lambda s: 1.5)])
    tube, sizes = tubes.tube(5, lambda s: 1.5, 0.8), size_field.SizeField(tree, 1.5, 0.1)
    first = volume_mesh.fill(tube, sizes)
    with pytest.raises(ComputationError, match="FileNotFoundError(.|\n)*surface.npz"):
        volume_mesh._run_gmsh(tmp_path)
    running = volume_mesh._program()
    assert running.poll() is None
    running.kill()
    running.wait()
    for found, expected in zip(volume_mesh.fill(tube, sizes), first):
        assert np.array_equal(found, expected)


def test_where_finer_facets_cannot_be_filled_those_given_are(monkeypatch):
    """This happens where the smooth surface crosses itself in a cleft. Then the facets as given are filled."""
    tube, asked = tubes.tube(5, lambda s: 1.5, 0.8), []

    def fill(surface, sizes, real=volume_mesh.fill):
        asked.append(len(surface.triangles))
        if len(surface.triangles) > len(tube.triangles):
            raise ComputationError("gmsh could not fill the lumen", "volume mesh", "crosses itself", "none")
        return real(surface, sizes)

    monkeypatch.setattr(volume_mesh, "fill", fill)
    _not_swept(monkeypatch)
    tree = centreline.Tree([tubes.centre_branch(5, lambda s: 1.5)])
    quadratic, report = mesh.build(tube, tree, 3.0, settings_module.make(**tubes.NO_EXTENSIONS))
    assert len(asked) == 2 and asked[0] > asked[1] == len(tube.triangles) == len(quadratic.triangles)
    assert report["swept"]["way"] == mesh.ATTEMPTS[2].name and "crosses itself" in report["swept"]["reason"]
    assert _volume(quadratic) == pytest.approx(np.pi * 1.5**2 * 5, rel=1e-3)


def test_a_bad_mesh_is_refused(monkeypatch, settings):
    monkeypatch.setattr(mesh, "LEAST_JACOBIAN_RATIO", 0.99)
    tree = centreline.Tree([tubes.centre_branch(5, lambda s: 1.5)])
    with pytest.raises(ComputationError, match="jacobian_ratio_min"):
        mesh.build(tubes.tube(5, lambda s: 1.5), tree, 2.0, settings)


def test_a_mesh_that_is_not_coarser_is_left_out_of_the_sequence(monkeypatch, tmp_path):
    """This happens in a short vessel of which only the mesh of three rings can be swept. The file of the mesh that is
    left out is empty."""
    cells = {4: 300, 3: 400, 2: 200}
    monkeypatch.setattr(mesh, "build", lambda *given: (f"{given[4]} rings", {"cells": cells[given[4]]}))
    monkeypatch.setattr(mesh, "write", lambda built, path: path.write_text(built))
    paths = [(tmp_path / name, rings) for name, rings in (("a.msh", 2), ("b.msh", 3), ("c.msh", 4))]
    report = {}
    made = mesh.build_sequence(paths, None, None, settings_module.make(), report)
    mesh.write_all(made, report, tmp_path / "mesh.json")
    assert [(tmp_path / name).read_text() for name in ("a.msh", "b.msh", "c.msh")] == ["2 rings", "", "4 rings"]
    assert report["cells"] == 300 and [part["cells"] for part in report["coarse"]] == [200]
    assert report["left_out"] == [{"file": "b.msh", "rings": 3, "cells": 400, "not_fewer_than": 300}]


@pytest.mark.parametrize("others, of_the_mesh", [([("a.msh", 2), ("b.msh", 3)], (2.0, 2, 2.0)), ([], (3.0, 4, 1.0))])
def test_the_mesh_of_a_reduced_model_is_the_coarsest(monkeypatch, tmp_path, others, of_the_mesh):
    monkeypatch.setattr(mesh, "build", lambda *given: ("made", {"cells": 1, "built": (given[2], *given[4:])}))
    monkeypatch.setattr(mesh, "write", lambda built, path: path.write_text(built))
    paths, report = [(tmp_path / name, rings) for name, rings in [*others, ("c.msh", 4)]], {}
    settings = settings_module.make(coarse_cells_per_radius=2.0, cells_per_radius=3.0)
    mesh.write_all(mesh.build_coarsest(paths, None, None, settings, report), report, tmp_path / "mesh.json")
    assert report["built"] == of_the_mesh and "coarse" not in report
    assert [path.read_text() for path, _ in paths] == [*("" for _ in others), "made"]


def test_cells_on_the_same_side_of_a_face_overlap():
    """Both cells have positive volume. First the second one's tip lies beyond the common face. Then it lies on the same
    side as the first one's."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, -1.0]])
    pair = tet10.orient_positive(points, np.array([[0, 1, 2, 3], [0, 1, 2, 4]]))
    assert tet10.count_overlapping(pair) == 0
    points[4, 2] = 0.5
    folded = tet10.orient_positive(points, np.array([[0, 1, 2, 3], [0, 1, 2, 4]]))
    assert tet10.count_overlapping(folded) == 1
    shuffled = folded[:, [1, 2, 0, 3]]  # an even permutation of the corners keeps the volume positive
    assert tet10.count_overlapping(shuffled) == 1

"""Refusals of the solver: files, meshes, boundary values, and flows that stall or lose mass."""

import json
import types

import numpy as np
import pytest

import solved_tube
import tubes
from common.errors import ComputationError, InputError
from flow.discretisation import spaces
from flow.geometry import centreline, tet10
from flow.inputs import boundary
from flow.physics import outlets
from flow.reduced import network as network_model
from flow import __main__ as command_line
from flow import settings as settings_module
from solved_tube import LENGTH, RADIUS


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Folder of the straight tube."""
    return solved_tube.make(tmp_path_factory.mktemp("tube"))


def test_a_file_that_is_no_mesh_is_refused(case, tmp_path, capsys):
    (tmp_path / "notes.msh").write_text("not a mesh")
    command = ["solve", str(tmp_path / "notes.msh"), "--boundary", str(case / "boundary.json")]
    with pytest.raises(SystemExit) as ended:
        command_line.main(command + ["--centreline", str(case / "centreline.vtp"), "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert "notes.msh" in capsys.readouterr().err
    assert not (tmp_path / "out" / "ffr.json").exists()


def test_stall_exits_3_and_writes_nothing(case, tmp_path, capsys):
    """An earlier answer is removed too, since it would be taken for the new one. Other files stay."""
    out = tmp_path / "out"
    arguments = ["solve", str(case / "mesh.msh"), "--boundary", str(case / "boundary.json"), "--out", str(out)]
    arguments += ["--centreline", str(case / "centreline.vtp"), "--residual-absolute", "1e-20"]
    arguments += ["--max-newton-iterations", "12"]
    out.mkdir()
    for name in ("ffr.json", "pullback.csv", "solution.vtu", "notes.txt"):
        (out / name).write_text("{}")
    with pytest.raises(SystemExit) as stop:
        command_line.main(arguments)
    assert stop.value.code == 3
    assert "stalled" in capsys.readouterr().err
    assert [path.name for path in out.iterdir()] == ["notes.txt"]


def test_an_out_that_is_a_file_is_refused(case, tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    with pytest.raises(SystemExit) as ended:
        command_line.main(
            [
                "solve",
                str(case / "mesh.msh"),
                "--boundary",
                str(case / "boundary.json"),
                "--out",
                str(tmp_path / "taken"),
            ]
            + ["--centreline", str(case / "centreline.vtp")]
        )
    assert ended.value.code == 2 and "no folder for the answer" in capsys.readouterr().err


def test_an_input_is_not_removed_with_an_earlier_answer(case, tmp_path, capsys):
    for name in ("ffr.json", "pullback.csv"):
        (tmp_path / name).write_bytes((case / "boundary.json").read_bytes())
    command = ["solve", str(case / "mesh.msh"), "--boundary", str(tmp_path / "ffr.json"), "--out", str(tmp_path)]
    with pytest.raises(SystemExit) as ended:
        command_line.main(command + ["--centreline", str(case / "centreline.vtp")])
    assert ended.value.code == 2 and "replaced by its answer" in capsys.readouterr().err
    assert (tmp_path / "ffr.json").is_file() and (tmp_path / "pullback.csv").is_file()


def test_negative_resistance_exits_2(case, tmp_path):
    document = json.loads((case / "boundary.json").read_text())
    document["outlets"][0]["resistance_pa_s_per_m3"] = -1.0
    with pytest.raises(SystemExit) as stop:
        solved_tube.solve(case, tmp_path, outlets=document["outlets"])
    assert stop.value.code == 2


def test_outlets_that_the_mesh_lacks_are_refused(case):
    document = json.loads((case / "boundary.json").read_text())
    document["outlets"].append({**document["outlets"][0], "name": "outlet2", "region_id": 3})
    with pytest.raises(InputError, match="outlets"):
        outlets.Boundaries(spaces.read(case / "mesh.msh"), document)


def test_outlets_numbered_otherwise_in_the_mesh_are_refused():
    """A main vessel along x with a side branch. First the mesh numbers its caps as the boundary values do, then two are
    exchanged."""
    main = tubes.centre_branch(20.0, lambda s: 1.2)
    side = tubes.centre_branch(6.0, lambda s: 0.8, lambda s, e1, e2: np.stack([10 + e1, s, e2], axis=-1), name="side1")
    tree = centreline.Tree([main, side])
    document = tubes.boundary_document(tree.branches, [2e-6, 1e-6], [5e9, 9e9], 15.0, 0.004)
    centres = {2: [0, 0.1, 0], 12: [20.1, 0, 0], 13: [10, 6, 0.1]}

    def check(at):
        space = types.SimpleNamespace(centre=lambda tag: 1e-3 * np.array(centres[at[tag]], float))
        outlets.check_outlet_places(space, document, tree, "mesh.msh")

    check({2: 2, 12: 12, 13: 13})
    for at, named in (({2: 2, 12: 13, 13: 12}, "outlet1"), ({2: 12, 12: 2, 13: 13}, "outlet1")):
        with pytest.raises(InputError, match=f"another end of the tree(.|\n)*{named}"):
            check(at)


def test_sections_in_metres_are_refused(case, tmp_path, capsys):
    table = network_model.read_sections(case / "sections.csv")
    table.assign(s_mm=table["s_mm"] / 1e3, area_mm2=table["area_mm2"] / 1e6).to_csv(tmp_path / "s.csv", index=False)
    command = ["solve", str(case / "mesh.msh"), "--boundary", str(case / "boundary.json"), "--model", "network"]
    command += ["--centreline", str(case / "centreline.vtp"), "--sections", str(tmp_path / "s.csv")]
    with pytest.raises(SystemExit) as ended:
        command_line.main(command + ["--out", str(tmp_path / "out")])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and "s.csv, branch main" in said and "last at 0.008 of 8 mm" in said


@pytest.mark.parametrize("command", ["mesh", "solve"])
def test_a_centreline_of_another_lumen_is_refused(case, tmp_path, capsys, command):
    """The centreline is of the narrower lumen before the procedure. Both `mesh` and `solve` refuse it."""
    line = tubes.centre_branch(LENGTH, tubes.lesion(RADIUS, 0.5, LENGTH / 2, LENGTH / 2))
    tubes.write_case(tmp_path, tubes.tube(LENGTH, lambda s: RADIUS, 0.8), [line])
    given = {"mesh": [str(case / "lumen.vtp")], "solve": [str(case / "mesh.msh")]}[command]
    out = tmp_path / {"mesh": "out.msh", "solve": "out"}[command]
    given += ["--centreline", str(tmp_path / "centreline.vtp"), "--out", str(out)]
    given += ["--boundary", str(case / "boundary.json")] if command == "solve" else []
    with pytest.raises(SystemExit) as ended:
        command_line.main([command, *given])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and "centreline of another lumen" in said and "dofs" not in said
    assert not out.exists()


def test_a_centreline_that_runs_the_other_way_is_refused(case, tmp_path, capsys):
    (line,) = centreline.read(case / "centreline.vtp")
    turned = centreline.Branch(line.name, line.branch_id, line.points[::-1], line.s_mm, line.radius_mm[::-1])
    tubes.write_centreline(tmp_path / "centreline.vtp", [turned])
    for name in ("anatomy.json", "sections.csv"):
        (tmp_path / name).write_bytes((case / name).read_bytes())
    command = ["solve", str(case / "mesh.msh"), "--boundary", str(case / "boundary.json")]
    with pytest.raises(SystemExit) as ended:
        command_line.main(command + ["--centreline", str(tmp_path / "centreline.vtp"), "--out", str(tmp_path / "out")])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and "at the inlet" in said and "end of main" in said and "dofs" not in said


def test_mesh_in_metres_is_refused(case, tmp_path):
    from flow.meshing import mesh

    tube = tubes.tube(4, lambda s: 1.2, 0.8)
    tree = centreline.Tree([tubes.centre_branch(4, lambda s: 1.2)])
    built, _ = mesh.build(tube, tree, 1.5, settings_module.make())
    built.points *= 1e-3
    mesh.write(built, tmp_path / "metres.msh")
    with pytest.raises(InputError, match="mm"):
        spaces.read(tmp_path / "metres.msh")


def _bent(case, folder, shift_mm):
    """(file of a mesh of the case's tube with 3 rings, number of cells turned inside out). One inner corner of the mesh
    is moved along the axis by shift_mm."""
    from flow.geometry import surface
    from flow.meshing import mesh

    tube = surface.read(case / "lumen.vtp")
    built, _ = mesh.build(tube, centreline.read(case / "centreline.vtp"), 1.5, settings_module.make(rings=3), 3)
    inner = np.setdiff1d(built.tetrahedra[:, :4], built.triangles)
    moved = inner[np.argmin(np.linalg.norm(built.points[inner] - [LENGTH / 2, 0, 0], axis=1))]
    built.points[moved] += [shift_mm, 0, 0]
    mesh.write(built, folder / "bent.msh")
    lower, _ = tet10.jacobian_bounds(built.points[built.tetrahedra])
    return folder / "bent.msh", int((lower <= 0).sum())


def _solve_bent(case, path, out):
    files = ["--boundary", str(case / "boundary.json"), "--centreline", str(case / "centreline.vtp")]
    with pytest.raises(SystemExit) as ended:
        command_line.main(["solve", str(path), *files, "--out", str(out)])
    assert not out.exists()
    return ended.value.code


def test_a_mesh_with_inverted_cells_is_refused(case, tmp_path, capsys):
    path, folded = _bent(case, tmp_path, 1.0)
    assert folded > 0 and _solve_bent(case, path, tmp_path / "out") == 2
    said = capsys.readouterr().err
    assert "inverted" in said and f"{folded} of" in said and "flow mesh" in said
    path, folded = _bent(case, tmp_path, 0.01)
    assert folded == 0
    spaces.read(path)


def test_a_mesh_with_distorted_cells_is_refused(case, tmp_path, capsys):
    """All Jacobians are positive, but cells are more distorted than `flow mesh` would write them."""
    path, folded = _bent(case, tmp_path, 0.37)
    assert folded == 0 and _solve_bent(case, path, tmp_path / "out") == 2
    assert "distorted" in capsys.readouterr().err


@pytest.mark.parametrize("order", [1, 2])
def test_a_mesh_of_plane_facets_is_refused(case, tmp_path, capsys, order):
    """gmsh's setOrder makes such meshes: linear cells, or quadratic cells whose edges are all straight."""
    import gmsh

    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        gmsh.open(str(case / "mesh.msh"))
        gmsh.model.mesh.setOrder(1)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(tmp_path / "plane.msh"))
    finally:
        gmsh.finalize()
    assert _solve_bent(case, tmp_path / "plane.msh", tmp_path / "out") == 2
    assert "plane facets" in capsys.readouterr().err


def test_a_mesh_with_cells_on_top_of_each_other_is_refused():
    """Two straight tetrahedra of positive volume share a face. First their tips are on both sides of it, then on the
    same side."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0], [0.2, 0.2, 0]])
    for height, cells in ((-1.0, [[0, 1, 2, 3], [0, 2, 1, 4]]), (0.5, [[0, 1, 2, 3], [0, 1, 2, 4]])):
        corners[4, 2] = height
        points, nodes = list(corners), []
        for cell in cells:
            middles = [0.5 * (corners[cell[a]] + corners[cell[b]]) for a, b in tet10.EDGES]
            nodes.append([*cell, *range(len(points), len(points) + 6)])
            points += middles
        space = types.SimpleNamespace(nodes=lambda: (np.array(points), np.array(nodes)))
        if height < 0:
            spaces._check_cells(space, "mesh.msh")
        else:
            with pytest.raises(InputError, match="overlap"):
                spaces._check_cells(space, "mesh.msh")


def test_a_flow_that_loses_mass_is_refused(case, tmp_path, capsys, monkeypatch):
    """The check of the cells is switched off here. Then the difference between inflow and outflow must reveal the bad
    mesh."""
    path, _ = _bent(case, tmp_path, 0.6)
    monkeypatch.setattr(spaces, "_check_cells", lambda space, path: None)
    assert _solve_bent(case, path, tmp_path / "out") == 3
    assert "mass is not conserved" in capsys.readouterr().err


def test_mesh_without_an_outlet_is_refused(tmp_path):
    from flow.meshing import mesh

    tube = tubes.tube(4, lambda s: 1.2, 0.8)
    tree = centreline.Tree([tubes.centre_branch(4, lambda s: 1.2)])
    built, _ = mesh.build(tube, tree, 1.5, settings_module.make())
    built.region = np.where(built.region == 2, 0, built.region)
    mesh.write(built, tmp_path / "closed.msh")
    with pytest.raises(InputError, match="physical groups"):
        spaces.read(tmp_path / "closed.msh")


def test_boundary_check_reports_missing_keys():
    with pytest.raises(InputError, match="venous"):
        boundary.check({"map_pa": 12000.0})


def test_factorization_failure_is_a_computation_error():
    import scipy.sparse

    from flow.solvers import linear

    solver = linear.DirectSolver()
    with pytest.raises(ComputationError, match="factorization failed"):
        solver.set_matrix(scipy.sparse.csr_matrix([[np.nan, 1.0], [1.0, np.nan]]))
        solver.solve(np.ones((2, 1)))

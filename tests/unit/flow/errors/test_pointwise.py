"""The error estimate at outlets and along the pull-back, from the error fields."""

import json
import types

import numpy as np
import pandas as pd
import pytest
import scipy.sparse

import dual_solutions
import tubes
from flow import __main__ as command_line
from flow.errors import error_estimate, error_field
from flow.geometry import centreline
from flow.physics import ffr, outlets
from flow.solvers import newton, nonlinear
from flow.discretisation import spaces
from flow.errors import pointwise, recovery
from flow import settings as settings_module

pytestmark = pytest.mark.slow

MAP = 12000.0


class _Case:
    """A mesh and its steady flow, with the attributes of solvers.solved_mesh.SolvedMesh that pointwise uses."""

    def __init__(self, folder, surface, branches, parents, document, probes_mm):
        tubes.write_case(folder, surface, branches, parents)
        self.folder, self.document = folder, document
        document["probes"] = [
            {
                "name": "distal" if s == probes_mm[0] else f"at {s:g}",
                "branch": "main",
                "s_mm": s,
                "point_mm": branches[0].point(s).tolist(),
            }
            for s in probes_mm
        ]
        (folder / "boundary.json").write_text(json.dumps(document))
        self.line = ["--centreline", str(folder / "centreline.vtp")]
        mesh = str(folder / "mesh.msh")
        command_line.main(["mesh", str(folder / "lumen.vtp"), *self.line, "--rings", "2", "--out", mesh])
        self.tree, self.space = centreline.read(folder / "centreline.vtp"), spaces.read(folder / "mesh.msh")
        self.boundaries, self.estimate = outlets.Boundaries(self.space, document), None
        self.problem = nonlinear.FlowProblem(self.space, self.boundaries, document, settings_module.make())
        assert newton.newton(self.problem, 1e-11, 12).converged
        self.outlet_names = self.boundaries.outlet_names
        self.case = types.SimpleNamespace(extensions=[], document=document, original_tree=self.tree)
        self.read()

    def read(self):
        self.sampler = self.space.sampler(self.problem.state.x.array)
        self.outflows = self.boundaries.outflows(self.problem.state.x.array)

    def places(self):
        """(pointwise.FfrPlaces of all outlets and the pull-back, table of the pull-back)."""
        table = ffr.pullback(self.tree, self.sampler, MAP, lambda branch, s_mm: 0.0)
        return pointwise.FfrPlaces(self, self.case, self.outlet_names, table), table


def _document(branches, resistances):
    return tubes.boundary_document(branches, [2e-6] * len(branches), resistances, 4.0, 0.004, (MAP, 600.0))


@pytest.fixture(scope="module")
def fork(tmp_path_factory):
    """A vessel with one side branch, whose outlet has ten times the resistance of the main one."""
    surface, branches = tubes.fork(length=16.0, at=7.0, side_length=6.0)
    document = _document(branches, [5e9, 5e10])
    return _Case(tmp_path_factory.mktemp("fork"), surface, branches, {"side1": ("main", 7.0)}, document, [4.0, 12.0])


@pytest.fixture(scope="module")
def tube(tmp_path_factory):
    """A tube narrowed by 30 %."""
    radius = tubes.lesion(1.2, 0.3, 4.0, 4.0)
    branches = [tubes.centre_branch(8.0, radius)]
    document = _document(branches, [5e9])
    return _Case(tmp_path_factory.mktemp("tube"), tubes.tube(8.0, radius, 0.4), branches, None, document, [4.0, 7.0])


@pytest.fixture(scope="module", params=["fork", "tube"])
def case(request):
    return request.getfixturevalue(request.param)


def test_the_fields_give_the_parts_of_the_dual_solutions(case):
    """The fields come from the transposed problem. At each probe they give the same parts as dual_solutions."""
    wanted, (found, field) = dual_solutions.error_parts(case, case.document, case.tree), error_field.solve_error_field(
        case, case.document, case.tree
    )
    assert found.shape[1] == wanted.shape[1] + 1 and wanted.shape[1] > 3
    assert np.abs(found[:, :-1] - wanted).max() < 1e-6 * np.abs(wanted).max()
    assert field.pressure.shape[1] == found.shape[1] and (found[:, -1] == 0).all()


def test_parts_are_the_derivative_of_ffr(case):
    """The field is a random small change of the flow. `ffr_changes` must give the derivative of FFR along it, at
    outlets and at points."""
    random, space = np.random.default_rng(5), case.space
    change = np.zeros(space.dofs)
    change[space.free_dofs] = random.standard_normal(len(space.free_dofs)) * np.where(
        case.problem.free_velocity, 1e-3, 1.0
    )
    made_up = types.SimpleNamespace(state=case.problem.state, responses=lambda loads: change[:, None] * np.ones(1))
    given = types.SimpleNamespace(problem=made_up, space=space, boundaries=case.boundaries, sampler=case.sampler)
    field = error_field.ErrorField(given, scipy.sparse.csc_matrix((space.dofs, 1)))
    points, radii = case.tree.main.point(np.array([2.0, 5.0])), np.array([1.0, 0.8])
    found = field.ffr_changes(case.outlet_names, points, radii)[:, 0]
    values, step, sides = case.problem.state.x.array.copy(), 1e-3, []
    for sign in (1, -1):
        moved = values + sign * step * change
        pressures = case.boundaries.pressures(case.boundaries.outflows(moved))
        round_points = field._averaging_matrix(points, radii) @ moved[space.q_map]
        sides.append(np.append(pressures, round_points) / MAP)
    wanted = (sides[0] - sides[1]) / (2 * step)
    assert np.abs(wanted).min() > 0
    assert found == pytest.approx(wanted, rel=1e-5)


def test_loads_say_what_recovery_makes_of_values(case):
    """`recover_transposed` gives a sparse matrix. For each group of targets its product with the values must equal the
    sum of load times recovered value."""
    nodes, cells = case.space.nodes()
    random, patches = np.random.default_rng(6), recovery.Patches(nodes, cells)
    values, targets = random.standard_normal((len(nodes), 1)), nodes[cells].mean(axis=1)
    loads, group = random.standard_normal((len(targets), 1)), random.integers(0, 3, len(targets))
    of = np.arange(len(targets))[:, None]
    smooth = dual_solutions.recover(patches, 3, cells, values, targets, of)
    chosen = np.arange(10, 20)
    part = patches.recover(3, cells, values[:, 0], targets, of, chosen)
    assert part[chosen] == pytest.approx(smooth[chosen, 0], rel=1e-8)
    ((found,),) = patches.recover_transposed([(3, cells, loads, targets, of, group)], 3)
    wanted = np.bincount(group, (smooth * loads)[:, 0])
    assert found.T @ values[:, 0] == pytest.approx(wanted, rel=1e-8)


def test_interpolation_is_told_apart_from_the_values(fork):
    """A quadratic pressure is given at the corners, and the sampler interpolates it linearly. interpolation_error_pa
    must give the error of this interpolation."""

    def quadratic(points):
        return 1e6 * (1e3 * points[:, 0] - 6.0) ** 2

    sampler = fork.space.sampler(fork.problem.state.x.array)
    sampler.pressure = quadratic(fork.space.nodes()[0])
    field = error_field.ErrorField.__new__(error_field.ErrorField)
    field.sampler = sampler
    points_mm = fork.tree.main.point(np.linspace(2.0, 14.0, 40))
    error = np.abs(sampler(1e-3 * points_mm)[1] - quadratic(1e-3 * points_mm))
    assert error.max() > 100.0
    assert field.interpolation_error_pa(points_mm) == pytest.approx(error, rel=1e-6, abs=1e-6 * error.max())


def test_the_artificial_viscositys_part_is_eps_times_the_derivative_of_ffr(fork):
    """The derivative follows from central differences of flows at two eps beside it. It is not negligible here."""
    problem, document, tree = fork.problem, fork.document, fork.tree
    values, inflow, found = problem.state.x.array.copy(), problem.inflow, {}
    for eps in (0.048, 0.052, 0.05):
        problem.forms.artificial_viscosity.value = eps
        assert newton.newton(problem, 1e-12, 12).converged
        problem.mark_outdated()  # forces a new tangent, at this flow itself
        along, field = error_field.solve_error_field(fork, document, tree)
        points = [tree.main.point(one["s_mm"]) for one in document["probes"]]
        radii = np.array([tree.main.radius(one["s_mm"]) for one in document["probes"]])
        found[eps] = field._averaging_matrix(np.array(points), radii) @ problem.state.x.array[fork.space.q_map] / MAP
    problem.forms.artificial_viscosity.value, problem.state.x.array[:], problem.inflow = 0.0, values, inflow
    problem.mark_outdated()
    assert np.abs(along[:, -1]).max() > 1e-4
    assert along[:, -1] == pytest.approx(0.05 * (found[0.052] - found[0.048]) / 0.004, rel=1e-3)


def _estimated(case, **basis):
    """(errors at outlets and pull-back, method) with an EstimateBasis."""
    places, _ = case.places()
    solved = types.SimpleNamespace(**{**vars(case), "estimate": {"basis": error_estimate.EstimateBasis(**basis)}})
    return pointwise.estimate_errors(solved, places)


def test_each_part_of_an_estimate_counts(fork):
    _, field = error_field.solve_error_field(fork, fork.document, fork.tree)
    residual, method = _estimated(fork, field=field)
    assert residual.shape == (2 + 33 + 13,) and (residual >= 0).all() and residual[:2].min() > 0
    assert "residual" in method and "meshes" not in method
    places, _ = fork.places()
    parts = field.ffr_changes(fork.outlet_names, places.points_mm, places.radii_mm)
    assert residual[:2] == pytest.approx(error_estimate.error_of_parts(parts[:, :-1])[:2])
    read = field.interpolation_error_pa(places.points_mm) / MAP
    assert residual[2:] == pytest.approx(error_estimate.error_of_parts(parts[:, :-1])[2:] + read) and read.max() > 1e-6
    lower = fork.space.sampler(fork.problem.state.x.array)
    lower.pressure = fork.sampler.pressure - 0.01 * MAP
    pair = (fork.sampler, fork.outflows), (lower, fork.outflows * 1.01), 0.5
    meshes, method = _estimated(fork, pair=pair)
    assert method == "two meshes" and meshes[2:] == pytest.approx(0.005, rel=1e-6)
    wanted = 0.5 * 0.01 * fork.boundaries.resistance * fork.outflows / MAP
    assert meshes[:2] == pytest.approx(wanted, rel=1e-6)
    both, method = _estimated(fork, field=field, pair=pair)
    assert both == pytest.approx(np.maximum(residual, meshes)) and "two meshes" in method
    answer, (_, table) = {"outlets": [{}, {}]}, fork.places()
    pointwise.add_estimates(fork, fork.case, answer, table)
    assert answer == {"outlets": [{"error_estimate": None}] * 2, "pullback_error_estimate": None}
    assert table[pointwise.ESTIMATE_COLUMN].isna().all()


def test_an_outlet_behind_an_extension_has_the_error_of_its_vessels_end(fork):
    """It is the error at the last point of the branch's pull-back, whatever the order of the outlets. Other outlets
    keep their own error."""
    _, field = error_field.solve_error_field(fork, fork.document, fork.tree)
    plain, _ = _estimated(fork, field=field)
    last = [2 + 32, 2 + 33 + 12]  # the last points of the branches, behind the two outlets
    assert (np.abs(plain[last] - plain[:2]) > 1e-3 * plain[last]).all()
    turned = {**fork.document, "outlets": fork.document["outlets"][::-1]}
    for longer, document in ([3], fork.document), ([2, 3], turned):
        extensions = [types.SimpleNamespace(region_id=region) for region in longer]
        given = types.SimpleNamespace(**vars(fork))
        given.case = types.SimpleNamespace(extensions=extensions, document=document, original_tree=fork.tree)
        given.places = lambda: (pointwise.FfrPlaces(given, given.case, fork.outlet_names, fork.places()[1]), None)
        found, _ = _estimated(given, field=field)
        wanted = [plain[last[k]] if k + 2 in longer else plain[k] for k in range(2)]
        assert found == pytest.approx(np.append(wanted, plain[2:]), rel=1e-9)


@pytest.mark.parametrize("model", ["3d", "network"])
def test_the_files_have_the_errors(fork, tmp_path, model):
    files = ["--boundary", str(fork.folder / "boundary.json"), *fork.line, "--out", str(tmp_path)]
    command_line.main(["solve", str(fork.folder / "mesh.msh"), *files, "--model", model])
    answer, table = json.loads((tmp_path / "ffr.json").read_text()), pd.read_csv(tmp_path / "pullback.csv")
    errors = [outlet["error_estimate"] for outlet in answer["outlets"]]
    if model == "network":
        assert errors == [None, None] and table["ffr_error_estimate"].isna().all()
        assert answer["pullback_error_estimate"] is None
        return
    _, field = error_field.solve_error_field(fork, fork.document, fork.tree)
    wanted, _ = _estimated(fork, field=field)
    assert errors == pytest.approx(wanted[:2].tolist(), rel=1e-3)
    assert table["ffr_error_estimate"].to_numpy() == pytest.approx(wanted[2:], rel=1e-3, abs=1e-3 * wanted.max())
    assert answer["pullback_error_estimate"]["largest"] == pytest.approx(table["ffr_error_estimate"].max())
    main = table[table["branch"] == "main"]
    for probe in answer["probes"]:  # the pull-back's estimate has the interpolation error at its points on top
        near = np.interp(probe["s_mm"], main["s_mm"], main["ffr_error_estimate"])
        assert probe["error_estimate"] <= near * 1.01 and near <= probe["error_estimate"] + 5e-4

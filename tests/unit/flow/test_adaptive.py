"""Which mesh answers, and when a flow is marched in time, on meshes whose flows are made up."""

import types

import numpy as np
import pytest

from common.errors import ComputationError
from flow import adaptive, settings
from flow.errors import error_estimate
from flow.solvers import solved_mesh

PATHS = ["coarse.msh", "fine.msh"]
# error estimates
STEADY = {"ffr": 0.001, "goal": 0.001, "goal_signed": 0.001}
KEPT = {"ffr": 0.02, "goal": 0.001, "goal_signed": 0.001, "jet_mixing": 0.019}  # c > 0 on a mesh that is good enough
ROUGH = {"ffr": 0.024, "goal": 0.004, "goal_signed": 0.004, "jet_mixing": 0.02}  # c > 0 on one that is not quite
for one in (KEPT, ROUGH):
    one["probes_mesh"], one["basis"] = [one["goal"]], error_estimate.Basis()
WIDE = {"ffr": 0.006, "goal": 0.006, "goal_signed": 0.002}  # steady, above the tolerance


class _Mesh:
    """What adaptive asks of a Solved: ffr is its state's only value."""

    def __init__(self, path, ffr, mixing, outcome, estimate):
        self.path, self.outcome, self.mixing, self.found = path, outcome, mixing, estimate
        self.unsteady, self.marched, self.estimate, self.cpu_seconds = None, False, None, 0.0
        cells = range(1000 if "coarse" in path else 8000)
        self.space = types.SimpleNamespace(dofs=1, nodes=lambda: (None, cells))
        self.problem = _Problem(
            state=types.SimpleNamespace(x=types.SimpleNamespace(array=np.array([ffr]))),
            inflow=0.0,
            iterations=None if path in PATHS else [7],
            forms=types.SimpleNamespace(mixing=types.SimpleNamespace(value=mixing)),
            solver=types.SimpleNamespace(factorizations=3),
            settings=settings.make(),
            residual_norm=lambda: 0.0,
            outcome=lambda *_: "marched",
            release=lambda: None,
        )
        self.sampler, self.outflows = self.problem.state, None

    status, known = solved_mesh.Solved.status, solved_mesh.Solved.known

    def read(self):
        """The sampler is the state."""

    def destroy(self):
        """Nothing to free."""


class _Problem(types.SimpleNamespace):
    @property
    def mixing(self):
        return self.forms.mixing.value


@pytest.fixture
def search(monkeypatch, capfd):
    """search({mesh: (ffr, c, steady?, estimate)}, {mesh: (ffr, difference) or None}, whole) -> Solved, Search, tried.

    The second says where marches settle; tried: [(mesh, "steady" or "march")] in order.
    """

    def run(meshes, marches, whole=False, **values):
        tried = []

        def solve_mesh(path, document, chosen, tree, predicted, start, spent, march, near):
            tried.append((path, "near" if near else "steady"))
            ffr, mixing, steady, estimate = meshes[path]
            if not steady and not march:
                error = ComputationError("stalled", path, 0, "none")
                error.factorizations = 3
                raise error
            return _Mesh(path, ffr, mixing, "steady" if steady else None, estimate)

        def march(problem, read):
            path = next(mesh for mesh, flow in meshes.items() if flow[0] == problem.state.x.array[0])
            tried.append((path, "march"))
            problem.forms.mixing.value = 0.0
            if marches.get(path) is None:
                problem.state.x.array[:] = np.nan
                raise ComputationError("not settled", path, 0, "none")
            problem.state.x.array[:], difference = marches[path]
            return types.SimpleNamespace(difference=difference)

        monkeypatch.setattr(adaptive, "solve_mesh", solve_mesh)
        monkeypatch.setattr(adaptive.unsteady, "march", march)

        monkeypatch.setattr(adaptive.error_estimate, "of", lambda solved, *others: solved.found)
        monkeypatch.setattr(adaptive.Search, "at_probes", lambda self, sampler: [float(sampler.x.array[0])])
        found = adaptive.Search(None, settings.make(**values), None, types.SimpleNamespace(whole=whole))
        return found.run(PATHS), found, tried

    return run


def test_an_error_that_is_not_within_the_tolerance_is_warned_of(capsys):
    chosen = settings.make(ffr_tolerance=0.005)
    assert adaptive.missed({"ffr": 0.005, "probes": [0.005]}, chosen) == [] and capsys.readouterr().err == ""
    (above,) = adaptive.missed({"ffr": 0.0123, "probes": [0.0123]}, chosen)
    (unknown,) = adaptive.missed(None, chosen)
    elsewhere = {"ffr": 0.004, "probes": [0.004, 0.001, 0.0061]}
    (other,) = adaptive.missed(elsewhere, chosen, ["distal", "near", "far"])
    assert "0.0123, above ffr_tolerance = 0.005" in above and "not known" in unknown
    assert "probe far is 0.0061, above ffr_tolerance = 0.005" in other
    assert capsys.readouterr().err == f"{above}\n{unknown}\n{other}\n"


def test_a_coarse_mesh_within_the_tolerance_answers(search):
    solved, found, tried = search({"coarse.msh": (0.8, 0.0, True, STEADY)}, {})
    assert solved.path == "coarse.msh" and tried == [("coarse.msh", "steady")] and len(found.meshes) == 1


def test_a_good_mesh_with_eddy_viscosity_is_marched_and_answers(search):
    solved, found, tried = search({"coarse.msh": (0.8, 0.12, True, KEPT)}, {"coarse.msh": (0.79, 0.002)})
    assert tried == [("coarse.msh", "steady"), ("coarse.msh", "march")]
    assert solved.status == "unsteady" and solved.estimate["ffr"] == pytest.approx(0.003)
    assert found.meshes[0]["ffr"] == 0.79


@pytest.mark.parametrize("whole, estimate", [(True, KEPT), (False, ROUGH)])
def test_the_fine_mesh_is_tried_before_a_march(search, whole, estimate):
    """In a single tube, and where the coarse mesh's own error would leave too little for the march's."""
    meshes = {"coarse.msh": (0.8, 0.12, True, estimate), "fine.msh": (0.78, 0.0, True, STEADY)}
    solved, _, tried = search(meshes, {}, whole)
    assert solved.path == "fine.msh" and tried == [("coarse.msh", "steady"), ("fine.msh", "steady")]


@pytest.mark.parametrize("steady", [True, False])
def test_a_steady_coarse_flow_answers_where_the_fine_mesh_has_none_near_it(search, steady):
    """Neither a search in c nor a march on the larger mesh: the answer's error is known."""
    meshes = {"coarse.msh": (0.8, 0.0, True, WIDE), "fine.msh": (0.79, 0.0, steady, STEADY)}
    solved, found, tried = search(meshes, {"fine.msh": (0.7, 0.0)})
    assert tried == [("coarse.msh", "steady"), ("fine.msh", "near")]
    assert solved.path == ("fine.msh" if steady else "coarse.msh") and solved.status == "converged"
    assert solved.estimate == (STEADY if steady else WIDE)
    assert [mesh["mesh"] for mesh in found.meshes] == PATHS


def test_where_the_fine_mesh_does_not_settle_the_coarse_one_is_marched(search, capfd):
    meshes = {"coarse.msh": (0.8, 0.27, True, ROUGH), "fine.msh": (0.78, 0.27, False, None)}
    solved, found, tried = search(meshes, {"coarse.msh": (0.79, 0.002)})
    assert [what for what in tried if what[1] == "march"] == [("fine.msh", "march"), ("coarse.msh", "march")]
    assert solved.path == "coarse.msh" and solved.status == "unsteady"
    assert solved.estimate["ffr"] == pytest.approx(0.006)
    assert "the mesh before answers" in capfd.readouterr().err
    assert [mesh["mesh"] for mesh in found.meshes] == PATHS  # each once
    assert found.meshes[0]["ffr"] == 0.79


def test_a_fine_mesh_without_a_steady_flow_is_marched_with_the_coarse_ones_estimate(search):
    meshes = {"coarse.msh": (0.8, 0.27, True, ROUGH), "fine.msh": (0.78, 0.27, False, None)}
    solved, _, _ = search(meshes, {"fine.msh": (0.77, 0.0005)})
    assert solved.path == "fine.msh" and solved.estimate["ffr"] == pytest.approx(0.0045)
    assert "0.27" in solved.estimate["method"]


def test_two_means_estimate_the_error_of_the_finer_by_their_difference(search, capfd):
    """.012 apart on meshes of half the width: a third of it, and the windows' differences."""
    meshes = {"coarse.msh": (0.8, 0.27, True, ROUGH), "fine.msh": (0.78, 0.27, False, None)}
    solved, found, _ = search(meshes, {"fine.msh": (0.77, 0.002), "coarse.msh": (0.782, 0.001)})
    assert solved.path == "fine.msh" and solved.status == "unsteady"
    assert solved.estimate["ffr"] == solved.estimate["probes"][0] == pytest.approx(0.004 + 0.003)
    assert solved.estimate["mesh"] == pytest.approx(0.004) and solved.estimate["mean"] == pytest.approx(0.003)
    basis = solved.estimate["basis"]  # of the estimates at outlets and pull-back
    *means, share = basis.pair
    assert [sampler.x.array[0] for sampler, _ in means] == pytest.approx([0.77, 0.782])
    assert share == pytest.approx(1 / 3)
    assert basis.field is None and not basis.jet and basis.mean == pytest.approx(0.003)
    assert [mesh["mesh"] for mesh in found.meshes] == PATHS
    assert found.meshes[1]["error_estimate"] == solved.estimate["ffr"]
    assert "by both means over time, error 0.0070" in capfd.readouterr().err


def test_the_mesh_with_the_smaller_error_answers(search, capfd):
    meshes = {"coarse.msh": (0.8, 0.27, True, ROUGH), "fine.msh": (0.78, 0.27, True, ROUGH)}
    solved, _, _ = search(meshes, {"coarse.msh": (0.79, 0.002)})
    assert solved.path == "coarse.msh" and "error is the smaller" in capfd.readouterr().err
    solved, _, _ = search(meshes, {})
    assert solved.path == "fine.msh" and solved.status == "converged with eddy viscosity"
    assert solved.problem.mixing == 0.27


def test_without_any_flow_the_solve_is_refused(search):
    meshes = {path: (value, 0.27, False, None) for path, value in zip(PATHS, (0.8, 0.78))}
    with pytest.raises(ComputationError, match="not settled"):
        search(meshes, {})

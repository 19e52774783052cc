"""The choice of the mesh that gives the answer. The flows on the meshes are made up."""

import types

import pytest

from common.errors import ComputationError
from flow import adaptive, settings
from flow.solvers import solved_mesh

PATHS = ["coarse.msh", "fine.msh"]
GOOD, WIDE, WIDER = {"ffr": 0.001}, {"ffr": 0.006}, {"ffr": 0.02}  # error estimates


class _Mesh:
    """The part of a SolvedMesh that adaptive uses."""

    def __init__(self, path, ffr, eps, estimate):
        self.path, self.found, self.estimate, self.cpu_seconds = path, estimate, None, 0.0
        self.sampler, self.space = ffr, types.SimpleNamespace(dofs=1)
        solver = types.SimpleNamespace(factorizations=3)
        self.problem = types.SimpleNamespace(artificial_viscosity=eps, solver=solver, release=lambda: None)
        self.destroyed = False

    status = solved_mesh.SolvedMesh.status

    def destroy(self):
        self.destroyed = True


@pytest.fixture
def search(monkeypatch):
    """search(meshes) -> (SolvedMesh that answers, MeshSearch, [(mesh solved on, its start)]).

    meshes: {mesh: (ffr, eps, estimate)}, with None in place of the tuple if no flow is found on the mesh.
    """

    def run(meshes, state=None, **values):
        tried, efforts = [], []

        def solve_mesh(path, document, chosen, tree, predicted, before, spent, effort, start):
            tried.append((path, "state" if start else before and before.path))
            efforts.append(effort)
            if meshes[path] is None or start and start.leads_nowhere:
                error = ComputationError("stalled", path, 0, "none")
                error.factorizations = 3
                raise error
            return _Mesh(path, *meshes[path])

        monkeypatch.setattr(adaptive, "solve_mesh", solve_mesh)
        monkeypatch.setattr(adaptive.error_estimate, "estimate_error", lambda solved, *others: solved.found)
        monkeypatch.setattr(adaptive.MeshSearch, "ffr_at_probes", lambda self, sampler: [sampler])
        found = adaptive.MeshSearch(None, settings.make(**values), None, None)
        found.efforts = efforts
        return found.run(list(meshes) if len(meshes) > 2 else PATHS, state), found, tried

    return run


def test_an_error_that_is_not_within_the_tolerance_is_warned_of():
    chosen = settings.make(ffr_tolerance=0.005)
    assert adaptive.tolerance_warnings({"ffr": 0.005, "probes": [0.005]}, chosen) == []
    (above,) = adaptive.tolerance_warnings({"ffr": 0.0123, "probes": [0.0123]}, chosen)
    (unknown,) = adaptive.tolerance_warnings(None, chosen)
    elsewhere = {"ffr": 0.004, "probes": [0.004, 0.001, 0.0061]}
    (other,) = adaptive.tolerance_warnings(elsewhere, chosen, ["distal", "near", "far"])
    assert "0.0123, above ffr_tolerance = 0.005" in above and "not known" in unknown
    assert "probe far is 0.0061, above ffr_tolerance = 0.005" in other


@pytest.mark.parametrize("eps", [0.0, 0.004])
def test_a_coarse_mesh_within_the_tolerance_answers(search, eps):
    solved, found, tried = search({"coarse.msh": (0.8, eps, GOOD)})
    assert solved.path == "coarse.msh" and tried == [("coarse.msh", None)] and len(found.meshes) == 1


def test_the_finer_mesh_starts_from_the_coarse_ones_flow_and_answers(search):
    solved, found, tried = search({"coarse.msh": (0.8, 0.0, WIDE), "fine.msh": (0.79, 0.0, GOOD)})
    assert solved.path == "fine.msh" and tried == [("coarse.msh", None), ("fine.msh", "coarse.msh")]
    assert [mesh["mesh"] for mesh in found.meshes] == PATHS and found.factorizations == 6


@pytest.mark.parametrize(
    ("fine", "answers"),
    [
        ((0.79, 0.004, WIDER), "coarse.msh"),
        ((0.79, 0.004, GOOD), "fine.msh"),
        ((0.79, 0.0, WIDER), "fine.msh"),  # the estimate is wider because it includes the difference of both meshes
        ((0.79, 0.004, None), "coarse.msh"),
        (None, "coarse.msh"),
    ],
)
def test_the_better_of_two_meshes_answers(search, fine, answers):
    solved, found, _ = search({"coarse.msh": (0.8, 0.004, WIDE), "fine.msh": fine})
    assert solved.path == answers and not solved.destroyed
    assert [mesh["mesh"] for mesh in found.meshes] == PATHS
    if fine is None:
        assert found.meshes[1] == {"mesh": "fine.msh", "status": "no flow", "factorizations": 3}


THREE = ("coarsest.msh", *PATHS)


@pytest.mark.parametrize(
    ("flows", "efforts", "answers"),
    [
        ([(0.8, 0.0, GOOD)], ["early stop"], "coarsest.msh"),
        ([(0.8, 0.0, WIDE), (0.79, 0.0, GOOD)], ["early stop", "full"], "coarse.msh"),
        ([None, (0.79, 0.0, GOOD)], ["early stop", "full"], "coarse.msh"),
        ([None, None, (0.79, 0.0, GOOD)], ["early stop", "full", "full"], "fine.msh"),
        ([None, (0.8, 0.004, WIDE), (0.79, 0.0, GOOD)], ["early stop", "full", "guess only"], "fine.msh"),
        ([(0.8, 0.0, WIDE), None, None], ["early stop", "full", "guess only"], "coarsest.msh"),
        ([(0.8, 0.0, WIDER), (0.81, 0.0, WIDE), None], ["early stop", "full", "guess only"], "coarse.msh"),
    ],
)
def test_the_coarsest_of_three_meshes_only_begins_the_way(search, flows, efforts, answers):
    """On the coarsest mesh continuation stops early. On the mesh before the last every way is tried. On the last mesh
    the flow on the mesh before is the only start, if there is one."""
    meshes = {path: flow for path, flow in zip(THREE, [*flows, None, None])}
    solved, found, tried = search(meshes)
    assert solved.path == answers and found.efforts == efforts and [path for path, _ in tried] == [*THREE][: len(flows)]
    assert all(start == (answered and answered[-1]) for start, answered in _starts(tried, meshes))


def _starts(tried, meshes):
    """[(mesh whose flow a solve started from, earlier meshes with a flow or None)] for each solve."""
    return [(start, [path for path, _ in tried[:k] if meshes[path]] or None) for k, (_, start) in enumerate(tried)]


def test_a_coarse_mesh_without_a_flow_is_passed_over(search):
    solved, _, tried = search({"coarse.msh": None, "fine.msh": (0.79, 0.0, GOOD)})
    assert solved.path == "fine.msh" and tried[1] == ("fine.msh", None)


def test_without_factorizations_left_the_fine_mesh_is_not_begun(search):
    with pytest.raises(ComputationError, match="coarse.msh"):
        search({"coarse.msh": None, "fine.msh": (0.79, 0.0, GOOD)}, max_newton_iterations=3)


def test_without_any_flow_the_solve_is_refused(search):
    with pytest.raises(ComputationError, match="stalled"):
        search({"coarse.msh": None, "fine.msh": None})


def _state(mesh, artificial=0.0, leads_nowhere=False):
    """The part of an inputs.solution.StartState that adaptive uses."""
    return types.SimpleNamespace(mesh_name=mesh, artificial_viscosity=artificial, leads_nowhere=leads_nowhere)


ALL_GOOD = {name: (0.8, 0.0, GOOD) for name in THREE}


@pytest.mark.parametrize(
    ("state", "estimates", "tries"),
    [
        (_state("coarse.msh"), {}, [("coarse.msh", "state")]),
        (_state("coarse.msh"), {"coarse.msh": WIDE}, [("coarse.msh", "state"), ("fine.msh", "coarse.msh")]),
        (_state("coarse.msh", leads_nowhere=True), {}, [("coarse.msh", "state"), ("coarsest.msh", None)]),
        (_state("coarse.msh", artificial=0.003), {}, [("coarsest.msh", None)]),
        (_state("other.msh"), {}, [("coarsest.msh", None)]),
    ],
    ids=["answers", "goes on to the finer mesh", "leads nowhere", "kept some eps", "of other meshes"],
)
def test_the_mesh_that_answered_in_another_state_starts_from_it(search, state, estimates, tries):
    flows = ALL_GOOD | {name: (0.8, 0.0, estimate) for name, estimate in estimates.items()}
    solved, found, tried = search(flows, state)
    assert tried == tries and solved.path == tries[-1][0]
    failed, started = state.leads_nowhere, tries[0][1] == "state"
    assert found.factorizations == 3 * len(tries)
    assert [mesh["mesh"] for mesh in found.meshes] == [one[0] for one in tries[failed:]], "each mesh once"
    of_state = {"mesh": "coarse.msh", "led_to_flow": not failed, "factorizations": 3}
    assert found.start_record == (of_state if started else None)

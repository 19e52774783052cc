"""The march in time on a small tube: a steady flow is found again, means and amplitudes, what is refused."""

import itertools
import json
import pathlib
import resource
import types

import numpy as np
import pytest

import tubes
from common.errors import ComputationError
from flow import __main__ as command_line
from flow.discretisation import mixing, spaces
from flow.errors import error_estimate
from flow.geometry import centreline
from flow.physics import ffr, outlets
from flow.solvers import marching, newton, nonlinear, unsteady
from flow import settings as settings_module

LENGTH, RADIUS = 8.0, 1.2


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A mildly narrowed tube, meshed through the command line, and its boundary values."""
    folder = tmp_path_factory.mktemp("marched")
    tubes.mesh_narrowed(folder, 0.2, LENGTH, RADIUS)
    return folder


@pytest.fixture
def problem(case):
    """The tube's flow problem at its steady flow, with `read` for unsteady.march."""
    document, tree = json.loads((case / "boundary.json").read_text()), centreline.read(case / "centreline.vtp")
    space, settings = spaces.read(case / "mesh.msh"), settings_module.make(march_window_s=0.02, march_steps=200)
    length = mixing.mixing_length(space, tree, settings.jet_spread)
    made = nonlinear.FlowProblem(space, outlets.Boundaries(space, document), document, settings, length)
    assert nonlinear.ramp.climb(made, lambda fraction: made.boundaries.full_resistance / fraction).converged
    made.read = lambda sampler: [
        probe["ffr"] for probe in ffr.at_probes(document["probes"], tree, sampler, document["map_pa"])
    ]
    yield made
    made.destroy()


def test_a_disturbed_flow_comes_back_to_the_steady_one(problem):
    steady, inflow = problem.state.x.array.copy(), problem.inflow
    problem.scale_to(0.8)
    assert unsteady.march(problem, problem.read) is None
    assert problem.inertia is None
    assert problem.inflow == pytest.approx(inflow, rel=1e-6)
    velocity = problem.space.v_map
    gap = np.abs(problem.state.x.array - steady)[velocity].max()
    assert gap < 1e-5 * np.abs(steady[velocity]).max()


def test_the_mean_of_a_flow_that_does_not_change_is_that_flow(problem):
    steady, inflow = problem.state.x.array.copy(), problem.inflow
    stepper, window = marching.Stepper(problem), unsteady.Window(problem, lambda: np.array([0.8]))
    for dt in (1e-3, 2e-3, 3e-3, 3e-3):
        stepper.step(dt)
        window.take(dt)
    answer = unsteady._mean(problem, [window, window], stepper, 0)
    stepper.destroy()
    assert problem.state.x.array == pytest.approx(steady, rel=1e-4, abs=1e-6 * np.abs(steady).max())
    assert problem.inflow == pytest.approx(inflow, rel=1e-6)
    assert answer.means == pytest.approx([0.8]) and answer.amplitudes == pytest.approx([0.0])


def _memory_mib():
    """Resident memory of this process now."""
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def test_steps_in_time_keep_no_memory(problem):
    """A vector kept at each residual would be six a step or more: 14 GB on 300,000 dofs in some 450 steps."""
    stepper, size = marching.Stepper(problem), problem.state.x.array.nbytes / 2**20
    for step in range(110):
        if step == 10:
            before = _memory_mib()
        problem.state.x.array[problem.space.v_map] *= 1.01  # something is left to correct
        stepper.step(1e-3)
    stepper.destroy()
    assert _memory_mib() - before < 0.5 * 100 * size, "half a vector a step"


def test_mean_and_amplitude_of_what_goes_on_changing(problem):
    turn = itertools.count()
    answer = unsteady.march(problem, lambda sampler: [0.8 + 0.01 * (-1) ** next(turn), 0.9])
    assert answer.means == pytest.approx([0.8, 0.9], abs=5e-4)
    assert answer.amplitudes == pytest.approx([0.01, 0.0], abs=1e-12)
    assert answer.begin_s >= 0.02 and answer.end_s - answer.begin_s >= 0.04
    assert answer.document()["ffr_amplitude"] == pytest.approx(0.01)


def test_a_mean_that_drifts_is_refused_with_its_values(problem):
    turn = itertools.count()
    with pytest.raises(ComputationError, match="(?s)settled mean.*0\\.7"):
        unsteady.march(problem, lambda sampler: [0.8 - 1e-3 * next(turn)])
    assert problem.inertia is None


def test_a_quiet_flow_that_newton_cannot_finish_is_refused(problem, monkeypatch):
    monkeypatch.setattr(newton, "newton", lambda *_: types.SimpleNamespace(converged=False))
    with pytest.raises(ComputationError, match="neither a steady flow"):
        unsteady.march(problem, problem.read)


def test_the_window_weighs_by_time():
    state = types.SimpleNamespace(x=types.SimpleNamespace(array=np.zeros(1)))
    problem, values = types.SimpleNamespace(state=state, inflow=0.0), iter([0.0, 1.0, 3.0])
    window = unsteady.Window(problem, lambda: np.array([next(values)]))
    for dt in (1.0, 2.0, 4.0):
        window.take(dt)
    assert window.means[0] == pytest.approx((1.0 * 0.0 + 2.0 * 0.5 + 4.0 * 2.0) / 7.0)
    assert (window.low[0], window.high[0]) == (0.0, 3.0)


def test_the_steps_error_is_that_of_the_formula(problem):
    """A cubic in time of the whole state: error of the formula against its exact solution at one step."""
    stepper = marching.Stepper(problem)
    one, two, dt = 1.0, 2.0, 1.5
    stepper.lengths = [one, two]
    size = len(problem.state.x.array)

    def cubic(t):
        return np.full(size, t**3)

    at = [0.0, -one, -one - two]
    stepper.values = [cubic(t) for t in at]
    stepper.inflows = [0.0] * 3
    stepper._extrapolate(dt)
    slope = 3 * dt**2
    formula = (slope + stepper.inertia.past) / stepper.inertia.weight  # solves du/dt = slope
    parabola = (dt - at[0]) * (dt - at[1]) * (dt - at[2])
    gap = formula - (cubic(dt) - parabola)
    expected = np.sqrt(3) * abs(formula[0] - dt**3)
    assert stepper._error(gap, dt) == pytest.approx(expected, rel=1e-9)
    stepper.destroy()


def test_a_flow_that_newton_does_not_find_is_found_in_time(case, tmp_path, monkeypatch, capfd):
    arguments = ["solve", str(case / "mesh.msh"), "--boundary", str(case / "boundary.json")]
    arguments += ["--centreline", str(case / "centreline.vtp"), "--out", str(tmp_path)]
    command_line.main(arguments)
    steady = json.loads((tmp_path / "ffr.json").read_text())

    def stalls(problem, *_):
        raise problem.stalled(problem.outcome(1.0, 0.0, 0.0, 0))

    monkeypatch.setattr(nonlinear.FlowProblem, "solve", stalls)
    command_line.main(arguments)
    marched = json.loads((tmp_path / "ffr.json").read_text())
    assert "marched in time" in capfd.readouterr().err
    assert marched["status"] == "converged" and marched["unsteady"] is None
    assert marched["ffr"] == pytest.approx(steady["ffr"], abs=1e-6)
    (tmp_path / "ffr.json").unlink()
    with pytest.raises(SystemExit) as ended:
        command_line.main([*arguments, "--march-steps", "0"])
    assert ended.value.code == 3 and not (tmp_path / "ffr.json").exists()


def test_estimate_of_a_mean():
    steady = {"ffr": 0.02, "goal": 0.001, "goal_signed": -0.0007, "mesh": 0.003, "jet_mixing": 0.017, "method": "x"}
    steady |= {
        "probes": [0.02, 0.03],
        "probes_mesh": [0.003, 0.004],
        "basis": error_estimate.Basis("field", "pair", True),
    }
    estimate = error_estimate.of_mean(steady, 0.27, 0.002)
    assert estimate["basis"] == error_estimate.Basis("field", "pair", False, 0.002)  # for outlets and pull-back
    assert estimate["ffr"] == pytest.approx(0.005)
    assert estimate["probes"] == pytest.approx([0.005, 0.006])
    assert "jet_mixing" not in estimate and "0.27" in estimate["method"]
    assert error_estimate.of_mean(None, 0.4, 0.002) is None

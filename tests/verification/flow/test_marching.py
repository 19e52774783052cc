"""The march in time compared with Womersley's flow in a tube: its error is of order 2 in the time step.

Womersley 1955, J Physiol 127. The inflow Q (1 + A cos(w t)) is given as a parabola. A few radii downstream the slope of
the pressure is the sum of two parts. One is Poiseuille's. The other is the real part of
A Q i w rho / (pi R^2) exp(i w t) / (1 - 2 J1(x) / (x J0(x))) with x = i^1.5 alpha.
"""

import pathlib
import sys

import numpy as np
import pytest
from scipy.special import jv

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "unit" / "flow")]

import given_inflow  # noqa: E402
import tubes  # noqa: E402
from flow import settings  # noqa: E402
from flow.discretisation import spaces  # noqa: E402
from flow.geometry import centreline  # noqa: E402
from flow.meshing import mesh  # noqa: E402
from flow.solvers import marching, newton, nonlinear  # noqa: E402

pytestmark = pytest.mark.slow

LENGTH, RADIUS, DENSITY, VISCOSITY = 9.0, 1.2, 1060.0, 0.004  # mm, SI
MEAN_FLOW, SWING, ALPHA = 2e-8, 0.3, 3.0  # Q in m3/s (Reynolds number 3), A, Womersley number
OMEGA = (ALPHA / (RADIUS * 1e-3)) ** 2 * VISCOSITY / DENSITY  # 1/s
OUTLET = 1.0  # Pa at the outlet at the mean flow; the pressure falls by about half as much
PLACES = 4.0, 8.0  # mm: the pressure drop is taken between these places
STEPS = 12, 24, 48  # time steps per period
PERIODS = 3.0  # after these the transient of the start has decayed by exp(-11)


@pytest.fixture(scope="module")
def problem(tmp_path_factory):
    """A straight tube with given inflow."""
    path = tmp_path_factory.mktemp("womersley") / "mesh.msh"
    tree = centreline.Tree([tubes.centre_branch(LENGTH, lambda s: RADIUS)])
    chosen = settings.make()
    built, _ = mesh.build(tubes.tube(LENGTH, lambda s: RADIUS, 0.4), tree, 2.5, chosen, 4, 1.0)
    mesh.write(built, path)
    space = spaces.read(path)
    outlet = {"name": "outlet1", "region_id": 2, "branch": "main", "flow_m3_per_s": MEAN_FLOW}
    document = {
        "map_pa": 1.5 * OUTLET,
        "venous_pressure_pa": 0.0,
        "density_kg_per_m3": DENSITY,
        "viscosity_pa_s": VISCOSITY,
        "outlets": [outlet | {"resistance_pa_s_per_m3": OUTLET / MEAN_FLOW}],
    }
    made = nonlinear.FlowProblem(space, given_inflow.GivenInflow(space, document), document, chosen)
    made.boundaries.set_flow(MEAN_FLOW * (1 + SWING))
    assert newton.newton(made, 1e-12, 8).converged
    yield made
    made.destroy()


def _exact(time):
    """Pressure drop in Pa between PLACES."""
    x = np.exp(0.75j * np.pi) * ALPHA
    area, length = np.pi * (RADIUS * 1e-3) ** 2, (PLACES[1] - PLACES[0]) * 1e-3
    swing = 1j * OMEGA * DENSITY / area * np.exp(1j * OMEGA * time) / (1 - 2 * jv(1, x) / (x * jv(0, x)))
    return MEAN_FLOW * length * (8 * np.pi * VISCOSITY / area**2 + SWING * swing.real)


def _errors(problem, steps_a_period):
    """Errors of the pressure drop over its swing, at STEPS[0] times of the last period."""
    start = problem.state.x.array.copy(), problem.inflow
    stepper, dt, errors = marching.Stepper(problem), 2 * np.pi / OMEGA / steps_a_period, []
    points = np.array([[s, 0.0, 0.0] for s in PLACES]) * 1e-3
    while stepper.steps < PERIODS * steps_a_period:
        problem.boundaries.set_flow(MEAN_FLOW * (1 + SWING * np.cos(OMEGA * (stepper.time + dt))))
        stepper.step(dt)
        before, behind = problem.space.sampler(problem.state.x.array)(points)[1]
        errors.append(before - behind - _exact(stepper.time))
    stepper.destroy()
    problem.state.x.array[:], problem.inflow = start
    swing = np.ptp([_exact(t) for t in np.linspace(0, 2 * np.pi / OMEGA, 100)])
    every = steps_a_period // STEPS[0]
    return np.array(errors[-steps_a_period:][every - 1 :: every]) / swing


def test_order_of_the_march_in_time(problem):
    coarse, middle, fine = (_errors(problem, steps) for steps in STEPS)
    assert np.abs(fine).max() < 0.006
    # The errors of the mesh and of the parabola at the inlet are the same in all runs, so they cancel in differences.
    order = np.log2(np.abs(coarse - middle).max() / np.abs(middle - fine).max())
    assert 1.9 < order < 2.2

"""The flow of another state, read back from its files."""

import itertools
import json

import numpy as np
import pytest

from common.errors import InputError
from flow import output
from flow.geometry import tet10
from flow.geometry.centreline import Branch, Tree
from flow.inputs import solution

INFLOW, EPS = 3e-6, 0.002


def polynomials(points):
    """Velocity (n, 3), of degree two, and pressure (n,), of degree one, at points (n, 3) in m."""
    x, y, z = points.T * 1e3
    return np.stack([1 + x * y, z**2 - y, x * z + 2 * y**2], axis=1), 100 + x - 2 * y + 3 * z


@pytest.fixture
def folder(tmp_path):
    """A solved state: a cube of 1 mm in six tetrahedra with straight edges, each with nodes of its own."""
    cells = [np.cumsum([np.zeros(3), *np.eye(3)[list(axes)]], axis=0) for axes in itertools.permutations(range(3))]
    corners = np.concatenate(cells)
    straight = tet10.orient_positive(corners, np.arange(24).reshape(6, 4))
    corners = corners[straight]
    nodes = np.concatenate([corners, corners[:, tet10.EDGES].mean(axis=2)], axis=1).reshape(-1, 3) * 1e-3
    velocity, pressure = polynomials(nodes)
    fields = {"velocity_m_per_s": velocity, "pressure_pa": pressure}
    output.write_vtu(tmp_path / "solution.vtu", nodes, np.arange(60).reshape(6, 10), fields)
    document = {"mesh": "mesh.msh", "inlet_flow_m3_per_s": INFLOW, "artificial_viscosity": EPS}
    (tmp_path / "ffr.json").write_text(json.dumps(document))
    return tmp_path


@pytest.mark.parametrize("key", ["mesh", "inlet_flow_m3_per_s", "artificial_viscosity"])
def test_an_answer_without_a_flow_in_three_dimensions_is_refused(folder, key):
    document = json.loads((folder / "ffr.json").read_text())
    del document[key]
    (folder / "ffr.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=f"(?s)not a flow in three dimensions.*key {key} is missing.*model 3d"):
        solution.read(folder, Tree([]), Tree([]))


def test_in_the_same_lumen_the_guess_is_the_flow_itself(folder):
    s = np.linspace(0.0, 1.0, 11)
    line = np.stack([0 * s + 0.5, 0 * s + 0.5, s], axis=1)
    tree = Tree([Branch("main", 0, line, s, 0.7 + 0 * s)])
    start = solution.read(folder, tree, tree)
    assert (start.inflow, start.artificial_viscosity, start.mesh_name) == (INFLOW, EPS, "mesh.msh")
    points = np.random.default_rng(1).uniform(0.05, 0.95, (200, 3)) * 1e-3
    velocity, pressure = polynomials(points)
    found = start.fields_at(points)
    assert found[0] == pytest.approx(velocity, abs=1e-9) and found[1] == pytest.approx(pressure, abs=1e-7)

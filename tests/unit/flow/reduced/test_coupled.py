"""The axisymmetric model and its coupling with the network, and the answers of the reduced models alone."""

import json

import numpy as np
import pytest
from scipy.integrate import trapezoid

import tubes
from flow import __main__ as command_line
from flow import solve
from flow.geometry import centreline
from flow.physics import viscosity
from flow.reduced import axisymmetric, coupled, network as network_model
from flow import settings as settings_module

MAP, VENOUS, DENSITY, MU = 12000.0, 600.0, 1060.0, 0.004


def _document(branches, flows, probe_mm):
    resistances = [(MAP - VENOUS) / flow for flow in flows]
    return tubes.boundary_document(branches, flows, resistances, probe_mm, MU, (MAP, VENOUS), DENSITY)


def test_poiseuille_drop():
    s, radius, flow = np.linspace(0, 0.02, 21), np.full(21, 1e-3), 1e-6
    tube = axisymmetric.Tube(s, radius, [], DENSITY, viscosity.Newtonian(MU), 0.5)
    tube.solve(flow, [])
    found_s, pressure = tube.axis_pressure()
    assert pressure == pytest.approx(-8 * MU * flow / (np.pi * 1e-12) * found_s, abs=1e-6 * abs(pressure[-1]))


def test_a_leak_takes_its_flow_through_the_wall():
    s, radius, flow = np.linspace(0, 0.03, 121), np.full(121, 1.5e-3), 2e-6
    tube = axisymmetric.Tube(s, radius, [(0.012, 2e-3)], DENSITY, viscosity.Newtonian(MU), 0.5)
    tube.solve(flow, [0.4 * flow])
    _, rho, axial, _, _ = tube.fields()

    def through(section):
        return trapezoid(2 * np.pi * rho * axial[section], rho) * radius[section] ** 2

    assert through(20) == pytest.approx(flow, rel=0.01)
    assert through(100) == pytest.approx(0.6 * flow, rel=0.01)


@pytest.fixture(scope="module")
def fork(tmp_path_factory):
    """(folder, document) of a fork with a lesion in main. The side branch gets 30 % of the flow."""
    folder = tmp_path_factory.mktemp("fork")
    profile = tubes.lesion(1.5, 0.5, 4.5, 5.0)
    surface, _ = tubes.fork(edge_mm=0.6)
    side = tubes.fork(edge_mm=0.9)[1][1]
    branches = [tubes.centre_branch(24.0, profile), side]
    tubes.write_case(folder, surface, branches, {"side1": ("main", 10.0)})
    return folder, _document(branches, [1.4e-6, 0.6e-6], 20.0)


def _network(folder, document):
    anatomy = json.loads((folder / "anatomy.json").read_text())
    return network_model.Network(anatomy, network_model.read_sections(folder / "sections.csv"), document, 1.14)


def test_coupled_flows_meet_the_outlets_resistances_and_the_tubes_pressure(fork):
    folder, document = fork
    network, tree = _network(folder, document), centreline.read(folder / "centreline.vtp")
    prediction = coupled.Predictor(network, tree, document, settings_module.make())
    s, drop = prediction.tube.axis_pressure()
    branch_s, pressure = prediction.pressures["main"]
    found = np.interp(s, branch_s, pressure) - MAP
    assert found[-1] == pytest.approx(drop[-1], abs=0.5)
    # Both pressures are interpolated between different sections, so they agree only approximately.
    assert np.abs(found - drop).max() < 0.01 * np.abs(drop).max()
    for outlet, flow in zip(document["outlets"], prediction.flows):
        end = prediction.pressures[outlet["branch"]][1][-1]
        assert end == pytest.approx(VENOUS + outlet["resistance_pa_s_per_m3"] * flow, abs=0.1)
    assert abs(prediction.ffr(prediction.pressures) - prediction.ffr(prediction.network_pressures)) > 1e-4
    assert not prediction.covers_lumen


def test_velocity_of_the_prediction_carries_the_flow(fork):
    folder, document = fork
    network, tree = _network(folder, document), centreline.read(folder / "centreline.vtp")
    prediction = coupled.Predictor(network, tree, document, settings_module.make())
    x = np.linspace(-1.5, 1.5, 61)
    y, z = np.meshgrid(x, x)
    inside = np.hypot(y, z) < 1.5
    points = np.stack([np.full(inside.sum(), 20.0), y[inside], z[inside]], axis=1) * 1e-3
    velocity, pressure = prediction.fields(points)
    assert velocity[:, 0].sum() * (x[1] - x[0]) ** 2 * 1e-6 == pytest.approx(prediction.flows[0], rel=0.02)
    assert pressure / MAP == pytest.approx(prediction.ffr(prediction.pressures), abs=2e-3)


@pytest.mark.parametrize("model", ["axisymmetric", "network"])
def test_a_reduced_model_answers_alone(tmp_path, monkeypatch, model):
    radius = tubes.lesion(1.2, 0.4, 5, 5)
    branches = [tubes.centre_branch(12.0, radius)]
    tubes.write_case(tmp_path, tubes.tube(12.0, radius, 0.5), branches)
    document = _document(branches, [1.5e-6], 10.0) | {"warnings": ["probe distal is near"]}
    (tmp_path / "boundary.json").write_text(json.dumps(document))
    line = ["--centreline", str(tmp_path / "centreline.vtp")]
    mesh = str(tmp_path / "mesh.msh")
    command_line.main(["mesh", str(tmp_path / "lumen.vtp"), *line, "--out", mesh, "--rings", "2"])
    command = ["solve", mesh, *line, "--boundary", str(tmp_path / "boundary.json"), "--out", str(tmp_path)]
    if model == "network":  # the network alone saves seconds
        monkeypatch.setattr(axisymmetric.Tube, "solve", lambda *_: pytest.fail("the axisymmetric model was solved"))
    command_line.main(command + ["--model", model])
    answer = json.loads((tmp_path / "ffr.json").read_text())
    assert model in answer["model"] and answer["error_estimate"] is None
    (said,) = [text for text in answer["warnings"] if "error of this FFR is not known" in text]
    assert model in said and "3D model in trees" in said and "probe distal is near" in answer["warnings"]
    assert answer["ffr"] == pytest.approx(answer["models"][model]["ffr"], abs=1e-4)
    other = answer["models"]["axisymmetric"]
    if model == "network":
        assert other == {"ffr": None, "reason": "not asked for"}
    else:
        assert answer["models"]["network"]["ffr"] != other["ffr"]
    assert (tmp_path / "solution.vtu").is_file() and (tmp_path / "pullback.csv").is_file()


def test_models_that_disagree_are_named():
    assert (
        solve.model_difference_warnings({"3d": {"ffr": 0.80}, "network": {"ffr": 0.82}, "axisymmetric": {"ffr": None}})
        == []
    )
    (said,) = solve.model_difference_warnings(
        {"3d": {"ffr": 0.80}, "network": {"ffr": 0.9}, "axisymmetric": {"ffr": 0.81}}
    )
    assert "3d 0.800" in said and "network 0.900" in said

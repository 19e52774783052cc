"""The commands `mesh` and `solve` compared with flows that are known exactly.

These are Poiseuille's flow, the flow of a Carreau-Yasuda fluid in a tube, and the creeping flow in a network of
resistors. Further, FFR must not change when the vessel is rotated, mirrored or scaled at the same Reynolds number.
"""

import json
import pathlib
import sys

import numpy as np
import pandas as pd
import pytest
import scipy.optimize

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[2] / "unit" / "flow")]

import tubes  # noqa: E402
from flow import __main__ as command_line  # noqa: E402
from flow import settings  # noqa: E402
from flow.geometry import centreline  # noqa: E402
from flow.physics import viscosity  # noqa: E402
from flow.reduced import network as network_model  # noqa: E402
from flow.geometry.surface import Surface  # noqa: E402

MAP, VENOUS, DENSITY = 12000.0, 600.0, 1060.0


def _document(branches, resistances, viscosity, map_pa=MAP, venous_pa=VENOUS):
    outlets = [
        {"name": f"outlet{k + 1}", "region_id": k + 2, "branch": branch.name, "resistance_pa_s_per_m3": resistance}
        for k, (branch, resistance) in enumerate(zip(branches, resistances))
    ]
    for outlet in outlets:
        outlet["flow_m3_per_s"] = (map_pa - venous_pa) / outlet["resistance_pa_s_per_m3"]
    main = branches[0]
    s_mm = 0.8 * main.length_mm
    probe = {"name": "distal", "branch": main.name, "s_mm": s_mm, "point_mm": main.point(s_mm).tolist()}
    return {
        "map_pa": map_pa,
        "venous_pressure_pa": venous_pa,
        "density_kg_per_m3": DENSITY,
        "viscosity_pa_s": viscosity,
        "outlets": outlets,
        "probes": [probe],
    }


def _solve(folder, surface, branches, document, parents=None, options=(), tolerance=()):
    """Meshes and solves a lumen by the commands; returns the document of ffr.json."""
    tubes.write_case(folder, surface, branches, parents)
    (folder / "boundary.json").write_text(json.dumps(document))
    line = ["--centreline", str(folder / "centreline.vtp")]
    command_line.main(["mesh", str(folder / "lumen.vtp"), *line, "--out", str(folder / "mesh.msh"), *options])
    boundary = ["--boundary", str(folder / "boundary.json")]
    command_line.main(["solve", str(folder / "mesh.msh"), *line, *boundary, "--out", str(folder), *tolerance])
    return json.loads((folder / "ffr.json").read_text())


def test_poiseuille(tmp_path):
    length, radius, viscosity = 8.0, 1.2, 0.004
    branches = [tubes.centre_branch(length, lambda s: radius)]
    document = _document(branches, [2e10], viscosity)
    answer = _solve(tmp_path, tubes.tube(length, lambda s: radius, 0.2), branches, document)
    flow = answer["inlet_flow_m3_per_s"]
    drop = 8 * viscosity * length * 1e-3 * flow / (np.pi * (radius * 1e-3) ** 4)
    assert MAP - answer["outlets"][0]["pressure_pa"] == pytest.approx(drop, rel=5e-4)


def _carreau_yasuda_slope(flow, radius, fluid):
    """Pressure gradient (Pa/m) that drives `flow` through a tube of `radius` (m); fluid: of physics.viscosity.

    Rabinowitsch: Q = pi R^3 / tau_w^3 times the integral of tau^2 rate over tau from 0 to tau_w, with tau = mu(rate)
    rate. The pressure gradient is 2 tau_w / R.
    """

    def through(wall_rate):
        rate = np.linspace(0, wall_rate, 20001)
        stress = fluid(rate) * rate
        square = stress**2 * rate
        integral = np.sum(0.5 * (square[1:] + square[:-1]) * np.diff(stress))
        return np.pi * radius**3 / stress[-1] ** 3 * integral, 2 * stress[-1] / radius

    wall_rate = scipy.optimize.brentq(lambda rate: through(rate)[0] - flow, 1e-2, 1e4, xtol=1e-10)
    return through(wall_rate)[1]


@pytest.mark.slow
def test_carreau_yasuda_tube(tmp_path):
    # The shear rate at the wall is about 25 /s, where the viscosity is far from both of its limits.
    length, radius, flow = 8.0, 1.2, 3e-8
    branches = [tubes.centre_branch(length, lambda s: radius)]
    document = _document(branches, [400.0 / flow], 0.004, 5000.0, 4600.0)
    document["viscosity"] = viscosity.from_settings(settings.make(viscosity_model="carreau_yasuda"))
    surface = tubes.tube(length, lambda s: radius, 0.2)
    answer = _solve(tmp_path, surface, branches, document, tolerance=["--residual-absolute", "1e-12"])
    line = pd.read_csv(tmp_path / "pullback.csv")
    # There the parabola of the inlet has changed into the velocity profile of this fluid.
    inner = line[(line["s_mm"] > 4.2) & (line["s_mm"] < 7.2)]
    slope = -np.polyfit(inner["s_mm"] * 1e-3, inner["pressure_pa"], 1)[0]
    fluid = viscosity.from_document(document)
    expected = _carreau_yasuda_slope(answer["inlet_flow_m3_per_s"], radius * 1e-3, fluid)
    print("slope", slope, "expected", expected)
    assert slope == pytest.approx(expected, rel=2e-3)


def test_carreau_yasuda_with_equal_viscosities_is_newtonian():
    newtonian = _carreau_yasuda_slope(3e-8, 1.2e-3, viscosity.CarreauYasuda(0.004, 0.004, 1.9, 1.25, 0.22))
    assert newtonian == pytest.approx(8 * 0.004 * 3e-8 / (np.pi * 1.2e-3**4), rel=1e-6)


@pytest.mark.slow
def test_unequal_outlets_of_a_creeping_flow_are_a_network_of_resistors(tmp_path):
    surface, branches = tubes.fork(length=16.0, at=7.0, side_length=7.0, edge_mm=0.5)
    parents = {"side1": ("main", 7.0)}
    document = _document(
        branches, [2e12, 2e14], 1.0
    )  # The Reynolds number is below 1e-3. The vessels take less than 1 % of the pressure.
    answer = _solve(tmp_path, surface, branches, document, parents, ["--cells-per-radius", "1.5", "--rings", "3"])
    anatomy = json.loads((tmp_path / "anatomy.json").read_text())
    sections = network_model.read_sections(tmp_path / "sections.csv")
    flows = network_model.Network(anatomy, sections, document, 1.14).solve()
    found = np.array([outlet["flow_m3_per_s"] for outlet in answer["outlets"]])
    without_vessels = (MAP - VENOUS) / np.array([2e12, 2e14])
    print("3D over network", found / flows - 1, "vessels", found / without_vessels - 1)
    assert found == pytest.approx(flows, rel=5e-4)
    assert (found < (1 - 2e-3) * without_vessels).all()
    for outlet, resistance in zip(answer["outlets"], (2e12, 2e14)):
        expected = VENOUS + resistance * outlet["flow_m3_per_s"]
        assert outlet["pressure_pa"] == pytest.approx(expected, rel=1e-12)
    assert answer["mass_imbalance"] < 1e-8


ROTATION = np.linalg.qr(np.array([[1.0, 2.0, 0.3], [-0.7, 1.1, 0.9], [0.2, -1.3, 1.7]]))[0]
ROTATION *= np.linalg.det(ROTATION)
SCALE = 1.25


def _lesion(transform, scale=1.0):
    """(Surface, [Branch]) of a bent tube with a lesion, its points mapped by the matrix `transform`."""
    length, axis = 16.0, tubes.arc(0.03)
    radius = tubes.lesion(1.2, 0.5, 6.0, 6.0)
    surface, line = tubes.tube(length, radius, 0.35, axis), tubes.centre_branch(length, radius, axis)
    triangles = surface.triangles if np.linalg.det(transform) > 0 else surface.triangles[:, ::-1]
    moved = Surface(surface.points @ transform.T, triangles, surface.region)
    points = line.points @ transform.T
    return moved, [centreline.Branch("main", 0, points, scale * line.s_mm, scale * line.radius_mm)]


def _ffr_of_lesion(folder, transform, scale=1.0):
    """FFR of the transformed lesion, with lengths times `scale` at the same Reynolds number.

    At that number speeds change by 1 / scale and pressures by 1 / scale^2.
    """
    surface, branches = _lesion(scale * transform, scale)
    map_pa, venous_pa = MAP / scale**2, VENOUS / scale**2
    document = _document(branches, [7e9 / scale**3], 0.004, map_pa, venous_pa)
    return _solve(folder, surface, branches, document, options=["--rings", "3"])["ffr"]


@pytest.fixture(scope="module")
def ffr_of_lesion(tmp_path_factory):
    """FFR of the lesion, not transformed."""
    return _ffr_of_lesion(tmp_path_factory.mktemp("lesion"), np.eye(3))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("transform", "scale"),
    [(ROTATION, 1.0), (np.diag([1.0, -1.0, 1.0]), 1.0), (np.eye(3), SCALE)],
    ids=["rotated", "mirrored", "scaled"],
)
def test_ffr_is_that_of_the_lesion_moved(tmp_path, ffr_of_lesion, transform, scale):
    found = _ffr_of_lesion(tmp_path, transform, scale)
    print("FFR", ffr_of_lesion, "moved", found - ffr_of_lesion)
    assert ffr_of_lesion < 0.92  # a lesion without a pressure drop would pass every transformation
    assert found == pytest.approx(ffr_of_lesion, abs=1e-4)

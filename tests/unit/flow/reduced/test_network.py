"""The one-dimensional network compared with Poiseuille's law, a resistor network, and the Borda-Carnot loss."""

import pathlib
import sys

import numpy as np
import pandas as pd
import pytest

import tubes
from common.errors import InputError
from flow.geometry import centreline
from flow.physics import viscosity
from flow.reduced import network as network_model

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "verification" / "flow"))

import fda_nozzle  # noqa: E402


MU, RHO = 0.004, 1060.0


def _document(resistances, branches, density=RHO):
    outlets = [
        {"name": f"outlet{k + 1}", "branch": name, "region_id": k + 2, "resistance_pa_s_per_m3": value}
        for k, (name, value) in enumerate(zip(branches, resistances))
    ]
    return {
        "map_pa": 12000.0,
        "venous_pressure_pa": 600.0,
        "density_kg_per_m3": density,
        "viscosity_pa_s": MU,
        "outlets": outlets,
    }


def _sections(profiles):
    tables = [
        pd.DataFrame({"branch": name, "s_mm": s, "area_mm2": np.pi * radius**2 + 0 * s})
        for name, s, radius in profiles
    ]
    return pd.concat(tables, ignore_index=True)


def _poiseuille(length_mm, radius_mm):
    return 8 * MU * length_mm * 1e-3 / (np.pi * (radius_mm * 1e-3) ** 4)


def test_single_tube_is_poiseuille():
    anatomy = {"branches": [{"name": "main", "parent": None, "s_on_parent_mm": None}]}
    network = network_model.Network(
        anatomy, _sections([("main", np.linspace(0, 50, 101), 1.4)]), _document([4e9], ["main"]), 1.14
    )
    assert network.solve()[0] == pytest.approx(11400 / (4e9 + _poiseuille(50, 1.4)), rel=1e-9)


def test_two_unequal_outlets_are_a_resistor_network_at_low_inertia():
    anatomy = {
        "branches": [
            {"name": "main", "parent": None, "s_on_parent_mm": None},
            {"name": "side1", "parent": "main", "s_on_parent_mm": 20.0},
        ]
    }
    s, t = np.linspace(0, 50, 101), np.linspace(0, 30, 61)
    sections = _sections([("main", s, 1.5), ("side1", t, 0.8)])
    document = _document([5e9, 4e10], ["main", "side1"], density=1e-9)
    flows = network_model.Network(anatomy, sections, document, 1.14).solve()
    r0, r1, r2 = _poiseuille(20, 1.5), _poiseuille(30, 1.5) + 5e9, _poiseuille(30, 0.8) + 4e10
    parallel = 1 / (1 / r1 + 1 / r2)
    node = 11400 * parallel / (r0 + parallel)
    assert flows == pytest.approx([node / r1, node / r2], rel=1e-9)


def test_a_side_branch_starts_with_the_total_pressure_before_its_junction():
    """Behind the junction the parent has less flow, so its pressure is higher. That must not count in the side branch.

    Without viscosity the total pressure is MAP plus the head at the inlet, all along and in the side branch too.
    """
    branches = [{"name": "main", "parent": None, "s_on_parent_mm": None}]
    branches.append({"name": "side1", "parent": "main", "s_on_parent_mm": 20.0})
    sections = _sections([("main", np.linspace(0, 50, 101), 0.7), ("side1", np.linspace(0, 30, 61), 0.9)])
    document = _document([5e9, 9e9], ["main", "side1"]) | {"viscosity_pa_s": 1e-12}
    network = network_model.Network({"branches": branches}, sections, document, 1.14)
    flows = np.array([1.6e-6, 0.7e-6])
    pressures = network.pressures(flows)
    for branch, flow, radius in (("main", flows[0], 0.7), ("side1", flows[1], 0.9)):
        total = pressures[branch][1][-1] + 0.5 * RHO * (flow / (np.pi * (radius * 1e-3) ** 2)) ** 2
        assert total == pytest.approx(12000 + 0.5 * RHO * (flows.sum() / (np.pi * 0.7e-3**2)) ** 2, rel=1e-6), branch


def test_expansion_loss_is_borda_carnot():
    s = np.linspace(0, 30, 301)
    radius = 1.5 * (1 - 0.5 * np.exp(-(((s - 10) / 2) ** 2)))
    anatomy = {"branches": [{"name": "main", "parent": None, "s_on_parent_mm": None}]}
    network = network_model.Network(anatomy, _sections([("main", s, radius)]), _document([4e9], ["main"]), 1.14)
    segment, flow = network.segments[0], 2e-6
    loss = segment.losses(flow, RHO, viscosity.Newtonian(0.0), 1.14)[-1]
    jump = flow / (np.pi * 0.75e-3**2) - flow / (np.pi * 1.5e-3**2)
    assert loss == pytest.approx(0.5 * 1.14 * RHO * jump**2, rel=1e-3)


def test_noise_on_the_areas_costs_little():
    s = np.linspace(0, 30, 301)
    area = np.pi * 1.5**2 * (1 + 0.01 * np.random.default_rng(0).normal(size=len(s)))
    assert (network_model._throat_of_each_section(area) < 0).all()


def test_resistances_at_a_fraction_of_the_flow():
    anatomy = {"branches": [{"name": "main", "parent": None, "s_on_parent_mm": None}]}
    sections = _sections([("main", np.linspace(0, 50, 101), 1.4)])
    network = network_model.Network(anatomy, sections, _document([4e9], ["main"]), 1.14)
    flows = network.solve()
    document = _document(network.resistances_at(flows, 0.3), ["main"])
    assert network_model.Network(anatomy, sections, document, 1.14).solve() == pytest.approx(0.3 * flows, rel=1e-8)


def test_sections_are_checked(tmp_path):
    path = tmp_path / "sections.csv"
    path.write_text("branch,s_mm,area_mm2\nmain,0,2.0\nmain,1,-2.0\n")
    with pytest.raises(InputError, match="row 3"):
        network_model.read_sections(path)
    path.write_text("branch,s_mm\nmain,0\n")
    with pytest.raises(InputError, match="area_mm2"):
        network_model.read_sections(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("branch,s_mm,area_mm2\nmain,0,2.0\nmain,1,wide\n", "area_mm2 is not a number(.|\n)*row 3(.|\n)*wide"),
        ("branch,s_mm,area_mm2\nmain,0,2.0\nmain,1,inf\n", "area_mm2 is not a number(.|\n)*row 3"),
        ("branch,s_mm,area_mm2\nmain,,2.0\nmain,1,2.0\n", "s_mm is not a number(.|\n)*row 2"),
        ("branch,s_mm,area_mm2\nmain,0,2.0\nmain,1,2.0\nside,1,2.0\nmain,1,2.1\n", "same s_mm(.|\n)*row 5"),
        ("", "not a table"),
        ("branch,s_mm,area_mm2\nmain,0,2.0\nmain,1,2.0,3.0\n", "not a table"),
    ],
)
def test_bad_sections_are_refused_by_their_line(tmp_path, text, words):
    path = tmp_path / "sections.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        network_model.read_sections(path)


def test_sections_of_another_lumen_are_refused():
    """Refused are sections of another state, sections in metres, sections of a file that was cut off, and those of a
    longer branch."""
    line = tubes.centre_branch(20.0, tubes.lesion(1.5, 0.5, 10, 8))
    own = _sections([("main", line.s_mm, line.radius_mm)])
    tree = centreline.Tree([line])
    network_model.check_sections(own, tree, "sections.csv")
    wider = own.assign(area_mm2=own["area_mm2"] * 1.9)  # as at an ostium
    network_model.check_sections(wider, tree, "sections.csv")
    network_model.check_sections(own[own["s_mm"] < 18.5], tree, "sections.csv")  # up to 2 radii (3 mm) may be missing
    plain, severe = (tubes.lesion(1.5, reduction, 10, 8)(line.s_mm) for reduction in (0.0, 0.62))
    for other in (
        own.assign(s_mm=own["s_mm"] / 1e3),
        own.assign(area_mm2=own["area_mm2"] / 100),
        own.assign(area_mm2=own["area_mm2"] * 100),
        own.assign(area_mm2=np.pi * severe**2),
        own[own["s_mm"] < 15],
        own.assign(s_mm=own["s_mm"] * 1.5),
    ):
        with pytest.raises(InputError, match="cross-sections of another(.|\n)*branch main"):
            network_model.check_sections(other, tree, "sections.csv")
    narrow = centreline.Tree([tubes.centre_branch(20.0, tubes.lesion(1.5, 0.62, 10, 8))])
    with pytest.raises(InputError, match="another lumen"):
        network_model.check_sections(own.assign(area_mm2=np.pi * plain**2), narrow, "sections.csv")


def test_a_sudden_expansion_is_a_lumen():
    """In the FDA's nozzle the tube behind the throat is suddenly three times as wide. There the rim of the throat
    limits the sphere on the axis. Refused are a tube without a throat, and one that is as narrow as the throat
    everywhere."""
    nozzle = fda_nozzle.make()
    tree, s = centreline.Tree([nozzle.branch]), nozzle.branch.s_mm
    own = _sections([("main", s, np.sqrt(nozzle.area_mm2 / np.pi))])
    behind = np.argmax(s > nozzle.expansion_mm)
    assert (
        np.sqrt(nozzle.area_mm2[behind] / np.pi) > network_model.LARGEST_RADIUS_RATIO * nozzle.branch.radius_mm[behind]
    )
    network_model.check_sections(own, tree, "sections.csv")
    for radius in (fda_nozzle.RADIUS, fda_nozzle.THROAT):
        with pytest.raises(InputError, match="cross-sections of another lumen"):
            network_model.check_sections(_sections([("main", s, np.full(len(s), radius))]), tree, "sections.csv")


def test_an_outlet_of_an_unknown_branch_is_refused():
    anatomy = {"branches": [{"name": "main", "parent": None, "s_on_parent_mm": None}]}
    sections = _sections([("main", np.linspace(0, 50, 11), 1.4)])
    with pytest.raises(InputError, match="side7"):
        network_model.Network(anatomy, sections, _document([4e9, 4e9], ["main", "side7"]), 1.14)

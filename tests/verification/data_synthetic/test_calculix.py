"""The slice compared with CalculiX, if that is installed. The parts that need no CalculiX are always tested."""

import shutil
import types

import numpy as np
import pytest

from common.documents import config, schema
from common.errors import ComputationError
from data_synthetic import __main__ as command
from data_synthetic import tree
from data_synthetic.reference.checks import against_calculix, calculix, calculix_case
from data_synthetic.reference.solid import laws
from data_synthetic.reference.treatment import devices

pytestmark = pytest.mark.slow


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed (Debian package calculix-ccx)")
def test_slice_and_calculix_agree_on_a_plastic_ring(tmp_path):
    loads = against_calculix.compare(tmp_path)["loads"]
    radii = [load["slice_radius_mm"] for load in loads]
    assert radii[1] > 1.5 * against_calculix.INNER_MM and radii[2] > 1.1 * against_calculix.INNER_MM  # plastic
    for load in loads:
        assert abs(load["radius_difference_percent"]) < 0.2
        assert load["largest_node_difference_mm"] < 0.003
    assert (tmp_path / "slices_vs_calculix.json").is_file()


def test_without_calculix_the_command_says_what_to_install(tmp_path, capsys):
    with pytest.raises(SystemExit) as caught:
        command.main(["reference-ccx", "--out", str(tmp_path / "out"), "--program", "no-such-program"])
    assert caught.value.code == 2 and "calculix-ccx" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_program_that_writes_nothing_is_an_error(tmp_path):
    with pytest.raises(ComputationError, match="did not finish"):
        against_calculix.calculix_positions("true", tmp_path)


def brick_volumes(coordinates, bricks):
    """(corners, triple products of three edges) of bricks (n, 8). CalculiX accepts only positive products."""
    corners = np.array([[coordinates[n] for n in brick] for brick in bricks])
    return corners, np.linalg.det(corners[:, [1, 3, 4]] - corners[:, [0]])


def test_mesh_of_the_deck_fills_the_ring():
    layer = against_calculix.ring_layer()
    corners, volume = brick_volumes(layer.coordinates, layer.elements[:, :8])
    assert volume.min() > 0, "right-handed: CalculiX refuses others"
    middles = np.array([[layer.coordinates[n] for n in element[16:]] for element in layer.elements])
    assert middles == pytest.approx(0.5 * (corners[:, :4] + corners[:, 4:]), abs=1e-12)
    on_lumen = np.linalg.norm(corners[layer.depth_index == 0][:, [0, 3], :2], axis=2)
    assert on_lumen == pytest.approx(against_calculix.INNER_MM), "face 6 holds nodes 4, 1, 5, 8"
    for node in (*layer.lumen_nodes, *layer.outer_nodes):
        low, high = (np.array(layer.coordinates[n]) for n in (node, node + layer.top_offset))
        assert high - low == pytest.approx([0, 0, calculix.LAYER_HEIGHT_MM])


def test_springs_hold_as_the_support_does():
    """The stiffnesses of the springs sum to support x circumference x height, in x and in y."""
    theta = np.pi * np.arange(48) / 24
    layer = calculix.build_layer(theta, np.full(48, 1.0), np.full(48, 2.0), 3)
    lines = calculix.support_lines(layer, 0.01)
    values = {direction: [] for direction in ("1", "2")}
    for at, line in enumerate(lines):
        if line.startswith("*SPRING"):
            values[lines[at + 1]].append(2 * float(lines[at + 2]))  # each element set has two nodes
    for found in values.values():
        assert sum(found) == pytest.approx(0.01 * 2 * np.pi * 2.0 * calculix.LAYER_HEIGHT_MM, rel=1e-4)


def test_the_whole_lumen_is_prescribed():
    theta = np.pi * np.arange(16) / 8
    layer = calculix.build_layer(theta, np.full(16, 1.0), np.full(16, 2.0), 3)
    numbers, above = layer.lumen_nodes_all_heights()
    assert len(numbers) == 2 * 16 + 8, "all nodes at both faces, corners between them"
    for node, place in zip(numbers, above):
        assert layer.coordinates[node][:2] == pytest.approx((np.cos(theta[place]), np.sin(theta[place])))
    moved = np.stack([theta, -theta], axis=1)
    values = [line.split(",") for line in layer.displacement_lines(moved)[1:]]
    found = {(int(n), int(d)): float(u) for n, d, _, u in values}
    assert found == {(n, d): pytest.approx(moved[k, d - 1]) for n, k in zip(numbers, above) for d in (1, 2)}


@pytest.fixture(scope="module")
def section():
    """A section of a small vessel's eccentric lesion, 1 mm from the lesion's centre."""
    vessel = {
        "seed": 7,
        "main": {"length_mm": 25, "ostial_diameter_mm": 3.0},
        "lesions": [{"centre_s_mm": 11, "length_mm": 8, "diameter_stenosis_percent": 60, "eccentricity": 0.5}],
    }
    main = tree.grow(schema.with_defaults(vessel, schema.read("vessel")))[0]
    settings = {"elements_around": 16, "elements_through": 4}
    return calculix_case.Section(types.SimpleNamespace(branch=main, wall_mm=0.7), 10.0, settings)


def test_both_codes_take_the_tissue_of_an_elements_middle(section):
    assert 0 < section.tissues[..., 0].mean() < 1, "plaque and wall"
    for column in (0, 5, 15):
        for depth in range(4):
            for turn, share in ((0.1, 0.1), (0.5, 0.9), (0.9, 0.5)):
                angle = 2 * np.pi * (column + turn) / 16
                rays = (section.inner, section.outer)
                inner, outer = (np.interp(angle, section.theta, ray, period=2 * np.pi) for ray in rays)
                radius = inner + (outer - inner) * (depth + share) / 4
                found = np.array(section.material(np.array([angle]), np.array([radius])))[:, 0]
                assert found == pytest.approx(section.tissues[column, depth])


def procedure_steps():
    predilatation = devices.Balloon("pre", 10.0, 8.0, 1.0, 1.2, 6.0, 1.0)
    delivery = devices.Balloon("des", 10.0, 10.0, 1.0, 1.5, 7.0, 1.1)
    stent = devices.Stent("stent", 5.0, 15.0, 0.95, 0.22, 20.0, 1.5, 0.5)
    return [
        devices.Step("predilatation", "predilatation", predilatation, None),
        devices.Step("stent", "stent", delivery, stent),
    ]


def test_mean_pressure_is_that_of_a_round_device_on_a_round_lumen():
    theta = np.pi * np.arange(32) / 16
    law = {"balloon_radius": 1.6, "balloon_stiffness": 6.0, "balloon_cap": 1.0, "balloon_share": 0.5}
    law |= {"stent_radius": 0.0, "stent_stiffness": 1.5, "stent_cap": 0.2, "stent_share": 0.0, "pressure": 0.02}
    lumen = 1.5 * np.stack([np.cos(theta), np.sin(theta)], axis=1)
    half = 0.5 * laws.device_pressure(1.5, 1.6, 6.0, 1.0, sqrt=np.sqrt)
    assert calculix_case.mean_pressure(lumen, law) == pytest.approx(0.02 + half, rel=1e-3)
    assert calculix_case.mean_pressure(lumen + [0.3, 0.0], law | {"balloon_share": 0.0}) == pytest.approx(
        0.02, rel=1e-9
    )


@pytest.fixture(scope="module")
def recorded(section):
    settings = config.load_section(None, "reference") | {"elements_around": 16, "elements_through": 4}
    return settings, calculix_case.solve_by_slice(section, procedure_steps(), 10.0, settings)


def test_a_uniform_pressure_comes_back_from_its_forces(section, recorded):
    """Forces are made from pressures a tenth above the slice's, at three heights. The rows must show this tenth."""
    _, entries = recorded
    whole = np.tile(np.arange(len(section.theta)), 3)
    forces = []
    for entry in entries:
        lumen = entry["lumen"]
        along = np.roll(lumen, -1, axis=0) - np.roll(lumen, 1, axis=0)
        push = 0.5 * np.stack([along[:, 1], -along[:, 0]], axis=1)  # normal times length of the nodes' polygon
        x, y = lumen.T
        polygon = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        push *= (
            1.1 * entry["pressure"] * calculix.LAYER_HEIGHT_MM * calculix_case.lumen_areas(lumen[None])[0] / polygon / 3
        )
        forces.append((lumen[whole], push[whole]))
    rows = calculix_case.comparison_rows(entries, forces, procedure_steps())
    assert [(row["step"], row["stage"]) for row in rows] == [
        (name, stage) for name in ("predilatation", "stent") for stage in ("inflated", "deflated")
    ]
    for row in rows:
        assert row["calculix_pressure_mpa"] == pytest.approx(1.1 * row["slice_pressure_mpa"], rel=1e-9)
    assert rows[0]["area_mm2"] > 1.2 * rows[1]["area_mm2"] and rows[3]["area_mm2"] > 1.2 * rows[1]["area_mm2"]
    # against a stiff balloon a difference of pressure changes the area little
    assert 0 < rows[2]["worth_in_area_percent"] < 0.5 * rows[3]["worth_in_area_percent"]


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed (Debian package calculix-ccx)")
def test_slice_and_calculix_agree_through_a_whole_procedure(section, recorded):
    settings, entries = recorded
    forces = calculix_case.solve_by_calculix(section, entries, settings, "ccx")
    rows = calculix_case.comparison_rows(entries, forces, procedure_steps())
    assert max(row["slice_pressure_mpa"] for row in rows) > 0.05
    for row in rows:
        assert abs(row["pressure_difference_mpa"]) < 0.005


@pytest.mark.parametrize("alone", ["--scene", "--truth"])
def test_scene_and_truth_go_together(alone, tmp_path, capsys):
    with pytest.raises(SystemExit) as caught:
        command.main(["reference-ccx", "--out", str(tmp_path / "out"), alone, "somewhere.json"])
    assert caught.value.code == 2 and "give both" in capsys.readouterr().err

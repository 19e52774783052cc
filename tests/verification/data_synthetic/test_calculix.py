"""The slice against CalculiX, where that is installed; what the command says and reads without it."""

import shutil

import numpy as np
import pytest

from common.errors import ComputationError
from data_synthetic import __main__ as command
from data_synthetic.reference import against_calculix


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


def test_mesh_of_the_deck_fills_the_ring():
    coordinates, elements, first = against_calculix.nodes_and_elements()
    corners = np.array([[coordinates[n] for n in element[:8]] for element in elements])
    edges = corners[:, [1, 3, 4]] - corners[:, [0]]
    volumes = np.linalg.det(edges)
    assert volumes.min() > 0, "right-handed: CalculiX refuses others"
    middles = np.array([[coordinates[n] for n in element[16:]] for element in elements])
    assert middles == pytest.approx(0.5 * (corners[:, :4] + corners[:, 4:]), abs=1e-12)
    on_lumen = np.linalg.norm(corners[first == 0][:, [0, 3], :2], axis=2)
    assert on_lumen == pytest.approx(against_calculix.INNER_MM), "face 6 holds nodes 4, 1, 5, 8"

"""The shipped stents on the bench: free recoil and radial strength by `vci crush`."""

import csv
import json
import subprocess

import pytest

from anatomy.planning import catalogue
from common.documents import config

STRENGTH_MPA = (0.20, 0.25)  # at losses of 5 and 10 % of the diameter, beyond the struts' yield
RECOIL_ABOVE_PERCENT = (-0.1, 0.3)  # of the one stated: film and hinges give back a little more than the hoop


def crush(program, devices, stent, folder):
    """Rows of `vci crush` by loss in percent."""
    scene = {
        "schema": "vci-scene-1",
        "lumen": "none.vtp",
        "centreline": "none.vtp",
        "patient": {"map_pa": 12000},
        "devices": devices,
        "procedure": [
            {"name": "s", "action": "stent", "devices": [{"device": stent, "centre_s_mm": 0, "pressure_bar": 11}]}
        ],
    }
    (folder / "scene.json").write_text(json.dumps(scene))
    command = [str(program), "crush", str(folder / "scene.json"), "--device", stent]
    result = subprocess.run(command, text=True, capture_output=True, timeout=200)
    assert result.returncode == 0, result.stderr
    return {float(row["diameter_loss_percent"]): row for row in csv.DictReader(result.stdout.splitlines())}


@pytest.mark.parametrize("diameter", [2.25, 3.0, 4.5])
def test_shipped_stents_recoil_and_crush_as_stated(binary, repo_root, tmp_path, diameter):
    families = config.load_devices(repo_root / "config" / "devices")
    stents = [name for name, family in families.items() if family["kind"] == "stent"]
    assert stents
    for name in stents:
        devices = catalogue.device_entries(families, name, diameter, 8, "test")
        stent = next(key for key, entry in devices.items() if entry["kind"] == "stent")
        rows = crush(binary("vci"), devices, stent, tmp_path)
        assert sorted(rows) == [1, 2, 5, 10]
        pressures = [float(rows[loss]["pressure_mpa"]) for loss in sorted(rows)]
        assert pressures == sorted(pressures) and pressures[0] < 0.6 * pressures[2]
        assert STRENGTH_MPA[0] <= pressures[2] < pressures[3] <= STRENGTH_MPA[1], name
        above = float(rows[1]["recoil_percent"]) - families[name]["recoil_percent"]
        assert RECOIL_ABOVE_PERCENT[0] <= above <= RECOIL_ABOVE_PERCENT[1], name
        assert float(rows[1]["residual"]) <= 3e-3

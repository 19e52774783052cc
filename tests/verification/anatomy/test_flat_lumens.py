"""A compressed artery, 1.2 x 5.0 mm at its ostium, by intravascular ultrasound: from the file to the deployed lumen."""

import json
import subprocess
import sys

import campaign_steps
import numpy as np
import pytest

from common import vtp

pytestmark = pytest.mark.slow

BY_HAND = "[{action: stent, devices: [{device: des, diameter_mm: 3.0, length_mm: 8, branch: main, "
BY_HAND += "centre_s_mm: 4.5, pressure_bar: 11}]}]"


def deployed(run, surface, folder, binary, plan):
    """(lumen before, lumen after, deployment.json)."""
    run(binary("lumen"), "process", surface, "--out", folder / "anatomy")
    case = folder / "case.yaml"
    text = campaign_steps.CASE.format(name="flat", path=surface)
    case.write_text(text.replace("plan: auto", f"plan: {plan}"))
    steps = dict(campaign_steps.steps_of(case, folder, binary("vci").parent))
    for step in ("plan", "scene", "deployment"):
        run(*steps[step])
    result = json.loads((folder / "vci" / "deployment.json").read_text())
    before, after = (vtp.read_triangles(folder / part / "lumen.vtp", "") for part in ("anatomy", "vci"))
    return before, after, result


@pytest.fixture
def run(repo_root):
    def run(*command):
        done = subprocess.run([str(c) for c in command], cwd=repo_root, text=True, capture_output=True, timeout=300)
        assert done.returncode == 0, done.stderr

    return run


def check(before, after, result):
    """The far walls of the slit are not held in place, and the device opens the lumen."""
    x, y = vtp.points(before), vtp.points(after)
    radius = np.array(before.GetPointData().GetArray("radius_mm"))
    far = np.linalg.norm(x[:, :2] - np.median(x[:, :2], axis=0), axis=1) > 4 * radius
    assert far.sum() >= 5 and np.all(np.linalg.norm(y - x, axis=1)[far] > 1e-3)
    area, area_before = (min(row["area_mm2"] for row in result[key]) for key in ("csa_profile", "csa_profile_before"))
    assert area > 1.05 * area_before


def test_a_surface_of_the_shared_data(shared_data, binary, run, tmp_path):
    surface = shared_data("multimoda/ivus_prestent_lumen_straight_mm.stl")
    check(*deployed(run, surface, tmp_path, binary, "auto"))


@pytest.mark.parametrize("plan", ["auto", BY_HAND], ids=["auto", "by hand"])
def test_the_shipped_contours(repo_root, binary, run, tmp_path, plan):
    before = repo_root / "config" / "patients" / "ivus_stent" / "before.csv"
    run(sys.executable, "-m", "anatomy", "contours", before, "--out", tmp_path / "source")
    check(*deployed(run, tmp_path / "source" / "lumen.vtp", tmp_path, binary, plan))

"""A balloon wider than the vessel across the mouth of a side branch: the carina moves, but it does not fold."""

import json
import subprocess

import pytest

pytestmark = pytest.mark.slow

CASE = """
kind: synthetic
description: A tight lesion at the mouth of a side branch, opened wider than the vessel.
patient: {lvm_g: 115, sbp_mmhg: 132, dbp_mmhg: 88}
vessel:
  seed: 7
  artery: lad
  main: {length_mm: 40, ostial_diameter_mm: 3.6, taper_percent_per_cm: 2, mean_curvature_per_mm: 0.03,
         max_curvature_per_mm: 0.06}
  side_branches:
    - {s_mm: 20, diameter_mm: 1.8, length_mm: 10, angle_deg: 45, azimuth_deg: 136}
  lesions:
    - {shape: focal, centre_s_mm: 20, length_mm: 10, diameter_stenosis_percent: 75, eccentricity: 0.37,
       direction_deg: 320, plaque: lipid}
plan:
  - action: stent
    devices:
      - {device: des, diameter_mm: 4.0, length_mm: 12, branch: main, centre_s_mm: 20, pressure_bar: 12}
  - action: postdilatation
    devices:
      - {device: non_compliant, diameter_mm: 5.0, length_mm: 12, branch: main, centre_s_mm: 20, pressure_bar: 12}
"""


SIDE_BRANCHES = """  side_branches:
    - {s_mm: 20, diameter_mm: 1.8, length_mm: 10, angle_deg: 45, azimuth_deg: 136}
"""


@pytest.fixture(scope="module")
def deploy(binary, run_module, repo_root, tmp_path_factory):
    """deploy(text of a case): its deployment.json."""

    def check(result):
        assert result.returncode == 0, result.stderr

    def call(*command):
        check(subprocess.run([str(c) for c in command], text=True, capture_output=True, timeout=200))

    def deployed(text):
        folder = tmp_path_factory.mktemp("carina")
        case, anatomy, scene = folder / "carina.yaml", folder / "anatomy", folder / "vci" / "plan.json"
        case.write_text(text)
        lumen, devices = folder / "source" / "lumen.vtp", repo_root / "config" / "devices"
        check(run_module("data_synthetic", "generate", case, "--out", folder / "source", timeout=200))
        call(binary("lumen"), "process", lumen, "--units", "mm", "--edge", 0.4, "--out", anatomy)
        check(
            run_module("anatomy", "plan", case, "--anatomy", anatomy, "--devices", devices, "--out", scene, timeout=60)
        )
        call(binary("vci"), "deploy", scene, "--out", folder / "out")
        return json.loads((folder / "out" / "deployment.json").read_text())

    return deployed


@pytest.fixture(scope="module")
def deployment(deploy):
    """deployment.json of the case."""
    return deploy(CASE)


def test_the_carina_does_not_fold(deployment):
    """Without the tissue between the branches, 62 pairs of triangles cross each other here."""
    assert not [w for w in deployment["warnings"] if "folded" in w]


def test_the_stent_opens_as_far_as_without_a_side_branch(deployment, deploy):
    """The side branch first runs through plaque. With healthy wall there, the stent opens to half of this area.

    The mouth in the eccentric plaque costs 7 % of the area. It cost 2 % with the same engine in the lumen of revision
    4646cc46, whose side branch began with a round end as wide as the branch. The bound is far from the half above.
    """
    assert CASE.count(SIDE_BRANCHES) == 1
    alone = deploy(CASE.replace(SIDE_BRANCHES, ""))
    assert deployment["minimal_stent_area_mm2"] == pytest.approx(alone["minimal_stent_area_mm2"], rel=0.1)


def test_struts_across_the_mouth_are_not_malapposed(deployment):
    """The wall of the side branch is up to 2 mm off the stent's surface at its mouth."""
    assert deployment["maximal_malapposition_mm"] < 0.4

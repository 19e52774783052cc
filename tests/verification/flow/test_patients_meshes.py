"""Patients of the study, from their case file to their three volume meshes of rising fineness."""

import json
import subprocess

import pytest

from flow.settings import make


@pytest.mark.long
@pytest.mark.parametrize("case", ["lad03", "rca02"])
def test_a_patients_lumen_has_three_swept_meshes(repo_root, binary, run_module, tmp_path, case):
    made = run_module("data_synthetic", "generate", f"config/cases/{case}.yaml", "--out", tmp_path / "source")
    assert made.returncode == 0, made.stderr
    command = [binary("lumen"), "process", tmp_path / "source" / "lumen.vtp", "--units", "mm", "--out", tmp_path]
    subprocess.run(command, check=True, capture_output=True)
    meshes = [tmp_path / name for name in ("mesh.msh", "coarsest.msh", "coarse.msh")]
    line = ["--centreline", tmp_path / "centreline.vtp"]
    done = run_module("flow", "mesh", tmp_path / "lumen.vtp", *line, "--out", meshes[0], "--coarse", *meshes[1:])
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "mesh.json").read_text())
    parts = [*report["coarse"], report]
    assert [part["swept"]["way"] for part in parts] == ["swept"] * 3
    assert [part["rings"] for part in parts] == [*make().coarse_rings, make().rings]
    cells = [part["cells"] for part in parts]
    assert cells == sorted(cells) and min(part["swept"]["cells"] / part["cells"] for part in parts) > 0.3


@pytest.mark.slow
def test_a_real_tree_of_six_ends_has_a_mesh(shared_data, binary, run_module, tmp_path):
    """Its junctions cannot be filled at first. So the ends of the swept stretches move."""
    surface = shared_data("multimoda/lca_tree_mm.stl")
    command = [binary("lumen"), "process", surface, "--units", "mm", "--out", tmp_path]
    subprocess.run(command, check=True, capture_output=True)
    assert len(json.loads((tmp_path / "anatomy.json").read_text())["ends"]) == 6
    line = ["--centreline", tmp_path / "centreline.vtp", "--rings", 2, "--model", "axisymmetric"]
    done = run_module("flow", "mesh", tmp_path / "lumen.vtp", *line, "--out", tmp_path / "mesh.msh")
    assert done.returncode == 0 and "ends of swept stretches move" in done.stderr, done.stderr
    report = json.loads((tmp_path / "mesh.json").read_text())
    assert report["swept"]["way"] == "swept" and report["swept"]["cells"] > 0.5 * report["cells"]
    assert report["unfolded_facets"] == 0

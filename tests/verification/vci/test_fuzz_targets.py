"""The fuzz targets of tests/fuzz read libFuzzer's seeds and mutants of these seeds, each target in one process."""

import os
import subprocess

import pytest

from fuzz_corpus import READERS, mutants, seeds
from fuzz_runs import count_read_files

MUTANTS = int(os.environ.get("VCI_FUZZ_TARGET_MUTANTS", 400))
SEED = os.environ.get("VCI_FUZZ_SEED", "")


@pytest.fixture(scope="module")
def files():
    return seeds()


@pytest.mark.parametrize("reader", READERS)
def test_each_reader_answers_or_refuses(binary, files, tmp_path, reader):
    target = binary(f"vci_fuzz_{reader}")
    assert count_read_files(target, tmp_path / "seeds", files[reader]) == len(files[reader])
    damaged = {f"mutant_{k}": content for k, content in enumerate(mutants(reader, files[reader], MUTANTS, SEED))}
    assert count_read_files(target, tmp_path / "mutants", damaged) < MUTANTS


@pytest.mark.slow
def test_seeds_are_read_in_every_form(binary, files, tmp_path):
    """The seeds have all forms of VTK's files: ASCII, base64 within the elements, appended raw or as base64, 32 or 64
    bits, and each of VTK's compressors."""
    (tmp_path / "scene.json").write_bytes(files["scene"]["plain"])
    assert len(files["lumen"]) == 25
    for form in files["lumen"]:
        for name in ("lumen", "centreline"):
            (tmp_path / f"{name}.vtp").write_bytes(files[name][form])
        command = [str(binary("vci")), "radius-correct", str(tmp_path / "scene.json"), "--out", str(tmp_path / "out")]
        result = subprocess.run(command, text=True, capture_output=True, timeout=30)
        assert result.returncode == 0, f"{form}: {result.stderr}"

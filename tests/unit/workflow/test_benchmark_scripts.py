"""The scripts of the benchmarks start: nobody runs them for days, while what they import changes."""

import os
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
RULES = "\n".join(path.read_text() for path in sorted((ROOT / "workflow/rules").glob("*benchmarks.smk")))
SCRIPTS = sorted(set(re.findall(r'script="(tests/[^"]+\.py)"', RULES)))


def test_there_are_scripts():
    assert len(SCRIPTS) > 8


@pytest.mark.parametrize("script", SCRIPTS)
def test_a_script_says_how_it_is_used(script, tmp_path):
    """Started like the rules do it, so that imports must be found from the script's own folder."""
    lone = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    run = subprocess.run(
        [sys.executable, str(ROOT / script), "--help"], cwd=tmp_path, capture_output=True, text=True, env=lone
    )
    assert run.returncode == 0, run.stderr
    assert "usage:" in run.stdout

"""The cache of compiled forms survives a program that was killed while it compiled."""

import os
import subprocess
import sys
import time

import pytest

pytest.importorskip("dolfinx")

PROGRAM = """
import ufl
from common import fenicsx
from dolfinx import fem, mesh
from mpi4py import MPI
domain = mesh.create_interval(MPI.COMM_SELF, 2, (0.0, 1.0))
one = fem.Constant(domain, 3.0)
print(fem.assemble_scalar(fenicsx.form(one * ufl.dx(domain))))
"""


def test_what_a_killed_program_left_is_compiled_anew(tmp_path, repo_root):
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(repo_root)}

    def run():
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, timeout=100
        )
        assert done.returncode == 0, done.stderr
        return float(done.stdout)

    assert run() == pytest.approx(3.0)
    ready = list((tmp_path / "fenics").glob("*.c.cached"))
    assert ready, "nothing was compiled: the test would show nothing"
    for file in ready:  # as after a kill: sources without the mark that they are ready
        file.unlink()
        long_ago = time.time() - 3600
        os.utime(file.with_suffix(""), (long_ago, long_ago))
    assert run() == pytest.approx(3.0)

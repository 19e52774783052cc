"""A deployment gives the same bits on every processor, and also if the last digits of its input differ."""

import os
import subprocess

import numpy as np
import pytest

from common import vtp
from vci.benchmarks.scenes import Tube, write_scene


def deployed(binary, folder, tunables=None, noise_mm=0.0):
    """Points (n, 3) of a deployed tube. noise_mm: largest random shift of its points; tunables: GLIBC_TUNABLES."""
    folder.mkdir()
    tube = Tube(length=20, lesion_length=7, edge=0.8)
    mesh = tube.mesh

    def noisy_mesh():
        points, *others = mesh()
        return points + noise_mm * np.random.default_rng(1).uniform(-1, 1, points.shape), *others

    tube = tube if not noise_mm else TubeWithMesh(tube, noisy_mesh)
    scene = write_scene(folder, tube)
    environment = {key: value for key, value in os.environ.items() if key != "GLIBC_TUNABLES"}
    environment |= {"GLIBC_TUNABLES": tunables} if tunables else {}
    command = [binary("vci"), "deploy", scene, "--out", folder / "out"]
    subprocess.run(command, check=True, capture_output=True, env=environment)
    return vtp.points(vtp.read_triangles(folder / "out" / "lumen.vtp", ""))


class TubeWithMesh:
    """A Tube with another mesh."""

    def __init__(self, tube, mesh):
        self.tube, self.mesh = tube, mesh

    def __getattr__(self, name):
        return getattr(self.tube, name)


@pytest.mark.slow
def test_the_processor_does_not_matter(binary, tmp_path):
    """The program uses the C library's functions without fused multiply-add, whatever else GLIBC_TUNABLES sets."""
    usual = deployed(binary, tmp_path / "usual")
    plain = deployed(binary, tmp_path / "plain", "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2")
    other = deployed(binary, tmp_path / "other", "glibc.malloc.check=0")
    assert np.array_equal(usual, plain) and np.array_equal(usual, other)


def test_the_last_digits_of_the_input_do_not_matter(binary, tmp_path):
    usual, noisy = deployed(binary, tmp_path / "usual"), deployed(binary, tmp_path / "off", noise_mm=1e-13)
    assert np.array_equal(usual, noisy)

"""numpy and OpenBLAS take the same functions on every processor that has them."""

import os
import subprocess
import sys

import pytest

from common import processor

AVX2 = ["sse2", "avx", "avx2", "fma"]
NAMES = ("OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES")


@pytest.mark.parametrize(
    "flags, kernel, disabled",
    [
        (["sse2", "avx"], None, None),
        (["sse2", "avx2"], None, None),
        (AVX2, processor.KERNEL, None),
        ([*AVX2, "avx512f"], processor.KERNEL, processor.AVX512),
    ],
)
def test_functions_for_avx2_are_chosen_where_they_run(flags, kernel, disabled):
    environment = {}
    processor.same_digits(environment, flags)
    assert [environment.get(name) for name in NAMES] == [kernel, disabled]


def test_the_users_choice_stays():
    environment = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": ""}
    processor.same_digits(environment, [*AVX2, "avx512f"])
    assert [environment[name] for name in NAMES] == ["Prescott", ""]


@pytest.mark.parametrize("part", ["anatomy", "data_synthetic", "flow", "whatif", "reports", "workflow"])
def test_every_part_chooses_before_numpy_is_loaded(repo_root, part):
    """Importing the part alone sets what this processor needs, and loads no numpy before."""
    expected = {}
    processor.same_digits(expected, processor.features())
    environment = {key: value for key, value in os.environ.items() if key not in NAMES}
    look = f"import {part}, os, sys; print([os.environ.get(n) for n in {NAMES}], 'numpy' in sys.modules)"
    command = [sys.executable, "-c", look]
    done = subprocess.run(command, cwd=repo_root, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == f"{[expected.get(name) for name in NAMES]} False"

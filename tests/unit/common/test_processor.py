"""numpy and OpenBLAS take the same functions on every processor that has them."""

import ast
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
        ([*AVX2, "avx512f", "avx512cd", "avx512dq"], processor.KERNEL, "AVX512F,AVX512CD,AVX512_SKX"),
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
    done = subprocess.run([sys.executable, "-c", look], **how(repo_root, environment))
    assert done.stdout.strip() == f"{[expected.get(name) for name in NAMES]} False"


def how(folder, environment):
    return {"cwd": folder, "env": environment, "capture_output": True, "text": True, "check": True}


def test_numpy_takes_no_function_for_avx_512(repo_root):
    """And it warns of no name in the list, as it would of one that this processor does not have."""
    environment = {key: value for key, value in os.environ.items() if key not in NAMES}
    look = (
        "import common, numpy; from numpy.core._multiarray_umath import __cpu_features__ as found;"
        " print([name for name in found if name.startswith('AVX512') and found[name]])"
    )
    done = subprocess.run([sys.executable, "-W", "always", "-c", look], **how(repo_root, environment))
    if {"avx2", "fma"} <= set(processor.features()):
        assert set(ast.literal_eval(done.stdout)).isdisjoint(processor.AVX512)
    assert "NPY_DISABLE" not in done.stderr

"""numpy and OpenBLAS take the same functions on every processor that has them, and one thread."""

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
        (AVX2, processor.OPENBLAS_KERNEL, None),
        ([*AVX2, "avx512f", "avx512cd", "avx512dq"], processor.OPENBLAS_KERNEL, "AVX512F,AVX512CD,AVX512_SKX"),
    ],
)
def test_functions_for_avx2_are_chosen_where_they_run(flags, kernel, disabled):
    environment = {}
    processor.limit_to_avx2(environment, flags)
    assert [environment.get(name) for name in NAMES] == [kernel, disabled]


@pytest.mark.parametrize(
    "flags, name", [(["sse2", "avx"], "x86-64"), (AVX2, "x86-64-v3"), ([*AVX2, "avx512f"], "x86-64-v3"), ([], "native")]
)
def test_compiled_forms_need_no_more_than_avx2(flags, name):
    assert processor.architecture(flags) == name


def test_the_users_choice_stays():
    environment = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "", "OMP_NUM_THREADS": "3"}
    processor.limit_to_avx2(environment, [*AVX2, "avx512f"])
    processor.limit_to_one_thread(environment)
    assert list(environment.values()) == ["Prescott", "", "3"]


@pytest.mark.parametrize("part", ["anatomy", "data_synthetic", "flow", "whatif", "reports", "workflow"])
def test_every_part_chooses_before_numpy_is_loaded(repo_root, part):
    """Importing the part alone sets what this processor needs, and loads no numpy before."""
    expected = {"OMP_NUM_THREADS": "1"}
    processor.limit_to_avx2(expected, processor.cpu_flags())
    names = (*NAMES, "OMP_NUM_THREADS")
    environment = {key: value for key, value in os.environ.items() if key not in names}
    look = f"import {part}, os, sys; print([os.environ.get(n) for n in {names}], 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", look], **chosen_kernels(repo_root, environment))
    assert done.stdout.strip() == f"{[expected.get(name) for name in names]} False"


def chosen_kernels(folder, environment):
    return {"cwd": folder, "env": environment, "capture_output": True, "text": True, "check": True}


def test_numpy_takes_no_function_for_avx_512(repo_root):
    """And it warns of no name in the list, as it would of one that this processor does not have."""
    environment = {key: value for key, value in os.environ.items() if key not in NAMES}
    look = (
        "import common, numpy; from numpy.core._multiarray_umath import __cpu_features__ as found;"
        " print([name for name in found if name.startswith('AVX512') and found[name]])"
    )
    done = subprocess.run([sys.executable, "-W", "always", "-c", look], **chosen_kernels(repo_root, environment))
    if {"avx2", "fma"} <= set(processor.cpu_flags()):
        assert set(ast.literal_eval(done.stdout)).isdisjoint(processor.AVX512_FLAGS)
    assert "NPY_DISABLE" not in done.stderr

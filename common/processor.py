"""The same last digits on every processor.

numpy and OpenBLAS choose their functions by the processor, and different functions round differently. The last
digits of a vessel then depend on the machine, and all results that are made of it differ.
common/processor.hpp does the same for C++.
"""

import os
import pathlib
import sys

# With these left out numpy takes its functions for AVX2, which every processor with AVX-512 has too.
AVX512 = "AVX512F,AVX512CD,AVX512_SKX,AVX512_CLX,AVX512_CNL,AVX512_ICL"
KERNEL = "Haswell"  # of OpenBLAS: for AVX2 and fused multiply-add


def same_digits(environment, flags):
    """Sets the variables for numpy and OpenBLAS in `environment` (a dict), unless the user has set them.

    flags: the processor's features as Linux names them. Without AVX2 and fused multiply-add nothing is set, because
    these functions would not run.
    """
    if not {"avx2", "fma"} <= set(flags):
        return
    environment.setdefault("OPENBLAS_CORETYPE", KERNEL)
    if "avx512f" in flags:
        environment.setdefault("NPY_DISABLE_CPU_FEATURES", AVX512)


def features():
    """The features of this machine's processor; none where the system does not tell."""
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    return next((line.split(":")[1].split() for line in lines if line.startswith("flags")), [])


if "numpy" not in sys.modules:  # a loaded library has chosen already
    same_digits(os.environ, features())

"""The same last digits on every processor, whatever its number of cores.

numpy and OpenBLAS choose their functions by the processor, and different functions round differently. The last digits
of a vessel's coordinates would depend on the machine, and so would all results that follow from them.
common/processor.hpp does the same for C++. Several threads add numbers in another order than one, so there is one
thread unless the user sets OMP_NUM_THREADS.
"""

import os
import pathlib
import sys

# {numpy's name of a part of AVX-512: the flag by which Linux shows that the processor has this part}. If the parts are
# disabled, numpy uses its functions for AVX2. Parts that the processor lacks are not named to numpy, which would warn.
AVX512_FLAGS = {
    "AVX512F": "avx512f",
    "AVX512CD": "avx512cd",
    "AVX512_SKX": "avx512dq",
    "AVX512_CLX": "avx512_vnni",
    "AVX512_CNL": "avx512vbmi",
    "AVX512_ICL": "avx512_vbmi2",
}
OPENBLAS_KERNEL = "Haswell"  # OpenBLAS's name of its functions for AVX2 and fused multiply-add


def limit_to_avx2(environment, flags):
    """Sets the variables for numpy and OpenBLAS in `environment` (a dict), unless the user has set them.

    flags: the processor's features as Linux names them. Without AVX2 and fused multiply-add nothing is set, because the
    functions for AVX2 would not run.
    """
    if architecture(flags) != "x86-64-v3":
        return
    environment.setdefault("OPENBLAS_CORETYPE", OPENBLAS_KERNEL)
    if disabled := [name for name, flag in AVX512_FLAGS.items() if flag in flags]:
        environment.setdefault("NPY_DISABLE_CPU_FEATURES", ",".join(disabled))


def architecture(flags):
    """The architecture that compiled code may use, as compilers name it: x86-64-v3 (AVX2) at most.

    It is x86-64 on processors without AVX2 and fused multiply-add, `native` on other kinds of processor. Those with
    both have the rest of x86-64-v3 too. flags: as in `limit_to_avx2`.
    """
    if "sse2" not in flags:  # every x86-64 has it
        return "native"
    return "x86-64-v3" if {"avx2", "fma"} <= set(flags) else "x86-64"


def cpu_flags():
    """The features of this machine's processor; none where the system does not tell."""
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    return next((line.split(":")[1].split() for line in lines if line.startswith("flags")), [])


def limit_to_one_thread(environment):
    """Sets the number of threads of numerical libraries in `environment` (a dict) to 1, unless the user has set it."""
    environment.setdefault("OMP_NUM_THREADS", "1")


if "numpy" not in sys.modules:  # numpy, once loaded, has chosen its functions and threads already
    limit_to_one_thread(os.environ)
    limit_to_avx2(os.environ, cpu_flags())

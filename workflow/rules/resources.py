"""The resources that steps request from a cluster (docs/workflow.md): `mem_mb` in MB, `runtime` in minutes.

Memory is a fourth more than measured, time several times as much; both grow with the attempt. Steps without an entry
take the profile's defaults. A run on one machine ignores these figures.
"""

import math
import pathlib

# Benchmarks: they measure seconds, so a node and all its memory (0, for Slurm) belong to each, and some take hours.
NODE = {"sbatch_options": "--exclusive", "mem_mb": 0, "runtime": 720}


def fixed(megabytes, minutes):
    """Resources of a step whose cost hardly depends on its input: {name: function, as Snakemake calls it}."""
    return by_size((megabytes, 0), (minutes, 0))


def by_size(megabytes, minutes, *names):
    """Resources of a step whose cost follows the size of its inputs `names`: {name: function, as Snakemake calls it}.

    megabytes, minutes: (without input, per MB of input).
    """

    def asked(cost):
        return lambda wildcards, input, attempt: attempt * math.ceil(cost[0] + cost[1] * _megabytes(input, names))

    return {"mem_mb": asked(megabytes), "runtime": asked(minutes)}


def _megabytes(input, names):
    """Size of the inputs, a folder's with all its files.

    An input that is not made yet counts as empty; Snakemake asks again before it submits the step. A group of steps is
    submitted before its own files exist, so inputs made in the group always count as empty.
    """
    paths = [pathlib.Path(input[name]) for name in names]
    files = [file for path in paths for file in (path.rglob("*") if path.is_dir() else [path])]
    return sum(file.stat().st_size for file in files if file.is_file()) / 1e6

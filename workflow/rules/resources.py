"""The resources that steps request from a cluster (docs/workflow.md): `mem_mb` in MB, `runtime` in minutes.

Memory is a fourth more than was measured, time several times as much. Both grow with each new attempt at a step. Steps
without an entry take the defaults of the Snakemake profile. A run on one machine ignores these figures.
"""

import math
import pathlib

# Resources of a benchmark. It measures seconds, so it gets a whole node with all its memory (for Slurm, mem_mb 0).
# Some benchmarks take hours.
WHOLE_NODE = {"sbatch_options": "--exclusive", "mem_mb": 0, "runtime": 720}


def fixed_resources(megabytes, minutes):
    """{name of the resource: function for Snakemake} of a step whose cost hardly depends on its input."""
    return resources_by_size((megabytes, 0), (minutes, 0))


def resources_by_size(megabytes, minutes, *names):
    """{name of the resource: function for Snakemake} of a step whose cost grows with the size of its inputs `names`.

    megabytes, minutes: each (value for empty inputs, increase per MB of input).
    """

    def request(cost):
        return lambda wildcards, input, attempt: attempt * math.ceil(cost[0] + cost[1] * _input_size_mb(input, names))

    return {"mem_mb": request(megabytes), "runtime": request(minutes)}


def _input_size_mb(input, names):
    """Size in MB of the inputs `names` of a step. A folder counts with all its files.

    An input that is not made yet counts as empty. Snakemake asks again before it submits the step. But it submits a
    group of steps at once, so inputs that are made in the group always count as empty.
    """
    paths = [pathlib.Path(input[name]) for name in names]
    files = [file for path in paths for file in (path.rglob("*") if path.is_dir() else [path])]
    return sum(file.stat().st_size for file in files if file.is_file()) / 1e6

"""Describes this machine's processor, cores and memory, on which measured times depend."""

import os
import pathlib
import re

PROCESSOR_FILE, MEMORY_FILE = pathlib.Path("/proc/cpuinfo"), pathlib.Path("/proc/meminfo")
KIB_PER_GIB = 1024**2


def machine(processor_file=PROCESSOR_FILE, memory_file=MEMORY_FILE):
    """{"processor", "cores", "memory_gib"} of this machine, as Linux tells them.

    processor: name of the model, empty if Linux gives none, as on ARM. cores: number of logical cores; two threads of
    one core count twice. memory_gib: total memory in GiB, None if Linux does not tell.
    """
    name = re.search(r"^model name\s*: (.*)$", processor_file.read_text(), re.MULTILINE)
    memory = re.search(r"^MemTotal:\s*(\d+) kB$", memory_file.read_text(), re.MULTILINE)
    return {
        "processor": name[1] if name else "",
        "cores": os.cpu_count(),
        "memory_gib": round(int(memory[1]) / KIB_PER_GIB, 1) if memory else None,
    }

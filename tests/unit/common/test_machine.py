"""The machine as Linux tells it, and as the study records it with the versions of its software."""

import json

import jinja2
import pandas
import pytest

from common.machine import machine
from reports.__main__ import main
from reports.page.folder import three_version
from reports.study.software import software_versions

CPUINFO = "processor\t: 0\nmodel name\t: AMD EPYC 7B13\nprocessor\t: 1\nmodel name\t: AMD EPYC 7B13\n"
MEMINFO = "MemTotal:       24646656 kB\nMemFree:         1000000 kB\n"


@pytest.mark.parametrize(
    "cpuinfo, meminfo, processor, memory",
    [(CPUINFO, MEMINFO, "AMD EPYC 7B13", 23.5), ("processor\t: 0\nCPU part\t: 0xd0c\n", "", "", None)],
)
def test_processor_cores_and_memory(tmp_path, cpuinfo, meminfo, processor, memory):
    (tmp_path / "cpuinfo").write_text(cpuinfo)
    (tmp_path / "meminfo").write_text(meminfo)
    found = machine(tmp_path / "cpuinfo", tmp_path / "meminfo")
    assert (found["processor"], found["memory_gib"]) == (processor, memory) and found["cores"] >= 1


def test_the_study_records_its_machine(repo_root):
    assert software_versions(repo_root)["machine"] == machine()


def test_versions_of_what_makes_the_pages_are_recorded(tmp_path):
    """Tables, templates and the 3D viewer; three.js is no Debian package."""
    main(["software", "--out", str(tmp_path / "software.json")])
    found = json.loads((tmp_path / "software.json").read_text())["packages"]
    assert found["three.js"] == three_version() and list(found) == sorted(found)
    assert found["python3-pandas"].startswith(pandas.__version__)
    assert found["python3-jinja2"].startswith(jinja2.__version__)

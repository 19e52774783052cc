"""docs/bad-input.md lists bad and unusual inputs. Each is given to its program, which must answer as the page says."""

import os
import re
import resource
import subprocess

import pytest

import configuration_inputs  # noqa: F401
import contour_inputs  # noqa: F401
import flow_inputs  # noqa: F401
import image_inputs  # noqa: F401
import plan_inputs  # noqa: F401
import scene_inputs  # noqa: F401
import surface_inputs  # noqa: F401
from input_cases import INPUT_CASES
from places import ROOT

TIMEOUT_S, MEMORY_GIB = 60, 8
BAD_INPUT_PAGE = (ROOT / "docs" / "bad-input.md").read_text()


def table_rows(columns):
    """[(cell, ...)] of the rows of the page's tables that have this number of columns, without their heads."""
    lines = [line for line in BAD_INPUT_PAGE.splitlines() if line.startswith("| ")]
    cells = [[cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return [tuple(row) for row in cells if len(row) == columns and row[0] not in ("Input", "---")]


REFUSED, ACCEPTED = table_rows(4), table_rows(3)


def backticked(cell):
    """The texts in backticks of a cell."""
    found = re.findall(r"`([^`]+)`", cell)
    assert found, f"nothing in backticks: {cell}"
    return found


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_GIB << 30, MEMORY_GIB << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run_input_case(name, program, folder):
    """Makes an input and runs its command; returns (CompletedProcess, files that the command left in the folder)."""
    command = [str(word) for word in INPUT_CASES[name](folder)]
    words = (
        " ".join(command).replace("/usr/bin/python3 -m ", "").replace(f"{command[0]} ", f"{command[0].split('/')[-1]} ")
    )
    assert program.strip("`") in words, f"{program} is not in: {words}"
    if command[0].endswith(("/lumen", "/vci")) and not os.path.exists(command[0]):
        pytest.skip(f"{command[0]} is not built: run make build")
    before = set(folder.rglob("*"))
    variables = {**os.environ, "OMP_NUM_THREADS": "1"}
    options = {"cwd": ROOT, "env": variables, "capture_output": True, "text": True, "timeout": TIMEOUT_S}
    done = subprocess.run(command, preexec_fn=limit_memory, **options)
    return done, {path for path in folder.rglob("*") if path not in before and not path.is_dir()}


@pytest.mark.parametrize("name, program, code, said", REFUSED, ids=[row[0] for row in REFUSED])
def test_refused(tmp_path, name, program, code, said):
    done, made = run_input_case(name, program, tmp_path)
    assert done.returncode == int(code), done.stderr
    assert len(re.findall(r"^error: ", done.stderr, re.M)) == 1 and "\n  remedy: " in done.stderr, done.stderr
    assert "Traceback" not in done.stderr and not made, made
    for words in backticked(said):
        assert words in done.stderr, done.stderr


@pytest.mark.parametrize("name, program, result", ACCEPTED, ids=[row[0] for row in ACCEPTED])
def test_taken(tmp_path, name, program, result):
    done, made = run_input_case(name, program, tmp_path)
    assert done.returncode == 0, done.stderr
    files = {str(path.relative_to(tmp_path)) for path in made}
    for words in backticked(result):
        assert words in done.stdout or words in files, (done.stdout, files)


def test_the_page_has_every_input_once():
    names = [row[0] for row in REFUSED + ACCEPTED]
    assert sorted(names) == sorted(INPUT_CASES)
    assert len(REFUSED) >= 60 and len(ACCEPTED) >= 30

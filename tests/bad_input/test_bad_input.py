"""docs/bad-input.md: every input of its tables ends as the page says, by the programs themselves."""

import os
import re
import resource
import subprocess

import pytest

import given_configuration  # noqa: F401
import given_contours  # noqa: F401
import given_flow  # noqa: F401
import given_images  # noqa: F401
import given_plans  # noqa: F401
import given_scenes  # noqa: F401
import given_surfaces  # noqa: F401
from given import INPUTS, ROOT

SECONDS, MEMORY_GIB = 60, 8
PAGE = (ROOT / "docs" / "bad-input.md").read_text()


def rows(columns):
    """[(cells)] of the page's tables with so many columns, without their heads."""
    lines = [line for line in PAGE.splitlines() if line.startswith("| ")]
    cells = [[cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return [tuple(row) for row in cells if len(row) == columns and row[0] not in ("Input", "---")]


REFUSED, TAKEN = rows(4), rows(3)


def quoted(cell):
    """What stands in backticks."""
    found = re.findall(r"`([^`]+)`", cell)
    assert found, f"nothing in backticks: {cell}"
    return found


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_GIB << 30, MEMORY_GIB << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def judged(name, program, folder):
    """(CompletedProcess, files that are new in the folder) of the command that judges an input."""
    command = [str(word) for word in INPUTS[name](folder)]
    words = (
        " ".join(command).replace("/usr/bin/python3 -m ", "").replace(f"{command[0]} ", f"{command[0].split('/')[-1]} ")
    )
    assert program.strip("`") in words, f"{program} is not in: {words}"
    if command[0].endswith(("/lumen", "/vci")) and not os.path.exists(command[0]):
        pytest.skip(f"{command[0]} is not built: run make build")
    before = set(folder.rglob("*"))
    variables = {**os.environ, "OMP_NUM_THREADS": "1"}
    options = {"cwd": ROOT, "env": variables, "capture_output": True, "text": True, "timeout": SECONDS}
    done = subprocess.run(command, preexec_fn=limited, **options)
    return done, {path for path in folder.rglob("*") if path not in before and not path.is_dir()}


@pytest.mark.parametrize("name, program, code, said", REFUSED, ids=[row[0] for row in REFUSED])
def test_refused(tmp_path, name, program, code, said):
    done, made = judged(name, program, tmp_path)
    assert done.returncode == int(code), done.stderr
    assert len(re.findall(r"^error: ", done.stderr, re.M)) == 1 and "\n  remedy: " in done.stderr, done.stderr
    assert "Traceback" not in done.stderr and not made, made
    for words in quoted(said):
        assert words in done.stderr, done.stderr


@pytest.mark.parametrize("name, program, result", TAKEN, ids=[row[0] for row in TAKEN])
def test_taken(tmp_path, name, program, result):
    done, made = judged(name, program, tmp_path)
    assert done.returncode == 0, done.stderr
    files = {str(path.relative_to(tmp_path)) for path in made}
    for words in quoted(result):
        assert words in done.stdout or words in files, (done.stdout, files)


def test_the_page_has_every_input_once():
    names = [row[0] for row in REFUSED + TAKEN]
    assert sorted(names) == sorted(INPUTS)
    assert len(REFUSED) >= 60 and len(TAKEN) >= 30

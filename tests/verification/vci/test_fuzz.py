"""Seeded mutations of each file that `vci deploy` reads. The program answers or refuses with a message. It must not
crash."""

import base64
import functools
import os
import random
import resource
import struct
import subprocess

import pytest

from fuzz_corpus import NUMERICS, TUBE, mutate_bytes, replace_with_odd_value
from vci.benchmarks import scenes

MUTANTS = int(os.environ.get("VCI_FUZZ_MUTANTS", 60))
SEED = os.environ.get("VCI_FUZZ_SEED", "")  # another text gives other mutants than the usual ones
SECONDS = 30


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return scenes.write_scene(tmp_path_factory.mktemp("fuzz"), TUBE, length=6.0, numerics=NUMERICS)


def limits(sanitized):
    if not sanitized:  # the sanitizer's shadow memory takes terabytes of addresses
        resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


# A file of some kB needs no large allocation. Under the limit above such an allocation throws, and the program may
# refuse the file. The sanitizer's limit ends the program, so that the test fails.
SANITIZER = {"ASAN_OPTIONS": "max_allocation_size_mb=256"}


@functools.cache
def is_sanitized(program):
    return b"__asan_init" in program.read_bytes()


def assert_answers(program, scene, what):
    command = [str(program), "deploy", str(scene), "--out", str(scene.parent / "out")]
    sanitized = is_sanitized(program)
    result = subprocess.run(
        command,
        text=True,
        errors="replace",
        capture_output=True,
        timeout=SECONDS,
        preexec_fn=lambda: limits(sanitized),
        env=os.environ | (SANITIZER if sanitized else {}),
    )
    assert result.returncode in (0, 2, 3), f"{what}: exit code {result.returncode}: {result.stderr[-800:]}"
    assert result.returncode == 0 or "remedy:" in result.stderr, what


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lumen.vtp", "centreline.vtp", "scene.json"])
def test_bytes(binary, scene, name):
    file = scene.parent / name
    content, numbers = file.read_bytes(), random.Random(name + SEED)
    try:
        for k in range(MUTANTS):
            file.write_bytes(mutate_bytes(content, numbers))
            assert_answers(binary("vci"), scene, f"{name}, mutant {k}")
    finally:
        file.write_bytes(content)


@pytest.mark.slow
def test_values_of_the_scene(binary, scene):
    content, numbers = scene.read_text(), random.Random(5 if not SEED else SEED)
    try:
        for k in range(2 * MUTANTS):
            mutant, what = replace_with_odd_value(content, numbers)
            scene.write_text(mutant)
            assert_answers(binary("vci"), scene, f"mutant {k}: {what}")
    finally:
        scene.write_text(content)


def test_a_block_of_no_size(binary, scene):
    """VTK divides by the size of a compressed block that the file claims."""
    file = scene.parent / "lumen.vtp"
    content = file.read_bytes()
    start = content.index(b"_", content.index(b"<AppendedData")) + 1
    blocks, _, last, compressed = struct.unpack("<4I", base64.b64decode(content[start : start + 24]))
    assert blocks == 1
    claim = base64.b64encode(struct.pack("<4I", blocks, 0, last, compressed))
    try:
        file.write_bytes(content[:start] + claim + content[start + 24 :])
        command = [str(binary("vci")), "deploy", str(scene), "--out", str(scene.parent / "out")]
        result = subprocess.run(command, text=True, capture_output=True, timeout=SECONDS, env=os.environ | SANITIZER)
        assert result.returncode == 2 and "lumen.vtp" in result.stderr and "damaged" in result.stderr, result.stderr
    finally:
        file.write_bytes(content)


def test_the_unchanged_scene_is_read(binary, scene):
    """The unchanged scene passes all checks and is refused only when it finds no force balance.

    If a check of the files refused it, every mutant would be refused for the same reason.
    """
    command = [str(binary("vci")), "deploy", str(scene), "--out", str(scene.parent / "out")]
    result = subprocess.run(command, text=True, capture_output=True, timeout=SECONDS)
    assert result.returncode == 3 and "force balance" in result.stderr, result.stderr


@pytest.mark.parametrize("options", [["--every", "1"], ["--frames-every", "-1"], ["--out"]])
def test_command_line_that_is_not_understood(binary, scene, tmp_path, options):
    command = [str(binary("vci")), "deploy", str(scene), "--out", str(tmp_path / "out"), *options]
    result = subprocess.run(command, text=True, capture_output=True, timeout=SECONDS)
    assert result.returncode == 2 and result.stderr.count("error:") == 1
    assert "vci deploy --help" in result.stderr and not (tmp_path / "out").exists()

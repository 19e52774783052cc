"""Runs the study's programs for the benchmarks, among others to remesh a lumen or to make the shipped bifurcation."""

import json
import os
import pathlib
import resource
import subprocess
import sys

from common.errors import ComputationError

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config"


def run_program(command, budget=None):
    """Runs a program and returns (exit code, text of standard error, CPU seconds).

    The program is ended once it has used `budget` CPU seconds. Its exit code is then negative.
    """

    def limit_cpu_time():
        resource.setrlimit(resource.RLIMIT_CPU, (budget, budget + 5))

    process = subprocess.Popen(
        [str(c) for c in command],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        preexec_fn=limit_cpu_time if budget else None,
    )
    messages = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, messages, usage.ru_utime + usage.ru_stime


def process_lumen(programs, surface, units, edge, out):
    """Writes the anatomy of a surface, remeshed to the edge length `edge` (mm), to the folder `out`, unless it exists.

    programs: folder of the program lumen. units: unit of the surface. Raises ComputationError if the program fails.
    """
    if not (out / "lumen.vtp").is_file():
        code, messages, _ = run_program(
            [programs / "lumen", "process", surface, "--units", units, "--edge", edge, "--out", out]
        )
        if code:
            raise ComputationError("the lumen cannot be remeshed", str(surface), f"edge {edge} mm", messages.strip())


def case_scene(case, folder, files=None):
    """The scene (JSON) of a study's case, for a scene.json in `folder`.

    case: folder of the case. files: {`lumen`, `coarse_lumen`, `centreline`: file} for the scene; without `lumen` and
    `centreline` those of the study.
    """
    files = {key: case / "anatomy" / f"{key}.vtp" for key in ("lumen", "centreline")} | (files or {})
    scene = json.loads((case / "vci" / "scene.json").read_text(encoding="utf-8"))
    return scene | {key: os.path.relpath(file, folder) for key, file in files.items()}


def culotte_scene(programs, edge, folder, steps=None):
    """The scene (JSON) of the bifurcation in config/cases/culotte_bench.yaml, remeshed to the edge length `edge` (mm).

    programs: folder of the program lumen. folder: folder for the anatomy and the plan. The surface before remeshing is
    made once, in the folder above it. steps: the scene keeps this number of first steps; None: all. Raises
    ComputationError if a program fails.
    """
    case, source, plan = CONFIG / "cases" / "culotte_bench.yaml", folder.parent / "source", folder / "plan.json"
    if not (source / "lumen.vtp").is_file():
        _run_module("data_synthetic", "generate", case, "--out", source)
    process_lumen(programs, source / "lumen.vtp", "mm", edge, folder / "anatomy")
    _run_module(
        "anatomy", "plan", case, "--anatomy", folder / "anatomy", "--devices", CONFIG / "devices", "--out", plan
    )
    scene = json.loads(plan.read_text())
    return scene | {"procedure": scene["procedure"][:steps]}


def _run_module(*module):
    code, messages, _ = run_program([sys.executable, "-m", *module])
    if code:
        raise ComputationError("the bifurcation cannot be made", module[0], f"exit code {code}", messages.strip())

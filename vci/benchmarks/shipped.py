"""Makes a scene of the shipped bifurcation with any edge length, and remeshes lumens, by a study's own programs."""

import json
import pathlib
import sys

from common.errors import ComputationError
from vci.benchmarks.programs import run_program

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config"


def process_lumen(programs, surface, units, edge, out):
    """Writes the anatomy of a surface, remeshed to an edge length (mm), to the folder `out`, unless it is there.

    programs: folder of the program lumen. units: of the surface. Raises ComputationError if the program fails.
    """
    if not (out / "lumen.vtp").is_file():
        code, messages, _ = run_program(
            [programs / "lumen", "process", surface, "--units", units, "--edge", edge, "--out", out]
        )
        if code:
            raise ComputationError("the lumen cannot be remeshed", str(surface), f"edge {edge} mm", messages.strip())


def culotte_scene(programs, edge, folder, steps=None):
    """The scene (JSON) of the bifurcation in config/cases/culotte_bench.yaml, remeshed to an edge length (mm).

    programs: folder of the program lumen. folder: for the anatomy and the plan; its parent gets the bench's surface,
    made once. steps: number of first steps that the scene keeps; None: all. Raises ComputationError if a program fails.
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

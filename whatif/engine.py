"""One varied procedure: the engine computes the lumen after it, and the anatomy step measures that lumen."""

import json
import os
import pathlib
import subprocess

from common.errors import ComputationError, InputError, error_message
from common.files import write_json

# Exit codes of `vci` and `lumen` that say something about the procedure (docs/design.md): bad input, no convergence.
NO_ANSWER_EXIT_CODES = (2, 3)


class ProcedureFailed(ComputationError):
    """The engine or the anatomy step failed on a varied procedure; `reason` says why in a few words."""

    def __init__(self, where, reason):
        self.reason = reason
        super().__init__("a varied procedure has no answer", where, reason, "see the log")


def run_program(command):
    """Runs a command. Raises ProcedureFailed if it refuses its input or does not converge.

    Raises InputError if the program is missing, ComputationError if it ends in another way, as by a signal: such a
    failure says nothing about the procedure.
    """
    try:
        result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    except FileNotFoundError:
        raise InputError("no such program", command[0], "missing", "make build, or give --programs") from None
    if not result.returncode:
        return
    program, message = pathlib.Path(str(command[0])).name, error_message(result.stderr)
    if result.returncode not in NO_ANSWER_EXIT_CODES:
        value = f"exit code {result.returncode}; {message}"
        raise ComputationError("a varied procedure broke off", program, value, "run the step again")
    raise ProcedureFailed(program, message.partition("\n")[0].removeprefix("error: ").strip())


def deploy_and_measure(case, scene, folder):
    """Deploys a scene's procedure in the case's lumen before PCI, and measures the lumen after it.

    folder: made here, for all files that the programs write. Returns (content of deployment.json, folder of the new
    lumen's anatomy). Raises ProcedureFailed.
    """
    resolution_options = ["--edge", case.edge_mm, "--spacing", case.spacing_mm]
    folder.mkdir(parents=True, exist_ok=True)
    files = {key: case.anatomy() / f"{key}.vtp" for key in ("lumen", "centreline")}
    if "coarse_lumen" in scene:
        files["coarse_lumen"] = case.folder / "vci" / scene["coarse_lumen"]
    paths = {key: os.path.relpath(file.resolve(), folder.resolve()) for key, file in files.items()}
    write_json(folder / "scene.json", scene | paths)
    run_program([case.programs / "vci", "deploy", folder / "scene.json", "--out", folder])
    reference_options = ["--units", "mm", "--like", case.anatomy() / "anatomy.json"]
    run_program(
        [
            case.programs / "lumen",
            "process",
            folder / "lumen.vtp",
            *reference_options,
            *resolution_options,
            "--out",
            folder / "anatomy",
        ]
    )
    return json.loads((folder / "deployment.json").read_text()), folder / "anatomy"

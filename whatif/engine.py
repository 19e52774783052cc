"""One varied procedure: the engine computes the lumen after it, and the anatomy step measures that lumen."""

import json
import os
import pathlib
import subprocess

from common.errors import ComputationError, InputError
from common.files import write_json


class Refused(ComputationError):
    """The engine or the anatomy step failed on a varied procedure; `reason` says why in a few words."""

    def __init__(self, where, reason):
        self.reason = reason
        super().__init__("a varied procedure has no answer", where, reason, "see the log")


def run(command):
    """Runs a command. Raises Refused with the first line of its error, InputError if the program is missing."""
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    except FileNotFoundError:
        raise InputError("no such program", command[0], "missing", "make build, or give --programs") from None
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line.strip()] or [f"exit code {done.returncode}"]
        raise Refused(pathlib.Path(str(command[0])).name, said[0].removeprefix("error: ").strip())


def deployed(case, scene, folder):
    """Deploys a scene's procedure in the case's lumen before PCI, and measures the lumen after it.

    Returns (content of deployment.json, folder of the new lumen's anatomy). folder: created here, for all files of the
    programs. Raises Refused.
    """
    sizes = ["--edge", case.edge_mm, "--spacing", case.spacing_mm]
    folder.mkdir(parents=True, exist_ok=True)
    files = {key: case.anatomy() / f"{key}.vtp" for key in ("lumen", "centreline")}
    if "coarse_lumen" in scene:
        files["coarse_lumen"] = case.folder / "vci" / scene["coarse_lumen"]
    paths = {key: os.path.relpath(file.resolve(), folder.resolve()) for key, file in files.items()}
    write_json(folder / "scene.json", scene | paths)
    run([case.programs / "vci", "deploy", folder / "scene.json", "--out", folder])
    like = ["--units", "mm", "--like", case.anatomy() / "anatomy.json"]
    run([case.programs / "lumen", "process", folder / "lumen.vtp", *like, *sizes, "--out", folder / "anatomy"])
    return json.loads((folder / "deployment.json").read_text()), folder / "anatomy"

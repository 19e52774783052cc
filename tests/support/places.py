"""Where the tests and their scripts find what the repository does not hold: the built programs and the public data."""

import os
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]


def build_folder():
    """Folder of the built programs: VCI_BUILD_DIR if it is set, else build/."""
    return pathlib.Path(os.environ.get("VCI_BUILD_DIR", ROOT / "build"))


def lone_environment():
    """Variables for a program that runs apart from this process: no more than a flow needs."""
    variables = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": "1"}
    variables["HOME"] = str(pathlib.Path.home())  # without it Open MPI 5 does not start
    return variables | {"VCI_BUILD_DIR": str(build_folder().resolve())}


def public_data(name):
    """Path of a file or folder of the public test data, or None where it is absent.

    It is looked for in VCI_DATA_DIR, then in data/, then in shared/data beside the repository.
    """
    folders = [os.environ.get("VCI_DATA_DIR"), ROOT / "data", ROOT.parent / "shared" / "data"]
    paths = [pathlib.Path(folder) / name for folder in folders if folder]
    return next((path for path in paths if path.exists()), None)

"""What a study runs on: operating system, versions of packages and libraries, git revision, and the machine."""

import pathlib
import subprocess

from common.errors import InputError
from common.machine import machine

PACKAGES = (
    "g++",
    "libcgal-dev",
    "libeigen3-dev",
    "libfcl-dev",
    "libmumps-dev",
    "libvtk9-dev",
    "nlohmann-json3-dev",
    "libcli11-dev",
    "pybind11-dev",
    "python3",
    "python3-dolfinx",
    "python3-dolfinx-real",
    "python3-petsc4py",
    "libopenblas0-pthread",
    "python3-gmsh",
    "python3-vtk9",
    "python3-numpy",
    "python3-scipy",
    "python3-pandas",
    "python3-matplotlib",
    "python3-jinja2",
    "snakemake",
)
OS_RELEASE = pathlib.Path("/etc/os-release")


def software_versions(repository, bundled=None):
    """{"system", "machine", "revision", "modified", "packages": {name: version}}, the content of software.json.

    machine: result of common.machine. modified: whether files of the repository differ from its revision. Packages
    that are not installed are left out. bundled: {name: version} of libraries that come with the repository instead of
    a Debian package; they stand among the packages. Raises InputError outside a git repository.
    """
    release = dict(line.split("=", 1) for line in OS_RELEASE.read_text().splitlines() if "=" in line)
    listing = subprocess.run(
        ["dpkg-query", "-W", "-f", "${db:Status-Status}\t${Package}\t${Version}\n", *PACKAGES],
        capture_output=True,
        text=True,
        check=False,  # the exit code only reports packages that are not installed
    ).stdout
    rows = [line.split("\t") for line in listing.splitlines()]
    versions = {name: version for status, name, version in rows if status == "installed"} | (bundled or {})
    return {
        "schema": "vci-software-1",
        "system": release["PRETTY_NAME"].strip('"'),
        "machine": machine(),
        "revision": git_output(repository, "rev-parse", "HEAD"),
        "modified": bool(git_output(repository, "status", "--porcelain", "--untracked-files=no")),
        "packages": dict(sorted(versions.items())),
    }


def git_output(repository, *arguments):
    """Standard output of a git command in the repository's folder; InputError if it fails."""
    result = subprocess.run(["git", "-C", str(repository), *arguments], capture_output=True, text=True, check=False)
    if result.returncode:
        raise InputError("not a git repository", repository, result.stderr.strip(), "run it in the repository's folder")
    return result.stdout.strip()

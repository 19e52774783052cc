"""What the Slurm profile's status script says of a job, with and without accounting."""

import os
import pathlib
import subprocess

import pytest

STATUS = pathlib.Path(__file__).resolve().parents[2] / "config" / "profiles" / "slurm" / "status.sh"
FORGOTTEN = "echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1"
SILENT = "echo 'slurm_load_jobs error: Unable to contact slurm controller (connect failure)' >&2; exit 1"
NO_ACCOUNTS = "echo 'Slurm accounting storage is disabled' >&2; exit 1"


def known(state):
    """A controller that knows the job."""
    return f"echo 'JobId=7 JobName=deploy JobState={state} Reason=None Dependency=(null)'"


@pytest.mark.parametrize(
    "scontrol, sacct, expected",
    [
        (known("PENDING"), NO_ACCOUNTS, "running"),
        (known("RUNNING"), NO_ACCOUNTS, "running"),
        (known("COMPLETING"), NO_ACCOUNTS, "running"),
        (known("COMPLETED"), NO_ACCOUNTS, "success"),
        (known("FAILED"), NO_ACCOUNTS, "failed"),
        (known("NODE_FAIL"), NO_ACCOUNTS, "failed"),
        (known("OUT_OF_MEMORY"), NO_ACCOUNTS, "failed"),
        (known("TIMEOUT"), NO_ACCOUNTS, "failed"),
        (SILENT, NO_ACCOUNTS, "running"),
        (FORGOTTEN, NO_ACCOUNTS, "failed"),
        (FORGOTTEN, "echo COMPLETED", "success"),
        (FORGOTTEN, "echo 'CANCELLED by 1000'", "failed"),
    ],
)
def test_status(tmp_path, scontrol, sacct, expected):
    for name, body in (("scontrol", scontrol), ("sacct", sacct)):
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    run = subprocess.run([STATUS, "7"], env=environment, text=True, capture_output=True)
    assert run.stdout == f"{expected}\n"

"""The status that the Slurm profile's script prints for a job, with and without accounting."""

import os
import pathlib
import subprocess

import pytest

STATUS = pathlib.Path(__file__).resolve().parents[2] / "config" / "profiles" / "slurm" / "status.sh"
UNKNOWN_JOB = "echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1"
NO_CONTROLLER = "echo 'slurm_load_jobs error: Unable to contact slurm controller (connect failure)' >&2; exit 1"
NO_ACCOUNTS = "echo 'Slurm accounting storage is disabled' >&2; exit 1"


def controller_with_job(state):
    """Shell command that stands for scontrol and knows the job."""
    return f"echo 'JobId=7 JobName=deploy JobState={state} Reason=None Dependency=(null)'"


@pytest.mark.parametrize(
    "scontrol, sacct, expected",
    [
        (controller_with_job("PENDING"), NO_ACCOUNTS, "running"),
        (controller_with_job("RUNNING"), NO_ACCOUNTS, "running"),
        (controller_with_job("COMPLETING"), NO_ACCOUNTS, "running"),
        (controller_with_job("COMPLETED"), NO_ACCOUNTS, "success"),
        (controller_with_job("FAILED"), NO_ACCOUNTS, "failed"),
        (controller_with_job("NODE_FAIL"), NO_ACCOUNTS, "failed"),
        (controller_with_job("OUT_OF_MEMORY"), NO_ACCOUNTS, "failed"),
        (controller_with_job("TIMEOUT"), NO_ACCOUNTS, "failed"),
        (NO_CONTROLLER, NO_ACCOUNTS, "running"),
        (UNKNOWN_JOB, NO_ACCOUNTS, "failed"),
        (UNKNOWN_JOB, "echo COMPLETED", "success"),
        (UNKNOWN_JOB, "echo 'CANCELLED by 1000'", "failed"),
    ],
)
def test_status(tmp_path, scontrol, sacct, expected):
    for name, body in (("scontrol", scontrol), ("sacct", sacct)):
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    run = subprocess.run([STATUS, "7"], env=environment, text=True, capture_output=True)
    assert run.stdout == f"{expected}\n"

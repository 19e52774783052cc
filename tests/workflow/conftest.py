"""A copy of the repository with all products of the quick cohort. They are stand-ins, but up to date for Snakemake.

A test changes one file of such a copy. A dry run then tells which jobs Snakemake would run again, and why.
"""

import json
import os
import pathlib
import shutil
import subprocess

import pytest

SNAKEMAKE = "/usr/bin/snakemake"
ROOT = pathlib.Path(__file__).resolve().parents[2]
# The rules that show or record a case's results. They run again after any new figure or plan, because the study records
# seconds, commands and the revision.
RECORD = {"timings", "seconds", "software", "provenance", "numbers", "report", "crate"}
FOLDERS = ("devices", "frames", "assets", "cases", "data", "figures")  # names of the rules' outputs that are folders
NOT_COPIED = shutil.ignore_patterns(
    ".git", "build", "build-*", "results", ".snakemake", "__pycache__", "data", ".pytest_cache"
)


class Workspace:
    """A folder with the repository's files, in which Snakemake runs."""

    def __init__(self, folder):
        self.folder = folder

    def snakemake(self, *arguments, cohort="quick", cases="", environment=(), more=()):
        """Runs Snakemake and returns the CompletedProcess. more: further key=value pairs for --config."""
        selection = [f"cohort={cohort}", f"cases={cases}", *more]
        command = [SNAKEMAKE, "--cores", "2", "--nocolor", *arguments, "--config", *selection]
        variables = {**os.environ, **dict(environment)}
        return subprocess.run(command, cwd=self.folder, env=variables, text=True, capture_output=True)

    def planned_jobs(self, *arguments, cohort="quick", more=()):
        """The jobs that a dry run plans: dicts with name, wildcards, input, output, log, benchmark, reason."""
        record = self.folder / "jobs.jsonl"
        record.unlink(missing_ok=True)
        handler = ["--log-handler-script", str(ROOT / "tests" / "workflow" / "job_log.py")]
        run = self.snakemake("--dry-run", *handler, *arguments, cohort=cohort, more=more)
        assert run.returncode == 0, run.stdout + run.stderr
        return [json.loads(line) for line in record.read_text().splitlines()] if record.exists() else []

    def planned_rules(self, *arguments, cohort="quick", more=()):
        """{"rule" or "rule case" or "rule case state"} that a dry run would execute, without the rule all."""
        found = set()
        for job in self.planned_jobs(*arguments, cohort=cohort, more=more):
            words = [job["name"], *(job["wildcards"].get(key) for key in ("case", "state", "section"))]
            found.add(" ".join(word for word in words if word))
        return found - {"all"}

    def edit(self, name, old, new):
        """Replaces text in a file; the text must be there."""
        path = self.folder / name
        text = path.read_text()
        assert old in text, f"{name} does not hold {old!r}"
        path.write_text(text.replace(old, new, 1))

    def append(self, name, text):
        """Adds text at the end of a file."""
        with open(self.folder / name, "a") as stream:
            stream.write(text)


def copy_repository(folder):
    """A Workspace with the repository's files. Text files stand in for the programs, which a dry run never starts."""
    shutil.copytree(ROOT, folder, ignore=NOT_COPIED)
    (folder / "build" / "python").mkdir(parents=True)
    for program in ("vci", "lumen", "three.min.js", "python/flow_factors.so"):
        (folder / "build" / program).write_text(f"{program}\n")
    return Workspace(folder)


@pytest.fixture(scope="session")
def finished_study(tmp_path_factory):
    """A Workspace whose quick cohort counts as computed. Tests must not change it; they take `finished` instead."""
    workspace = copy_repository(tmp_path_factory.mktemp("finished") / "repository")
    for job in workspace.planned_jobs():
        for name in [*job["output"], *job["log"], *([job["benchmark"]] if job["benchmark"] else [])]:
            path = workspace.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.mkdir(exist_ok=True) if path.name in FOLDERS else path.write_text(f"{name}\n")
    run = workspace.snakemake("--forceall", "--touch")
    assert run.returncode == 0, run.stderr
    return workspace


@pytest.fixture
def finished(finished_study, tmp_path):
    """A copy of the finished study, with the files' times, that a test may change."""
    shutil.copytree(finished_study.folder, tmp_path / "repository", copy_function=shutil.copy2)
    return Workspace(tmp_path / "repository")


@pytest.fixture
def fresh(tmp_path):
    """A copy of the repository without any product."""
    return copy_repository(tmp_path / "repository")

"""Cohorts of randomly drawn patients, run in shards.

A shard is a part of the cohort and a study of its own, small enough for Snakemake to plan it in seconds.
"""

import concurrent.futures
import csv
import os
import pathlib
import shutil
import subprocess
import time

import yaml

from common.errors import InputError
from common.files import replacing
from data_synthetic import draw
from workflow.failed import failed_steps

SNAKEMAKE = "/usr/bin/snakemake"
SHARD_SIZE = 100  # patients of a shard; Snakemake plans them in some 10 s, and an interrupted run loses little
REDUCED_SETTINGS = {
    "flow": {"model": "axisymmetric"},
    "ct": {"enabled": False},
}  # the reduced flow model, and no CT
# Endings of the files that are removed from a finished patient. Snakemake can make them again from the others.
PRUNED_SUFFIXES = (".msh", ".vtu", ".vtp", ".stl", ".png", ".gz")
PROJECTED_COUNTS = (1000, 100_000)  # numbers of patients whose cost is projected
COST_COLUMNS = ("shard", "patients", "finished", "wall_s", "cpu_s", "made_mb", "kept_mb")


def draw_shards(count, seed, out, folder=pathlib.Path("config"), full=False, cores=1):
    """Draws patients 1 to `count` of a seed into shards below `out`; returns [(shard's folder, [case names])].

    Each shard is a configuration folder: study.yaml, devices, cases. full: whether to keep all settings of
    `folder`/study.yaml; otherwise REDUCED_SETTINGS replace some. Patient k of a seed is always the same, in the same
    shard, whatever the count. The file of a patient drawn before is kept. cores: patients drawn side by side. Raises
    InputError for a count or seed out of range.
    """
    draw.check(count, seed)
    out, folder = pathlib.Path(out), pathlib.Path(folder)
    if out.exists() and not (out / "shards").is_dir():
        raise InputError("folder of something else", out, "holds no shards", "another folder for the cohort")
    study = yaml.safe_load((folder / "study.yaml").read_text())
    for section, values in () if full else REDUCED_SETTINGS.items():
        study[section] = {**study.get(section, {}), **values}
    shards, missing = [], []
    for first in range(0, count, SHARD_SIZE):
        shard_folder = out / "shards" / f"{first // SHARD_SIZE + 1:04d}"
        numbers = range(first + 1, min(first + SHARD_SIZE, count) + 1)
        names = [f"seed{seed}_{number:06d}" for number in numbers]
        files = [shard_folder / "cases" / f"{name}.yaml" for name in names]
        missing += [(number, file) for number, file in zip(numbers, files) if not file.exists()]
        _write_if_changed(
            shard_folder / "study.yaml", yaml.safe_dump({**study, "cohorts": {"shard": names}}, sort_keys=False)
        )
        shutil.copytree(folder / "devices", shard_folder / "devices", dirs_exist_ok=True)
        shards.append((shard_folder, names))
    with concurrent.futures.ProcessPoolExecutor(cores) as pool:
        numbers, files = zip(*missing) if missing else ((), ())
        list(pool.map(draw.write_patient, [seed] * len(missing), numbers, files))  # an error cancels the draws left
    return shards


def run_shards(shards, cores, results=pathlib.Path("results"), dry_run=False, keep_all=False):
    """Runs the shards one after the other; returns a row of costs for each, also added to the shard's cost.csv.

    A patient that fails does not stop the others. dry_run: plan only, as many shards at once as there are cores, and
    write no cost.csv. keep_all: keep surfaces, meshes and fields too. A row's `computed` is False if Snakemake failed
    before any patient finished or had a step that failed, for example in a locked folder.
    """
    with concurrent.futures.ThreadPoolExecutor(cores if dry_run else 1) as pool:
        return list(pool.map(lambda shard: _run_shard(*shard, cores, pathlib.Path(results), dry_run, keep_all), shards))


def _run_shard(shard_folder, names, cores, results, dry_run, keep_all):
    """Runs or plans one shard; returns its row of costs."""
    targets = [f"{results}/cases/{name}/metrics.json" for name in names]
    command = [SNAKEMAKE, "--profile", "config/profiles/local", "--cores", str(cores), *targets]
    command += ["--config", f"folder={shard_folder}", "cohort=shard"] + ["--dry-run", "--quiet"] * dry_run
    start, since = time.monotonic(), int(time.time())  # rounded down, since a file's time stamp may lag behind
    with open(shard_folder / "snakemake.log", "w") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    row = {"shard": shard_folder.name, "patients": len(names), "wall_s": time.monotonic() - start}
    row |= {"cpu_s": usage.ru_utime + usage.ru_stime, "exit_code": process.returncode}
    finished = [name for name in names if (results / "cases" / name / "metrics.json").is_file()]
    row["computed"] = not row["exit_code"] or _any_patient_ended(results, names, finished, since)
    row |= {"finished": len(finished), "made_mb": _size_mb(results, names)}
    if not dry_run and not keep_all:
        for name in finished:
            prune_results(results / "cases" / name)
    row["kept_mb"] = _size_mb(results, names)
    if not dry_run:
        _add_cost(shard_folder / "cost.csv", row)
    return row


def _any_patient_ended(results, names, finished, since):
    """Whether any patient finished, or had a step that failed, at or after `since` (seconds since 1970).

    names: patients of the shard; finished: those of them with metrics.json.
    """
    if any((results / "cases" / name / "metrics.json").stat().st_mtime >= since for name in finished):
        return True
    return any(step["case"] in names for step in failed_steps(results, since))


def projected_costs(out, cores):
    """[{patients, core_hours, wall_hours, peak_gb, kept_gb}] for the finished patients and for PROJECTED_COUNTS.

    The cost of a patient is the mean over the finished ones, from the shards' cost.csv. wall_hours assumes that none of
    this machine's `cores` is ever idle. peak_gb: when the last shard has run and is not pruned yet. The list is empty
    if no patient is finished.
    """
    tables = [
        list(csv.DictReader(file.open(newline=""))) for file in sorted(pathlib.Path(out).glob("shards/*/cost.csv"))
    ]
    finished = sum(int(table[-1]["finished"]) for table in tables)
    if not finished:
        return []
    seconds = sum(float(row["cpu_s"]) for table in tables for row in table) / finished
    kept = sum(float(table[-1]["kept_mb"]) for table in tables) / finished
    made = sum(max(float(row["made_mb"]) for row in table) for table in tables) / finished
    return [
        {
            "patients": count,
            "core_hours": round(count * seconds / 3600, 1),
            "wall_hours": round(count * seconds / 3600 / cores, 1),
            "peak_gb": round((count * kept + min(count, SHARD_SIZE) * max(made - kept, 0)) / 1000, 2),
            "kept_gb": round(count * kept / 1000, 2),
        }
        for count in (finished, *PROJECTED_COUNTS)
    ]


def prune_results(case):
    """Removes surfaces, meshes, fields and pictures of a finished patient.

    Snakemake makes them again only if an input of the steps before the metrics has changed.
    """
    for file in pathlib.Path(case).rglob("*"):
        if file.is_file() and file.name.endswith(PRUNED_SUFFIXES):
            file.unlink()


def _add_cost(path, row):
    """Adds a row for this run to the shard's table, since a shard that was interrupted takes several runs."""
    new = not path.exists()
    with open(path, "a", newline="") as stream:
        table = csv.DictWriter(stream, COST_COLUMNS, extrasaction="ignore", lineterminator="\n")
        if new:
            table.writeheader()
        table.writerow({key: round(value, 1) if isinstance(value, float) else value for key, value in row.items()})


def _write_if_changed(path, text):
    """Writes a file only if its content changes, since a newer file makes Snakemake run steps again."""
    if not path.exists() or path.read_text() != text:
        with replacing(path) as partial:
            partial.write_text(text)


def _size_mb(results, names):
    """Size in MB of all files of the cases."""
    folders = [results / "cases" / name for name in names]
    files = (pathlib.Path(top) / name for folder in folders for top, _, found in os.walk(folder) for name in found)
    return sum(file.stat().st_size for file in files) / 1e6

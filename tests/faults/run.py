#!/usr/bin/env python3
"""Does faults to a small study, resumes it, compares with an undisturbed run; writes a table (CSV) and a page.

    /usr/bin/python3 tests/faults/run.py --seed 1 --kills 20 --out results/faults --page docs/faults.md
"""

import argparse
import csv
import pathlib
import random
import subprocess
import sys
import tempfile
import time

import faults
from study import Study

COLUMNS = (
    "name",
    "fault",
    "moment_s",
    "step",
    "exit_code",
    "said",
    "half_made",
    "resumed_exit_code",
    "products",
    "differ",
)
COLUMNS += ("not_tried",)
LIST_COLUMNS = ("half_made", "differ")
NEED_NAMESPACE = ("full_tmp",)
NEED_OWN_DISK = ("full_disk", "read_only")
FAULT_NAMES = ("kills", "terminated", "step_killed", "memory_limit", "two_runs", *NEED_NAMESPACE, *NEED_OWN_DISK)
PAGE_TEMPLATE = """# What happens when something breaks

A long study may be killed, run out of memory, or fill the disk. Does it leave half-written results, and can it be
resumed?

`make faults` tests this and writes this page (`tests/faults/run.py`, seed {seed}, {kills} kills). It disturbs a small
study: `quick_focal` up to its deployments and one flow in three dimensions. An undisturbed run of it leaves
{products} products (files). Each row of the table is a kind of fault. After it the run was resumed by `make unlock`
and the same command.

- "Half-made" counts the products under their final names after the fault that differ from the undisturbed run's. A
  later step could have read them.
- "Resumed" says how far the resumed run came.
- "Differ" counts its products that differ in any bit from the undisturbed run's, or are missing. Keys of seconds,
  memory and paths in JSON are left out.

The {kills} kills hit one run, which was resumed after each and compared at its end. In the row of a second run,
"resumed" is the end of the first run, and half-made products were not looked for.

| fault | exit code | what the run said | half-made | resumed | differ |
| --- | --- | --- | --- | --- | --- |
{rows}

The kills hit these steps (number of kills): {steps}.
"""


def faults_page(rows, seed):
    """The page of the rows."""
    kills = [row for row in rows if row["name"] == "kills"]
    steps = sorted({row["step"] for row in kills})
    shown = [row for row in rows if row["name"] != "kills"]
    if kills:
        half_made = sum((row["half_made"] for row in kills), [])
        shown.insert(0, {**kills[0], "fault": f"SIGKILL at {len(kills)} random moments", "half_made": half_made})
    lines = []
    for row in shown:
        if row.get("not_tried"):
            lines.append(f"| {row['fault']} | not tried: {row['not_tried']} | | | | |")
            continue
        again = "to the end" if row["resumed_exit_code"] == "0" else f"exit code {row['resumed_exit_code']}"
        words = row["said"].split(": '/")[0]  # without the path of this run's folder
        said = f"`{words}`" if words else "–"
        cells = row["fault"], row["exit_code"], said, len(row["half_made"]), again, len(row["differ"])
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    counts = ", ".join(f"{step} ({sum(row['step'] == step for row in kills)})" for step in steps)
    products = max(int(row["products"] or 0) for row in rows)
    return PAGE_TEMPLATE.format(
        seed=seed, kills=len(kills), products=products, rows="\n".join(lines), steps=counts or "none"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, help="of the moments of the kills (1)")
    parser.add_argument("--kills", type=int, default=20, help="number of kills (20)")
    parser.add_argument(
        "--only",
        nargs="*",
        metavar="FAULT",
        default=FAULT_NAMES,
        help="faults to do; others keep their rows (none: page only)",
    )
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for faults.csv")
    parser.add_argument("--page", type=pathlib.Path, help="Markdown page")
    options = parser.parse_args()
    if unknown := set(options.only) - set(FAULT_NAMES):
        parser.error(f"no such fault: {', '.join(sorted(unknown))}; known: {', '.join(FAULT_NAMES)}")
    table = options.out / "faults.csv"
    if options.only:
        with tempfile.TemporaryDirectory(prefix="vci-faults-", dir="/var/tmp") as top:  # one fault fills /tmp
            run_faults(options, pathlib.Path(top), table)
    rows = read_table(table)
    if options.page:
        options.page.write_text(faults_page(rows, options.seed))
    bad = [row for row in rows if row["half_made"] or row["differ"] or row["resumed_exit_code"] not in ("", "0")]
    sys.exit(1 if bad else 0)


def run_faults(options, top, table):
    """Causes each fault that the options name, in folders below `top`, and writes the table after each."""
    rows = [row for row in read_table(table) if row["name"] not in options.only]
    undisturbed = Study(top / "undisturbed")
    begin = time.monotonic()
    if undisturbed.run():
        sys.exit(undisturbed.output.read_text())
    seconds, right = time.monotonic() - begin, undisturbed.products()
    print(f"undisturbed: {len(right)} products in {seconds:.0f} s", flush=True)
    for name in options.only:
        if name == "kills":
            study = Study(top / "kills")
            found = faults.kills(study, right, seconds, options.kills, random.Random(options.seed))
        else:
            found = [run_fault(getattr(faults, name), top, undisturbed, right, seconds)]
        rows += [{"name": name, **row} for row in found]
        print(*found, sep="\n", flush=True)
        write_table(table, sorted(rows, key=lambda row: FAULT_NAMES.index(row["name"])))


def read_table(table):
    """The rows of a table that an earlier run wrote, lists as lists; none where there is no table."""
    if not table.is_file():
        return []
    with open(table, newline="") as stream:
        return [{**row, **{key: row[key].split() for key in LIST_COLUMNS}} for row in csv.DictReader(stream)]


def write_table(table, rows):
    """Writes the rows as CSV."""
    table.parent.mkdir(parents=True, exist_ok=True)
    with open(table, "w", newline="") as stream:
        out = csv.DictWriter(stream, COLUMNS, restval="", lineterminator="\n")
        out.writeheader()
        out.writerows({**row, **{key: " ".join(row.get(key, ())) for key in LIST_COLUMNS}} for row in rows)


def run_fault(fault, top, undisturbed, right, seconds):
    """The row of one fault, in a folder of its own; `not_tried` where mounting is not allowed."""
    folder = top / fault.__name__
    folder.mkdir()
    own_disk = fault.__name__ in NEED_OWN_DISK
    try:
        if fault.__name__ in NEED_NAMESPACE:
            subprocess.run(["unshare", "-m", "true"], check=True, capture_output=True)
        if own_disk:
            faults.mount(folder, "size=1g")
    except subprocess.CalledProcessError:
        return {"fault": fault.__doc__.split(".")[0], "not_tried": "mounting needs root"}
    try:
        study = Study(folder)
        study.undisturbed_bytes = undisturbed.result_bytes()
        return fault(study, right, seconds)
    finally:
        if own_disk:
            subprocess.run(["umount", str(folder)], check=True)


if __name__ == "__main__":
    main()

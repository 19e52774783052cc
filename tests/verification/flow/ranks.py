"""One MPI rank against two: /usr/bin/python3 tests/verification/flow/ranks.py --out DIR CASE[:RINGS] ...

A case of hard_cases.py on one mesh, its coarse one or one of RINGS rings, solved by one rank and by two. Writes
DIR/ranks.csv: case, dofs, ranks, ffr, factorizations, CPU seconds by section (the largest of a rank's: nothing counts
twice, a section is what its functions take without those of other sections), CPU seconds of the busiest rank and wall
seconds of the whole process, how many times faster two ranks are by both. A rank that waits for the other counts as
busy. Fails where two ranks' FFR differs by more than SAME.

    mpirun -n RANKS /usr/bin/python3 tests/verification/flow/ranks.py --worker FILE ARGUMENTS...

is one solve with the arguments of `python3 -m flow`, whose sections go to FILE.
"""

import argparse
import contextlib
import csv
import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(pathlib.Path(__file__).parent)]

SAME = 1e-6  # of FFR
COUNTS = (1, 2)
SECTIONS = ("start", "mesh", "reduced models", "assembly", "residuals", "factorization", "solves", "estimate", "rest")
COLUMNS = ("case", "dofs", "ranks", "ffr", "factorizations", *SECTIONS, "cpu_s", "wall_s", "cpu_ratio", "wall_ratio")
DIGITS = {"ffr": ".9f", "cpu_ratio": ".2f", "wall_ratio": ".2f"}  # of numbers; .1f the others


class Clock:
    """CPU seconds of this process by section, each without the sections called from within."""

    def __init__(self):
        self.spent, self.open, self.since = dict.fromkeys(SECTIONS, 0.0), ["rest"], time.process_time()

    def _mark(self):
        now = time.process_time()
        self.spent[self.open[-1]] += now - self.since
        self.since = now

    @contextlib.contextmanager
    def section(self, name):
        """What is done within belongs to the section."""
        self._mark()
        self.open.append(name)
        try:
            yield
        finally:
            self._mark()
            self.open.pop()

    def watch(self, owner, name, section):
        """From now on the function `name` of a module or class belongs to the section."""
        inner = getattr(owner, name)

        def timed(*given, **named):
            with self.section(section):
                return inner(*given, **named)

        setattr(owner, name, timed)


def worker(path, arguments):
    """On each rank: a solve by its command, its sections to the file `path`."""
    clock = Clock()
    clock.spent["start"], clock.open = time.process_time(), ["start"]
    from flow import __main__ as command_line
    from flow.discretisation import forms, parallel, spaces
    from flow.errors import error_estimate, place_errors
    from flow.reduced import extended
    from flow.solvers import linear, nonlinear

    clock._mark()
    clock.open = ["rest"]
    for owner, name, section in (
        (spaces, "read", "mesh"),
        (extended.Extended, "predictor", "reduced models"),
        (nonlinear.FlowProblem, "linearise", "assembly"),
        (forms.NavierStokes, "assembled", "residuals"),
        (linear.DirectSolver, "set_matrix", "factorization"),
        (linear.DirectSolver, "solve", "solves"),
        (linear.DirectSolver, "solve_all", "solves"),
        (error_estimate, "of", "estimate"),
        (place_errors, "write", "estimate"),
    ):
        clock.watch(owner, name, section)
    command_line.main(arguments)
    clock._mark()
    found = parallel.world().allgather(clock.spent)
    if parallel.first():
        busiest = max(sum(one.values()) for one in found)
        largest = {name: max(one[name] for one in found) for name in SECTIONS}
        pathlib.Path(path).write_text(json.dumps({**largest, "cpu_s": busiest}))


def run(folder, name, ranks, mesh):
    """Row of the table of a case whose files are in `folder`. Raises CalledProcessError."""
    out = folder / f"ranks{ranks}"
    out.mkdir(exist_ok=True)
    given = ["solve", mesh, "--boundary", "boundary.json", "--centreline", "centreline.vtp", "--out", str(out)]
    own = [sys.executable, str(pathlib.Path(__file__).resolve()), "--worker", str(out / "sections.json"), *given]
    mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)]
    if os.geteuid() == 0:
        mpirun.insert(1, "--allow-run-as-root")
    begin = time.perf_counter()
    with open(out / "solve.log", "w") as log:
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        subprocess.run([*mpirun, *own], cwd=folder, env=environment, stdout=log, stderr=log, check=True)
    wall = time.perf_counter() - begin
    answer, sections = (json.loads((out / file).read_text()) for file in ("ffr.json", "sections.json"))
    return {
        "case": name,
        "dofs": answer["dofs"],
        "ranks": ranks,
        "ffr": answer["ffr"],
        "factorizations": sum(one["factorizations"] for one in answer["meshes"]),
        **sections,
        "wall_s": wall,
    }


def pair(folder, name, mesh):
    """Rows of the table for one rank and two. Raises RuntimeError where their FFR differs."""
    for ranks in COUNTS:  # compiles the forms of each, which would count
        run(folder, name, ranks, mesh)
    one, two = (run(folder, name, ranks, mesh) for ranks in COUNTS)
    if not abs(one["ffr"] - two["ffr"]) <= SAME:
        raise RuntimeError(f"{name}: FFR {one['ffr']!r} by one rank, {two['ffr']!r} by two")
    two.update({f"{key}_ratio": one[f"{key}_s"] / two[f"{key}_s"] for key in ("cpu", "wall")})
    return [one, two]


def rounded(row):
    """A row as it is written."""
    return {
        key: f"{value:{DIGITS.get(key, '.1f')}}" if isinstance(value, float) else value for key, value in row.items()
    }


def main():
    """Runs the cases asked for and updates the table after each; rows of others stay."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="+", metavar="CASE[:RINGS]")
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    import growth
    import hard_cases

    arguments.out.mkdir(parents=True, exist_ok=True)
    table, rows = arguments.out / "ranks.csv", []
    if table.is_file():
        with open(table, newline="") as file:
            rows = list(csv.DictReader(file))
    for given in arguments.cases:
        name, _, rings = given.partition(":")
        folder, mesh = arguments.out / given.replace(":", "_"), "one.msh"
        hard_cases.write(name, folder)
        sizes = ["--rings", rings, "--out", mesh] if rings else ["--out", "fine.msh", "--coarse", mesh]
        growth.command(folder, "mesh", "lumen.vtp", "--centreline", "centreline.vtp", *sizes)
        label = f"{name}, {rings} rings" if rings else name
        rows = [row for row in rows if row["case"] != label] + [rounded(row) for row in pair(folder, label, mesh)]
        print(rows[-2:], flush=True)
        with open(table, "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--worker"]:
        worker(sys.argv[2], sys.argv[3:])
    else:
        main()

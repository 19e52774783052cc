"""FFR to a tolerance, its cost and error: python3 tests/verification/flow/tolerance.py --out DIR CASE:TOLERANCE ...

CASE is a straight tube of hard_cases.py. It is solved to an `ffr_tolerance` on the default's meshes. Writes
DIR/tolerance.csv: case, tolerance, rings of all meshes solved on, dofs of the mesh that gave the answer, ffr, its error
against axisymmetric.py, the error estimate, whether the answer claims to be within the tolerance, CPU seconds of
`flow mesh` and of `flow solve`, peak memory. Fails if an answer claims to be within its tolerance but is not.
"""

import argparse
import json
import pathlib
import resource
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

import growth  # noqa: E402
import hard_cases  # noqa: E402

COLUMNS = ("case", "tolerance", "rings", "dofs", "ffr", "error", "estimate", "met", "mesh_cpu_s", "cpu_s", "mib")


def children_seconds():
    """CPU seconds of the child processes that have ended."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def row(case, tolerance, folder):
    """Row of the table for a case, which is written, meshed and solved in `folder`."""
    hard_cases.write(case, folder)
    line, meshes = ["--centreline", "centreline.vtp"], ["mesh.msh", "--coarse", *hard_cases.COARSE_MESHES]
    begin = children_seconds()
    growth.command(folder, "mesh", "lumen.vtp", *line, "--out", *meshes)
    meshed = children_seconds() - begin
    solve = ["solve", *meshes, *line, "--boundary", "boundary.json"]
    growth.command(folder, *solve, "--out", tolerance, "--ffr-tolerance", tolerance)
    answer = json.loads((folder / tolerance / "ffr.json").read_text())
    report = json.loads((folder / "mesh.json").read_text())
    rings = {file: str(part["rings"]) for file, part in zip(hard_cases.COARSE_MESHES, report["coarse"])}
    rings["mesh.msh"] = str(report["rings"])
    error = answer["ffr"] - hard_cases.STRAIGHT[case].reference(answer["inlet_flow_m3_per_s"])
    estimate = answer["error_estimate"]["ffr"]
    if answer["tolerance_met"] and abs(error) > float(tolerance):
        raise SystemExit(f"{case} to {tolerance}: said to be within, but the error is {error:.5f}")
    return {
        "case": case,
        "tolerance": tolerance,
        "rings": " ".join(rings[one["mesh"]] for one in answer["meshes"]),
        "dofs": answer["dofs"],
        "ffr": f"{answer['ffr']:.5f}",
        "error": f"{error:+.4f}",
        "estimate": f"{estimate:.4f}",
        "met": "yes" if answer["tolerance_met"] else "no",
        "mesh_cpu_s": f"{meshed:.0f}",
        "cpu_s": f"{answer['cpu_seconds']:.0f}",
        "mib": f"{answer['peak_memory_mib']:.0f}",
    }


def main():
    """Runs the cases asked for and updates the table after each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="+", metavar="CASE:TOLERANCE", help=f"of {', '.join(hard_cases.STRAIGHT)}")
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    given = [one.partition(":")[::2] for one in arguments.cases]
    unknown = sorted({case for case, _ in given} - set(hard_cases.STRAIGHT))
    if unknown:
        parser.error(f"no straight tube: {', '.join(unknown)}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for case, tolerance in given:
        rows.append(row(case, tolerance, arguments.out / case))
        print(rows[-1], flush=True)
        growth.write(arguments.out / "tolerance.csv", COLUMNS, rows)


if __name__ == "__main__":
    main()

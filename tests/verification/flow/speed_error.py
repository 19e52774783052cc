"""Error of FFR against CPU seconds over the mesh sequence: tests/verification/flow/speed_error.py --out DIR STATE ...

The narrowed tube `single_62` is compared with the axisymmetric solution. A STATE (results/cases/<case>/<state>) is
compared with its own solution on FINEST rings, whose error estimate is in the table. All meshes of the default are
solved from coarse to fine, then the mesh of FINEST rings. The CPU seconds of a mesh include the solves on all coarser
meshes, because the default needs these too. `answers` marks the mesh at which the default would stop. Rows of OpenFOAM
come from the tables of against_openfoam.py (the same tube with given inflow) and against_openfoam_tree.py. Only
converged rows are taken.

Writes DIR/speed_error.csv (COLUMNS; `size` is the number of our unknowns or of OpenFOAM's cells) and speed_error.png.
"""

import argparse
import csv
import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

import growth  # noqa: E402
import hard_cases  # noqa: E402  (makes the packages of the repository known)

from common.errors import guarded  # noqa: E402

TUBE = "single_62"
SCATTER_LIMIT = 1e-4  # a run of simpleFoam counts as converged if FFR scatters less over the last iterations
DEFAULT = growth.DEFAULT
SEQUENCE = (*DEFAULT.coarse_rings, DEFAULT.rings)
FINEST = DEFAULT.rings + 1
COLUMNS = ("case", "solver", "mesh", "size", "cpu_s", "ffr", "error", "estimate", "answers")


def solve_meshes(folder, rings):
    """The entries `meshes` of ffr.json for meshes of these numbers of rings, from coarse to fine.

    A tolerance of 0 makes the solver use every mesh.
    """
    *coarse, fine = rings
    names = [f"r{fine}.msh", "--coarse", *(f"r{fine}_{count}.msh" for count in coarse)]
    sizes = ["--rings", fine, "--coarse-rings", *coarse]
    for name, radii in growth.SPACING.items():
        sizes += [f"--stations-{name}", radii * DEFAULT.rings / fine]
    line = ["--centreline", "centreline.vtp"]
    growth.command(folder, "mesh", "lumen.vtp", *line, "--out", *names, *sizes)
    out = f"r{fine}"
    growth.command(folder, "solve", *names, "--boundary", "boundary.json", *line, "--out", out, "--ffr-tolerance", 0)
    return json.loads((folder / out / "ffr.json").read_text())["meshes"]


def sequence_rows(case, folder, reference=None):
    """(rows of the table for the lumen in `folder`, FFR that errors refer to).

    reference: the true FFR; None to take FFR of the finest mesh.
    """
    meshes = [*zip(SEQUENCE, solve_meshes(folder, SEQUENCE))]
    finest = solve_meshes(folder, (*SEQUENCE[-2:], FINEST))[-1]
    meshes.append((FINEST, finest))
    truth = finest["ffr"] if reference is None else reference
    rows, cpu, answered = [], 0.0, False
    for rings, mesh in meshes:
        if "ffr" not in mesh or mesh["ffr"] is None:  # no flow was found on it
            continue
        cpu += mesh["cpu_seconds"]
        answers = not answered and (mesh["error_estimate"] or 1) <= DEFAULT.ffr_tolerance
        answered |= answers
        own = reference is None and rings == FINEST
        rows.append(
            {
                "case": case,
                "solver": "vci",
                "mesh": f"{rings} rings",
                "size": mesh["dofs"],
                "cpu_s": f"{cpu:.1f}",
                "ffr": f"{mesh['ffr']:.5f}",
                "error": "" if own else f"{mesh['ffr'] - truth:+.5f}",
                "estimate": "" if mesh["error_estimate"] is None else f"{mesh['error_estimate']:.5f}",
                "answers": "yes" if answers else "",
            }
        )
    return rows, truth


def tube_rows(table):
    """Rows of simpleFoam on the tube, from the table of against_openfoam.py."""
    return [
        simplefoam_row(TUBE, row["resolution"], row["cells"], row["solve_cpu_s"], row["ffr"], float(row["error"]))
        for row in read_table(table)
        if row["solver"] == "OpenFOAM" and row["outcome"] == "converged"
    ]


def tree_rows(table, case, truth):
    """Rows of simpleFoam on a state `case` ("<case> <state>"), from the table of against_openfoam_tree.py."""
    return [
        simplefoam_row(case, row["mesh"], row["cells"], row["cpu_s"], row["ffr"], float(row["ffr"]) - truth)
        for row in read_table(table)
        if row["state"] == case and float(row["scatter"]) < SCATTER_LIMIT
    ]


def simplefoam_row(case, mesh, cells, cpu, ffr, error):
    """A row of simpleFoam."""
    row = {"case": case, "solver": "simpleFoam", "mesh": mesh, "size": cells, "cpu_s": cpu, "ffr": ffr}
    return row | {"error": f"{error:+.5f}", "estimate": "", "answers": ""}


def read_table(path):
    """Rows of a CSV file."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def draw(rows, path):
    """Draws a panel for each case: absolute error against CPU seconds.

    Hollow marks are error estimates. A ring is round the mesh at which the default stops.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    cases = list(dict.fromkeys(row["case"] for row in rows))
    figure, axes = pyplot.subplots(1, len(cases), figsize=(4 * len(cases), 4), sharey=True, squeeze=False)
    for panel, case in zip(axes[0], cases):
        ours = [row for row in rows if row["case"] == case and row["solver"] == "vci"]
        theirs = [row for row in rows if row["case"] == case and row["solver"] != "vci"]
        plot_column(panel, [r for r in ours if r["error"]], "error", "o-", color="#0a5a94", label="vci, error")
        style = {"color": "#0a5a94", "markerfacecolor": "none", "alpha": 0.7, "label": "vci, estimate"}
        plot_column(panel, [r for r in ours if r["estimate"]], "estimate", "s--", **style)
        plot_column(panel, theirs, "error", "^", color="#c4622d", label="OpenFOAM's simpleFoam, error")
        for row in ours:
            at = float(row["cpu_s"]), abs(float(row["error"] or row["estimate"]))
            panel.annotate(row["mesh"], at, textcoords="offset points", xytext=(5, 5), fontsize=7)
            if row["answers"]:
                panel.plot(*at, "o", markersize=14, markerfacecolor="none", color="black", label="default stops here")
        style = {"color": "grey", "linewidth": 0.8, "linestyle": ":", "label": "tolerance of the default"}
        panel.axhline(DEFAULT.ffr_tolerance, **style)
        panel.set(xlabel="CPU seconds", title=case, xscale="log", yscale="log")
        panel.grid(True, which="both", alpha=0.25)
    axes[0][0].set_ylabel("error of FFR")
    labels = {label: handle for panel in axes[0] for handle, label in zip(*panel.get_legend_handles_labels())}
    figure.legend(labels.values(), labels, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=3, fontsize=8)
    figure.savefig(path, dpi=150, bbox_inches="tight")
    pyplot.close(figure)


def plot_column(panel, rows, column, style, **options):
    """Draws the absolute values of a column against CPU seconds."""
    if rows:
        panel.plot([float(r["cpu_s"]) for r in rows], [abs(float(r[column])) for r in rows], style, **options)


@guarded
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("states", nargs="*", type=pathlib.Path, metavar="STATE")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder of table, figure and the runs")
    parser.add_argument("--openfoam-tube", type=pathlib.Path, help="table of against_openfoam.py")
    parser.add_argument("--openfoam-tree", type=pathlib.Path, help="table of against_openfoam_tree.py")
    options = parser.parse_args()
    hard_cases.write(TUBE, options.out / TUBE)
    rows, _ = sequence_rows(TUBE, options.out / TUBE, hard_cases.STRAIGHT[TUBE].reference(hard_cases.FLOW))
    rows += tube_rows(options.openfoam_tube) if options.openfoam_tube else []
    for state in options.states:
        case, folder = f"{state.parent.name} {state.name}", options.out / f"{state.parent.name}_{state.name}"
        hard_cases.copy_state(state, folder)
        own, truth = sequence_rows(case, folder)
        rows += own + (tree_rows(options.openfoam_tree, case, truth) if options.openfoam_tree else [])
    growth.write(options.out / "speed_error.csv", COLUMNS, rows)
    draw(rows, options.out / "speed_error.png")


if __name__ == "__main__":
    main()

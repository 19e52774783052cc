"""What a first guess of the flow saves: python3 tests/verification/flow/starts.py --out DIR STATE ...

STATE is results/cases/<case>/flow/<state>, with the meshes of `flow mesh`. Each state is solved from rest, from the
flow of the reduced models where the solver uses it, and from the flow of the state `vci` where the study does so.
Writes DIR/starts.csv, a row for each state: factorizations and CPU seconds of each way, and by how much FFR of the
other ways differs from that from rest. An empty cell: the way is not used in this state. Rows of earlier runs stay
unless they are run again.
"""

import json
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).resolve().parents[3])]

import growth  # noqa: E402
from finer_mesh import anatomy_of, meshes_of, run_states  # noqa: E402

WAYS = ("rest", "reduced", "vci")
COLUMNS = ("state", *(f"{way}_{key}" for way in WAYS for key in ("factorizations", "cpu_s")), "difference")
# Newton's method from the reduced models' flow is what `flow solve` tries first; here it is switched off.
FROM_REST = """
from flow import __main__
from flow.solvers import predicted_start
predicted_start.try_predicted_flow = lambda *_: None
__main__.main()
"""
SAID_FROM_REDUCED = "from the reduced models' flow"  # in the log of a solve that begins there


def solved(state, folder, *options, program=("-m", "flow")):
    """(ffr.json, the log's text) of one solve of a state's meshes. folder: for its files."""
    folder.mkdir(parents=True, exist_ok=True)
    made = [state / mesh for mesh in meshes_of(state)]
    files = [made[-1], "--coarse", *made[:-1], "--boundary", state.parent / "boundary.json"]
    files += ["--centreline", anatomy_of(state) / "centreline.vtp", "--mesh-report", state / "mesh.json"]
    chosen = ["--settings", state.parents[1] / "settings" / "flow.json", *options]
    growth.command(folder, "solve", *files, *chosen, "--out", ".", program=program)
    return json.loads((folder / "ffr.json").read_text()), (folder / "solve.log").read_text()


def costs(way, answer):
    """Columns of the table for a way that led to `answer` (ffr.json)."""
    total = sum(mesh["factorizations"] for mesh in answer["meshes"])
    return {f"{way}_factorizations": total, f"{way}_cpu_s": f"{answer['cpu_seconds']:.0f}"}


def row_of(state, out):
    """Row of the table. state: folder of the state's meshes; out: folder for the files of its solves."""
    name = f"{state.parents[1].name}_{state.name}"
    rest, _ = solved(state, out / f"{name}_rest", program=("-c", FROM_REST))
    row, found = {"state": name.replace("_", " ")} | costs("rest", rest), []
    reduced, log = solved(state, out / f"{name}_reduced")
    if SAID_FROM_REDUCED in log:
        row |= costs("reduced", reduced)
        found.append(reduced["ffr"])
    if state.name not in ("pre", "vci"):
        centreline = state.parents[1] / "vci" / "anatomy" / "centreline.vtp"
        started, _ = solved(state, out / f"{name}_vci", "--start", state.parent / "vci", centreline)
        row |= costs("vci", started)
        found.append(started["ffr"])
    return row | ({"difference": f"{max(abs(ffr - rest['ffr']) for ffr in found):.1e}"} if found else {})


if __name__ == "__main__":
    run_states(__doc__.splitlines()[0], "starts.csv", COLUMNS, row_of)

"""A small straight tube, meshed and solved through the command line."""

import json

import tubes
from flow import __main__ as command_line

LENGTH, RADIUS = 8.0, 1.2  # mm
MU = 0.004  # Pa s


def make(folder):
    """Writes the files of a straight tube to `folder`; the commands make its mesh and boundary.json."""
    tubes.write_case(folder, tubes.tube(LENGTH, lambda s: RADIUS, 0.4), [tubes.centre_branch(LENGTH, lambda s: RADIUS)])
    command_line.main(
        ["mesh", str(folder / "lumen.vtp"), "--centreline", str(folder / "centreline.vtp")]
        + ["--out", str(folder / "mesh.msh"), "--cells-per-radius", "2.5"]
    )
    patient = ["--lvm-g", "60", "--sbp-mmhg", "120", "--dbp-mmhg", "80"]
    command_line.main(
        ["boundary", "--anatomy", str(folder / "anatomy.json"), *patient, "--out", str(folder / "boundary.json")]
    )
    return folder


def solve(case, out, **changes):
    """Solves with some boundary values replaced by `changes`, writes to `out`, and returns the document of ffr.json."""
    document = json.loads((case / "boundary.json").read_text())
    for key, value in changes.items():
        document[key] = value
    path = out / "boundary.json"
    path.write_text(json.dumps(document))
    arguments = ["solve", str(case / "mesh.msh"), "--boundary", str(path), "--out", str(out)]
    command_line.main(arguments + ["--centreline", str(case / "centreline.vtp")])
    return json.loads((out / "ffr.json").read_text())

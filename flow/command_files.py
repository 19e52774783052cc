"""The files that each command reads and writes.

arguments are always the parsed arguments of the command. Output of an earlier run is removed before the input is read.
"""

import pathlib

from common.errors import InputError
from flow import output
from flow.inputs.lumen_summary import ANATOMY_STEP_FILES


def remove_old_output(arguments):
    """Removes the files that an earlier run with the same outputs wrote (flow.output). Raises InputError."""
    files_of = {
        "boundary": boundary_files,
        "mesh": mesh_files,
        "solve": solve_files,
        "audit": audit_files,
        "rank": rank_files,
    }
    written, read = files_of[arguments.command](arguments)
    output.remove_old_output(written, [pathlib.Path(path) for path in (*read, arguments.settings) if path])


def boundary_files(arguments):
    """(files written, files read) of `flow boundary`."""
    centreline = arguments.centreline or pathlib.Path(arguments.anatomy).with_name("centreline.vtp")
    return [pathlib.Path(arguments.out)], [arguments.anatomy, centreline, arguments.case]


def mesh_report_path(arguments):
    """Path of the report of `flow mesh`."""
    return pathlib.Path(arguments.json or pathlib.Path(arguments.out).with_suffix(".json"))


def mesh_files(arguments):
    """(files written, files read) of `flow mesh`.

    Raises InputError for a mesh name that does not end in .msh, or a file that would replace another one.
    """
    meshes = [pathlib.Path(path) for path in (arguments.out, *arguments.coarse)]
    for path in meshes:
        if path.suffix != ".msh":
            raise InputError("not the name of a gmsh mesh", "--out, --coarse", path, "let it end in .msh")
    written = [*meshes, mesh_report_path(arguments)]
    read = [path for path in (arguments.lumen, arguments.centreline, arguments.settings) if path]
    files = [pathlib.Path(path).resolve() for path in (*read, *written)]
    for k, path in enumerate(files[len(read) :], start=len(read)):
        if path in files[:k]:
            raise InputError("a file would replace another", "--out, --coarse, --json", path, "give each its own name")
    return written, read


def pair_with_rings(coarse, rings):
    """[(path, rings)] of the coarser meshes, the coarsest first.

    coarse: paths; rings: setting coarse_rings. With fewer paths than rings, the last of `rings` are used. Raises
    InputError for more paths than rings.
    """
    if len(coarse) > len(rings):
        remedy = "give at most one for each of coarse_rings"
        raise InputError("more coarse meshes than coarse_rings", "--coarse", f"{len(coarse)} files, {rings}", remedy)
    return list(zip(coarse, rings[len(rings) - len(coarse) :]))


def mesh_paths(arguments):
    """Paths of the meshes to solve on, the coarsest first. Raises InputError for a file that is missing.

    Coarser meshes with an empty file are passed over: `flow mesh` has left them out.
    """
    for path in (arguments.mesh, *arguments.coarse):
        if not pathlib.Path(path).is_file():
            raise InputError("no such mesh", path, "missing", "make it with `flow mesh`")
    return [*(path for path in arguments.coarse if pathlib.Path(path).stat().st_size), arguments.mesh]


def anatomy_and_sections(arguments):
    """(anatomy.json, sections.csv) of `flow solve`: as given, else beside the centreline."""
    folder = pathlib.Path(arguments.centreline).parent
    return arguments.anatomy or folder / "anatomy.json", arguments.sections or folder / "sections.csv"


def require_file(path, option):
    """Returns `path`. Raises InputError if no file is there; the message names `option`, which gives the path."""
    if not pathlib.Path(path).is_file():
        raise InputError("no such file", path, "missing", f"leave it beside the centreline, or give {option}")
    return path


def _solve_inputs(arguments):
    """Files that `flow solve` or `flow audit` reads."""
    meshes = [arguments.mesh, *arguments.coarse]
    read = [*meshes, arguments.boundary, arguments.centreline, arguments.mesh_report]
    read += [pathlib.Path(path).with_suffix(".json") for path in meshes]
    if getattr(arguments, "start", None):
        read += [pathlib.Path(arguments.start[0]) / name for name in output.FILES] + [arguments.start[1]]
    return [*read, arguments.lumen, *anatomy_and_sections(arguments)]


def solve_files(arguments):
    """(files written, files read) of `flow solve`."""
    return [pathlib.Path(arguments.out) / name for name in output.FILES], _solve_inputs(arguments)


def audit_files(arguments):
    """(files written, files read) of `flow audit`. Raises InputError if the output's name does not end in .json."""
    written = pathlib.Path(arguments.out)
    if written.suffix != ".json":
        raise InputError("not the name of a JSON file", "--out", written, "let it end in .json")
    return [written, written.with_suffix(".csv")], _solve_inputs(arguments)


def rank_files(arguments):
    """(files written, files read) of `flow rank`."""
    folders = [pathlib.Path(plan.partition("=")[2]) for plan in arguments.plans]
    read = [folder / name for folder in folders for name in ANATOMY_STEP_FILES]
    return [pathlib.Path(arguments.out)], [arguments.boundary, *arguments.measured, *read]

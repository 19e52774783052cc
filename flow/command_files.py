"""The files that each command reads and writes.

`arguments` are always the parsed arguments of the command. Output of an earlier run is removed before the input is
read, so that no old output is left if the command fails.
"""

import pathlib

from common.errors import InputError
from flow import output
from flow.inputs.lumen_summary import ANATOMY_STEP_FILES

# {command: (function that lists the files it writes, ending that the names given by --out and --coarse must have)}
WRITTEN = {
    "boundary": (lambda arguments: [arguments.out], ""),
    "mesh": (lambda arguments: [arguments.out, *arguments.coarse, mesh_report_path(arguments)], ".msh"),
    "solve": (lambda arguments: [pathlib.Path(arguments.out) / name for name in output.FILES], ""),
    "audit": (lambda arguments: [arguments.out, pathlib.Path(arguments.out).with_suffix(".csv")], ".json"),
    "rank": (lambda arguments: [arguments.out], ""),
}


def remove_old_output(arguments):
    """Removes the files that an earlier run with the same outputs wrote (flow.output).

    Raises InputError for an output that would replace an input or another output, or whose name has the wrong ending.
    """
    outputs = ("out", "coarse", "json") if arguments.command == "mesh" else ("out",)
    files_written, ending = WRITTEN[arguments.command]
    for name in (arguments.out, *(arguments.coarse if "coarse" in outputs else ())):
        if not name.endswith(ending):
            raise InputError("not the name of such a file", "--out, --coarse", name, f"let it end in {ending}")
    written = [pathlib.Path(path) for path in files_written(arguments)]
    output.remove_old_output(written, _files_read({k: v for k, v in vars(arguments).items() if k not in outputs}))


def _files_read(given):
    """Paths of the files that a command may read, whether they exist or not.

    given: {name: value} of the command's arguments, without those that name outputs.
    """
    values = [text for value in given.values() for text in (value if isinstance(value, list) else [value])]
    texts = [text for text in values if isinstance(text, str)]
    texts += [text.partition("=")[2] for text in texts if "=" in text]  # the folder of NAME=FOLDER in `flow rank`
    paths = [pathlib.Path(text) for text in texts]
    in_folders = [path / name for path in paths for name in (*ANATOMY_STEP_FILES, *output.FILES)]
    reports = [path.with_suffix(".json") for path in paths if path.suffix == ".msh"]
    lumens = [pathlib.Path(given[name]) for name in ("centreline", "anatomy") if given.get(name)]
    return [*paths, *in_folders, *reports, *(path.with_name(name) for path in lumens for name in ANATOMY_STEP_FILES)]


def mesh_report_path(arguments):
    """Path of the report of `flow mesh`."""
    return pathlib.Path(arguments.json or pathlib.Path(arguments.out).with_suffix(".json"))


def pair_with_rings(coarse, rings):
    """[(path, number of rings)] of the coarser meshes, the coarsest first.

    coarse: paths; rings: setting coarse_rings, the number of rings of cells across the radius of each mesh. With fewer
    paths than rings, the last of `rings` are used. Raises InputError for more paths than rings.
    """
    if len(coarse) > len(rings):
        remedy = "give at most one for each of coarse_rings"
        raise InputError("more coarse meshes than coarse_rings", "--coarse", f"{len(coarse)} files, {rings}", remedy)
    return list(zip(coarse, rings[len(rings) - len(coarse) :]))


def mesh_paths(arguments):
    """Paths of the meshes to solve on, the coarsest first. Raises InputError for a file that is missing.

    Coarser meshes with an empty file are skipped: `flow mesh` has left them out.
    """
    for path in (arguments.mesh, *arguments.coarse):
        if not pathlib.Path(path).is_file():
            raise InputError("no such mesh", path, "missing", "make it with `flow mesh`")
    return [*(path for path in arguments.coarse if pathlib.Path(path).stat().st_size), arguments.mesh]


def anatomy_and_sections(arguments):
    """Paths (anatomy.json, sections.csv) for `flow solve`: those given, else those beside the centreline."""
    folder = pathlib.Path(arguments.centreline).parent
    return arguments.anatomy or folder / "anatomy.json", arguments.sections or folder / "sections.csv"


def require_file(path, option):
    """Returns `path`. Raises InputError if no file is there; the message names `option`, which gives the path."""
    if not pathlib.Path(path).is_file():
        raise InputError("no such file", path, "missing", f"leave it beside the centreline, or give {option}")
    return path

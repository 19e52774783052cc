"""Command line: `python3 -m flow boundary | mesh | solve | audit | rank`."""

import argparse
import pathlib
import signal
import sys

import numpy as np

from common.documents import config, json_reader
from common.errors import InputError, guarded
from common.files import sha256, write_json, write_table
from flow import command_files, output
from flow import settings as settings_module


def _patient_values(arguments, case):
    """The patient's values: section `patient` of the case file, or those given as options. Raises InputError."""
    given = {key: getattr(arguments, key) for key in ("lvm_g", "sbp_mmhg", "dbp_mmhg")}
    if arguments.case:
        twice = [settings_module.option_name(key) for key, value in given.items() if value is not None]
        if twice:
            raise InputError("patient values given twice", "command line", twice, "give --case, or the values")
        return case["patient"]
    missing = [key for key, value in given.items() if value is None]
    if missing:
        raise InputError(
            "patient values missing", "command line", missing, "give --case or --lvm-g, --sbp-mmhg, --dbp-mmhg"
        )
    return given


def boundary_command(arguments):
    """Boundary values of a patient from the anatomy before the intervention."""
    from flow.geometry import centreline
    from flow.inputs import boundary, lumen_summary
    from flow.reduced import flow_range, network as network_model

    settings = settings_module.from_arguments(arguments)
    case = config.load_case(arguments.case) if arguments.case else {}
    patient, real = _patient_values(arguments, case), case.get("kind") == "surface"
    anatomy = lumen_summary.read(arguments.anatomy, "ends")
    tree = centreline.read(arguments.centreline or pathlib.Path(arguments.anatomy).with_name("centreline.vtp"))
    lumen_summary.check_lengths(anatomy, tree, arguments.anatomy)
    document = boundary.make(anatomy, tree, patient, settings, case.get("measured"), with_range=real)
    if patient.get("hyperaemic_inflow_ml_per_min") is not None:
        sections = network_model.read_sections(pathlib.Path(arguments.anatomy).with_name("sections.csv"))

        def network_at(values):
            return network_model.Network(anatomy, sections, values, settings.expansion_loss)

        if real:
            document["plausible_flows"] = flow_range.plausible_around_inflow(
                document, network_at, settings.split_exponent
            )
        document = flow_range.fit_resistances(document, network_at)
    output.print_warnings(document["warnings"])
    write_json(arguments.out, document)


def mesh_command(arguments):
    """Volume meshes of a lumen, coarse and fine."""
    from flow.geometry import centreline, surface
    from flow.meshing import mesh, provenance

    settings = settings_module.from_arguments(arguments)
    coarse = command_files.pair_with_rings(arguments.coarse, settings.coarse_rings)
    if coarse:
        settings_module.check_meshes(vars(settings), "flow settings")
    lumen, tree = surface.read(arguments.lumen), centreline.read(arguments.centreline)
    centreline.check_wall(tree, lumen.points[np.unique(lumen.triangles[lumen.region == surface.WALL])], arguments.lumen)
    centreline.check_ends(tree, lumen, arguments.centreline)
    mesh_settings = {
        name: value for name, value in vars(settings).items() if "mesh" in settings_module.commands_of(name)
    }
    report = {
        "schema": "vci-mesh-1",
        "settings": mesh_settings,
        "made_from_sha256": provenance.fingerprint(lumen, tree),
    }
    build_meshes = mesh.build_sequence if settings.model == "3d" else mesh.build_coarsest
    meshes = build_meshes([*coarse, (arguments.out, settings.rings)], lumen, tree, settings, report)
    mesh.write_all(meshes, report, command_files.mesh_report_path(arguments))


def _read_case(arguments):
    """reduced.extended.ExtendedLumen made from the files that `flow solve` reads. Raises InputError."""
    settings = settings_module.from_arguments(arguments)
    from flow.geometry import centreline
    from flow.inputs import boundary, lumen_summary
    from flow.meshing import provenance
    from flow.physics import ffr
    from flow.reduced import extended, network as network_model

    anatomy_file, sections_file = command_files.anatomy_and_sections(arguments)
    document = json_reader.read(arguments.boundary, "boundary.json").data
    anatomy = lumen_summary.read(command_files.require_file(anatomy_file, "--anatomy"), "branches")
    boundary.check(document, arguments.boundary, [branch["name"] for branch in anatomy["branches"]])
    sections = network_model.read_sections(command_files.require_file(sections_file, "--sections"))
    *coarse, fine = command_files.mesh_paths(arguments)
    tree = centreline.read(arguments.centreline)
    lumen_summary.check_lengths(anatomy, tree, anatomy_file)
    network_model.check_sections(sections, tree, sections_file)
    ffr.check_probes(document["probes"], tree)
    report = arguments.mesh_report or pathlib.Path(fine).with_suffix(".json")
    read_report = extended.read_report if arguments.mesh_report else extended.read_report_if_any
    extensions, warnings, made_from = read_report(report, fine, coarse)
    case = extended.ExtendedLumen(extensions, tree, anatomy, sections, document, settings, warnings)
    if arguments.lumen:
        provenance.check(arguments.lumen, tree, made_from, report)
    return case


def solve_command(arguments):
    """Steady flow and FFR on a mesh."""
    from flow import solve

    case = _read_case(arguments)
    start = _read_start(arguments, case) if arguments.start and case.settings.model == "3d" else None
    made_from = {"mesh_sha256": sha256(arguments.mesh), "boundary_sha256": sha256(arguments.boundary)}
    answer = solve.run(command_files.mesh_paths(arguments), case, arguments.out, start, made_from)
    print(solve.summary_line(answer))


def _read_start(arguments, case):
    """inputs.solution.StartState of the state that `flow solve` starts from. Raises InputError."""
    from flow.geometry import centreline
    from flow.inputs import solution

    folder, centreline_file = arguments.start
    return solution.read(folder, case.original_tree, centreline.read(centreline_file))


def audit_command(arguments):
    """Whether the steady flow is the mean of the flow in time (in lcx01 the march took half as long as the solve)."""
    from flow import adaptive, audit

    case = _read_case(arguments)
    if case.settings.model != "3d":
        raise InputError("only the 3D flow can be audited", "setting model", case.settings.model, "leave it at 3d")
    output.print_warnings(case.warnings)
    search = adaptive.MeshSearch(case.document, case.settings, case.original_tree, case.predictor())
    solved = search.run(command_files.mesh_paths(arguments))
    answer, table = audit.audit_answer(solved, case)
    answer["meshes"] = search.meshes
    write_table(pathlib.Path(arguments.out).with_suffix(".csv"), table)
    write_json(arguments.out, answer)
    print(audit.summary_line(answer))


def rank_command(arguments):
    """Plans of a patient ranked by a reduced model's FFR, with the model's measured error."""
    from flow.inputs import boundary
    from flow.reduced import ranking

    if getattr(arguments, "model", None) == "3d":
        raise InputError("not a reduced model", "--model", "3d", "rank by axisymmetric or network")
    settings = settings_module.from_arguments(arguments)
    document = json_reader.read(arguments.boundary, "boundary.json").data
    boundary.check(document, arguments.boundary)
    plans = dict(given.partition("=")[::2] for given in arguments.plans)
    if len(plans) < len(arguments.plans) or not all(plans.values()):
        raise InputError("plans are not named apart", "command line", arguments.plans, "give NAME=FOLDER for each")
    measured = [(path, json_reader.read(path, "ffr.json").data) for path in arguments.measured]
    # A settings file shared with `flow solve` may hold 3d, the default. Ranking then takes this reduced model.
    model = "axisymmetric" if settings.model == "3d" else settings.model
    table = ranking.rank(plans, document, settings, model, measured)
    write_table(arguments.out, table)
    print(table.to_string(index=False))


def _add_solve_inputs(command):
    """Adds to a command's parser the arguments for the files that `flow solve` and `flow audit` read."""
    command.add_argument("mesh", help="mesh.msh")
    command.add_argument(
        "--coarse",
        nargs="+",
        default=[],
        help="coarser meshes, the coarsest first: the answer where one meets ffr_tolerance, else the next one's start",
    )
    command.add_argument("--boundary", required=True, help="boundary.json")
    command.add_argument("--centreline", required=True, help="centreline.vtp of the same lumen")
    command.add_argument("--anatomy", help="anatomy.json of the same lumen (default: beside the centreline)")
    command.add_argument("--lumen", help="lumen.vtp: a mesh that was made from another is refused")
    command.add_argument("--mesh-report", help="report of `flow mesh`, for its extensions (default: beside the mesh)")
    command.add_argument("--sections", help="sections.csv of the same lumen (default: beside the centreline)")


def make_parser():
    """The argument parser of all commands."""
    parser = argparse.ArgumentParser(prog="python3 -m flow", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)

    boundary = commands.add_parser("boundary", help=boundary_command.__doc__)
    boundary.add_argument("--anatomy", required=True, help="anatomy.json before the intervention")
    boundary.add_argument("--centreline", help="centreline.vtp (default: beside anatomy.json)")
    boundary.add_argument("--case", help="config/cases/<case>.yaml, for the patient's values; or:")
    boundary.add_argument("--lvm-g", type=float, help="left ventricular mass, g")
    boundary.add_argument("--sbp-mmhg", type=float, help="systolic pressure, mmHg")
    boundary.add_argument("--dbp-mmhg", type=float, help="diastolic pressure, mmHg")
    boundary.add_argument("--out", required=True, help="boundary.json")
    boundary.set_defaults(run=boundary_command)

    mesh = commands.add_parser("mesh", help=mesh_command.__doc__)
    mesh.add_argument("lumen", help="lumen.vtp with cell array region_id")
    mesh.add_argument("--centreline", required=True, help="centreline.vtp of the same lumen")
    mesh.add_argument("--out", required=True, help="mesh.msh")
    mesh.add_argument("--coarse", nargs="+", default=[], help="coarser meshes, the coarsest first; often good enough")
    mesh.add_argument("--json", help="report (default: mesh.json beside the mesh)")
    mesh.set_defaults(run=mesh_command)

    solve = commands.add_parser("solve", help=solve_command.__doc__)
    _add_solve_inputs(solve)
    solve.add_argument("--out", required=True, help="folder for solution.vtu, ffr.json, pullback.csv")
    solve.add_argument(
        "--start",
        nargs=2,
        metavar=("FOLDER", "CENTRELINE"),
        help="a solved state of the same vessel and its centreline.vtp, whose flow is the first guess (model 3d)",
    )
    solve.set_defaults(run=solve_command)

    audit = commands.add_parser("audit", help=audit_command.__doc__)
    _add_solve_inputs(audit)
    audit.add_argument("--out", required=True, help="audit.json; the series in time is written beside it, audit.csv")
    audit.set_defaults(run=audit_command)

    rank = commands.add_parser("rank", help=rank_command.__doc__)
    rank.add_argument("plans", nargs="+", metavar="NAME=FOLDER", help="anatomy step's folder of a plan's lumen")
    rank.add_argument("--boundary", required=True, help="boundary.json")
    rank.add_argument(
        "--measured", nargs="+", default=[], metavar="FFR.json", help="3D answers of this patient: the model's error"
    )
    rank.add_argument("--out", required=True, help="ranking.csv")
    rank.set_defaults(run=rank_command)
    for name, command in commands.choices.items():
        settings_module.add_options(command, name)
    return parser


@guarded
def main(argv=None):
    """Runs one command."""
    parser = make_parser()
    arguments, unknown = parser.parse_known_args(argv)
    command_files.remove_old_output(arguments)
    if unknown:
        settings_module.check_unknown_arguments(arguments.command, unknown)
        parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    arguments.run(arguments)


def _exit_on_signal(number, _):
    """Handler of SIGTERM: ends the program as an error would, so that half-made files are removed."""
    sys.exit(128 + number)


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, _exit_on_signal)
    main()

"""Command line: python3 -m anatomy plan|carry-plan|plan-picture|picture|ends|register|contours|ct|thin-contours."""

import argparse
import pathlib

from common.errors import InputError, guarded

from .contours import reading as contours

POINT = {"type": float, "nargs": 3, "metavar": ("X", "Y", "Z")}
POINTS = POINT | {"action": "append", "default": []}  # for options that may be given several times, once for each point
THICKEST_WALL_MM = 1.0  # largest value of --healthy-wall, as in config/schemas: about three times a normal intima
ROOT = pathlib.Path(__file__).resolve().parent.parent


def _parser():
    parser = argparse.ArgumentParser(
        prog="anatomy", description="Lumens from contours, planned devices, pictures of a measured lumen."
    )
    commands = parser.add_subparsers(dest="command", required=True)
    plan = commands.add_parser(
        "plan", help="devices and steps of a case's procedure, as a scene without wall and numerics"
    )
    plan.add_argument("case", type=pathlib.Path, help="case file, config/cases/<case>.yaml")
    plan.add_argument("--anatomy", type=pathlib.Path, required=True, help="folder made by `lumen process`")
    plan.add_argument(
        "--devices", type=pathlib.Path, default=ROOT / "config" / "devices", help="folder of device families"
    )
    plan.add_argument("--out", type=pathlib.Path, required=True, help="plan.json to write")
    carry = commands.add_parser(
        "carry-plan", help="a plan for another reading of the same lumen: same devices and places"
    )
    carry.add_argument("plan", type=pathlib.Path, help="plan.json made by `anatomy plan`")
    carry.add_argument("--from", dest="before", type=pathlib.Path, required=True, help="anatomy that it was made in")
    carry.add_argument("--to", dest="after", type=pathlib.Path, required=True, help="anatomy of the other reading")
    carry.add_argument("--out", type=pathlib.Path, required=True, help="plan.json to write")
    drawn = commands.add_parser("plan-picture", help="a plan's devices over the lumen along the branches they treat")
    drawn.add_argument("plan", type=pathlib.Path, help="plan.json made by `anatomy plan`")
    drawn.add_argument("--anatomy", type=pathlib.Path, required=True, help="folder made by `lumen process`")
    drawn.add_argument("--out", type=pathlib.Path, required=True, help="picture to write: .png or .svg")
    picture = commands.add_parser("picture", help="the tree with its sections, names and lesions")
    picture.add_argument("--anatomy", type=pathlib.Path, required=True, help="folder made by `lumen process`")
    picture.add_argument("--out", type=pathlib.Path, required=True, help="picture to write: .png or .svg")
    _add_contours(commands)
    _add_ct(commands)
    thin = commands.add_parser("thin-contours", help="a contour table with fewer points a frame")
    thin.add_argument("table", type=pathlib.Path, help="table of outlines: frame, x, y, z in mm")
    thin.add_argument("--points", type=int, default=125, help="points of each frame; default: 125")
    thin.add_argument("--out", type=pathlib.Path, required=True, help="table to write")
    register = commands.add_parser(
        "register", help="the lumen found after the real procedure, brought to the one before it"
    )
    register.add_argument("case", type=pathlib.Path, help="case file with `post`, config/cases/<case>.yaml")
    register.add_argument("--pre", type=pathlib.Path, required=True, help="folder made by `lumen process` of `lumen`")
    register.add_argument("--post", type=pathlib.Path, required=True, help="folder made by `lumen process` of `post`")
    register.add_argument(
        "--out", type=pathlib.Path, required=True, help="folder for lumen.vtp, like.json and registration.json"
    )
    ends = commands.add_parser("ends", help="a surface with what `lumen check` took for ends and for wall")
    ends.add_argument("--surface", type=pathlib.Path, required=True, help="as `lumen check --repaired` wrote it")
    ends.add_argument("--ends", type=pathlib.Path, help="file of `lumen check --ends`; without it the surface alone")
    ends.add_argument("--out", type=pathlib.Path, required=True, help="picture to write: .png or .svg")
    return parser


def _add_contours(commands):
    command = commands.add_parser("contours", help="lumen and plaque of an intravascular pull-back's contour tables")
    command.add_argument("lumen", type=pathlib.Path, help="table of the lumen's outlines: frame, x, y, z")
    for name in contours.TABLES[1:]:
        option = "--" + name.replace("_", "-")
        command.add_argument(option, type=pathlib.Path, help=f"table of the {name.replace('_', ' ')}")
    command.add_argument("--units", choices=("mm", "cm", "m"), default="mm", help="units of the tables")
    command.add_argument("--z-from", choices=("distal", "proximal"), default="distal", help="end of the smallest z")
    command.add_argument(
        "--z-range", type=float, nargs=2, metavar=("FIRST", "LAST"), help="first and last z of the frames used"
    )
    command.add_argument("--drop-frame", type=float, action="append", default=[], help="a frame not used; repeat")
    command.add_argument("--healthy-wall", default="auto", help="wall that is no plaque, mm; default: auto")
    command.add_argument("--centreline", type=pathlib.Path, help="lines (.vtp) from the proximal end on")
    command.add_argument("--centreline-units", choices=("mm", "cm", "m"), default="mm", help="units of its coordinates")
    command.add_argument("--line", type=int, help="which of several lines, from 1")
    command.add_argument(
        "--landmark-point",
        **POINTS,
        help="where a landmark of the table lies in the centreline's space, mm; repeat in the table's order",
    )
    command.add_argument("--proximal-s", type=float, help="mm along the line at the proximal frame, without landmarks")
    command.add_argument("--rotation", type=float, default=0.0, help="degrees about the line, without landmarks")
    command.add_argument(
        "--mirrored", action="store_true", help="the tables are left-handed: x, y and z, whichever end z rises from"
    )
    command.add_argument("--out", type=pathlib.Path, required=True, help="folder for the results")


def _add_ct(commands):
    command = commands.add_parser("ct", help="lumen and calcium of a CT angiogram, from the vessels' end points")
    command.add_argument("volume", type=pathlib.Path, help="NIfTI file, or folder with a DICOM series")
    command.add_argument("--series", help="UID of the series, where the folder has several")
    command.add_argument("--inlet", **POINT, help="point on the vessel's axis where it begins, mm")
    command.add_argument("--outlet", **POINTS, help="where a branch ends; repeat")
    command.add_argument(
        "--ends", type=pathlib.Path, help="the same as JSON: ends [{name, centre_mm}], the inlet first"
    )
    command.add_argument(
        "--centreline", type=pathlib.Path, help="lines to each outlet, to be centred; default: found in the image"
    )
    command.add_argument("--stented", action="store_true", help="the vessels hold a stent; default: bright is calcium")
    command.add_argument("--settings", type=pathlib.Path, help="YAML or JSON with the keys of the section `ct`")
    command.add_argument("--out", type=pathlib.Path, required=True, help="folder for lumen.vtp and segmentation.json")


def _ct(options):
    from .ct import ends_check, segment

    if (options.ends is None) == (options.inlet is None):
        raise InputError(
            "end points are given in one way", "--ends, --inlet", "both or none", "--inlet and --outlet, or --ends"
        )
    if options.ends:
        ends = ends_check.load_ends(options.ends)
    else:
        outlets = [(f"outlet{number}", point) for number, point in enumerate(options.outlet, start=1)]
        ends = ends_check.checked_ends([("inlet", options.inlet), *outlets], "--inlet, --outlet")
    given = (options.settings, options.centreline, options.series, options.stented)
    segment.run(options.volume, ends, options.out, *given)


def _contours(options):
    from .contours import run

    files = {name: getattr(options, name) for name in contours.TABLES}
    healthy = options.healthy_wall
    if healthy != "auto":
        try:
            healthy = float(healthy)
        except ValueError:
            healthy = float("nan")
        if not 0 <= healthy <= THICKEST_WALL_MM:
            remedy = f"a number of mm from 0 to {THICKEST_WALL_MM:g}, or auto"
            raise InputError("no thickness of a healthy wall", "--healthy-wall", options.healthy_wall, remedy)
    placement_settings = None
    for name in ("line", "landmark_point", "proximal_s", "rotation", "mirrored"):
        if getattr(options, name) and not options.centreline:
            option = "--" + name.replace("_", "-")
            raise InputError(
                "there is no centreline to lie on", option, getattr(options, name), "give --centreline too"
            )
    if options.centreline:
        placement_settings = {
            "centreline": options.centreline,
            "units": options.centreline_units,
            "line": options.line,
            "landmark_points_mm": options.landmark_point,
            "proximal_s_mm": options.proximal_s,
            "rotation_deg": options.rotation,
            "mirrored": options.mirrored,
        }
    reading = {"z_from": options.z_from, "z_range_mm": options.z_range, "drop_frames": options.drop_frame}
    run.run(files, options.out, options.units, healthy, reading, placement_settings)


@guarded
def main(arguments=None):
    """Runs one command. Bad input ends the program with exit code 2."""
    options = _parser().parse_args(arguments)
    if options.command == "plan":
        from .planning import plan

        plan.run(options.case, options.anatomy, options.devices, options.out)
    elif options.command == "carry-plan":
        from .planning import carry_plan

        carry_plan.run(options.plan, options.before, options.after, options.out)
    elif options.command == "contours":
        _contours(options)
    elif options.command == "ct":
        _ct(options)
    elif options.command == "thin-contours":
        from .contours.reading import tables

        tables.write_thinned(options.table, options.out, options.points)
    elif options.command == "plan-picture":
        from .planning import plan_picture

        plan_picture.run(options.anatomy, options.plan, options.out)
    elif options.command == "register":
        from .register import run

        run.run(options.case, options.pre, options.post, options.out)
    elif options.command == "ends":
        from . import ends_picture

        ends_picture.run(options.surface, options.ends, options.out)
    else:
        from . import picture

        picture.run(options.anatomy, options.out)


if __name__ == "__main__":
    main()

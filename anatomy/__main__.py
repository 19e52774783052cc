"""Command line: python3 -m anatomy plan|picture."""

import argparse
import pathlib

from common.errors import guarded

ROOT = pathlib.Path(__file__).resolve().parent.parent


def _parser():
    parser = argparse.ArgumentParser(prog="anatomy", description="Planned devices and pictures of a measured lumen.")
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
    picture = commands.add_parser("picture", help="the tree with its sections, names and lesions")
    picture.add_argument("--anatomy", type=pathlib.Path, required=True, help="folder made by `lumen process`")
    picture.add_argument("--out", type=pathlib.Path, required=True, help="picture to write: .png or .svg")
    return parser


@guarded
def main(arguments=None):
    """Runs one command; exit code 2 for bad input."""
    options = _parser().parse_args(arguments)
    if options.command == "plan":
        from . import plan

        plan.run(options.case, options.anatomy, options.devices, options.out)
    else:
        from . import picture

        picture.run(options.anatomy, options.out)


if __name__ == "__main__":
    main()

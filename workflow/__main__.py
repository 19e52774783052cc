"""Command line: python3 -m workflow validate|scene."""

import argparse
import pathlib

from common.errors import guarded


def run_validate(options):
    from workflow.configuration import Configuration

    found = Configuration(options.folder)
    print(f"{options.folder}: {len(found.cases)} cases and {len(found.devices)} device families are valid")


def run_scene(options):
    from workflow.scene import write_scene

    write_scene(options.plan, options.settings, options.out)


@guarded
def main(arguments=None):
    """Runs one command; exit code 2 and one message for the first value that is not allowed."""
    parser = argparse.ArgumentParser(prog="workflow", description="The study's configuration.")
    commands = parser.add_subparsers(dest="command", required=True)
    validate = commands.add_parser("validate", help="check study.yaml, every device and every case")
    validate.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("config"), help="default: config")
    validate.set_defaults(run=run_validate)
    scene = commands.add_parser("scene", help="a plan with the wall and numerics of the section `deployment`")
    scene.add_argument("plan", type=pathlib.Path, help="plan.json, made by `anatomy plan`")
    scene.add_argument("--settings", type=pathlib.Path, required=True, help="JSON with the section `deployment`")
    scene.add_argument("--out", type=pathlib.Path, required=True, help="scene.json, in the plan's folder")
    scene.set_defaults(run=run_scene)
    options = parser.parse_args(arguments)
    options.run(options)


if __name__ == "__main__":
    main()

"""Command line: python3 -m workflow validate|scene|provenance|manifest|verify."""

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


def run_provenance(options):
    from workflow.configuration import Configuration
    from workflow.provenance import write_provenance

    study = Configuration(options.folder)
    write_provenance(study, options.cases, options.results, options.programs, options.software, options.out)


def run_manifest(options):
    from workflow.manifest import write_manifest

    write_manifest(options.results, options.out)
    print(f"{options.out}: what {options.results} holds")


def run_verify(options):
    from workflow.manifest import verify

    count = verify(options.manifest, options.results)
    print(f"{options.results} agrees with {options.manifest}: {count} comparisons")


@guarded
def main(arguments=None):
    """Runs one command; exit code 2 and one message for a bad value, 3 for a study that differs."""
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
    folder, results = pathlib.Path("config"), pathlib.Path("results")
    made = commands.add_parser("provenance", help="hashes, versions, seeds and commands of a finished study")
    made.add_argument("--folder", type=pathlib.Path, default=folder, help="of the configuration (config)")
    made.add_argument("--cases", nargs="+", required=True, help="names of the study's cases")
    made.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    made.add_argument("--programs", nargs="+", type=pathlib.Path, required=True, help="vci and lumen")
    made.add_argument("--software", type=pathlib.Path, required=True, help="software.json of the study")
    made.add_argument("--out", type=pathlib.Path, required=True, help="provenance.json")
    made.set_defaults(run=run_provenance)
    manifest = commands.add_parser("manifest", help="what a finished study must give again on another machine")
    manifest.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    manifest.add_argument("--out", type=pathlib.Path, required=True, help="config/manifests/<cohort>.json")
    manifest.set_defaults(run=run_manifest)
    compare = commands.add_parser("verify", help="compare a study with a manifest; exit code 3 where they differ")
    compare.add_argument("--manifest", type=pathlib.Path, required=True, help="config/manifests/<cohort>.json")
    compare.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    compare.set_defaults(run=run_verify)
    options = parser.parse_args(arguments)
    options.run(options)


if __name__ == "__main__":
    main()

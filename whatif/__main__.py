"""Command line: `python3 -m whatif plans | deploy | lumens | flow | deployment`."""

import argparse
import pathlib

from common.errors import guarded
from common.files import write_json, write_table
from whatif.case import BEFORE, PLANNED, Case


def case_from_options(options):
    """The whatif.case.Case that the command-line options describe."""
    return Case(options.case_dir, options.programs, options.edge, options.spacing)


def run_plans(options):
    from whatif.plans import rank_plans

    table, plans = rank_plans(case_from_options(options), options.devices, options.states)
    write_json(options.out.with_name("plans.json"), plans)
    write_table(options.out, table)


def run_deploy(options):
    from whatif.plans import deploy, read_steps

    steps = read_steps(options.plans, options.plan)
    deploy(case_from_options(options), steps, options.devices, options.out)


def run_lumens(options):
    from whatif.lumens import ffr_of_lumens

    write_json(options.out, ffr_of_lumens(case_from_options(options), options.lumens, options.states))


def run_flow(options):
    from whatif.sensitivity import flow_sensitivity

    write_sensitivity(options, *flow_sensitivity(case_from_options(options), options.config, options.states))


def run_deployment(options):
    from whatif.sensitivity import deployment_sensitivity

    write_sensitivity(options, *deployment_sensitivity(case_from_options(options), options.config))


def write_sensitivity(options, table, intervals):
    """Writes the two tables of a sensitivity to the files that the command-line options name."""
    write_table(options.intervals, intervals)
    write_table(options.out, table)


def parser():
    """The argument parser of all commands."""
    path = pathlib.Path
    root = argparse.ArgumentParser(prog="whatif", description=__doc__)
    commands = root.add_subparsers(dest="command", required=True)
    plans = commands.add_parser("plans", help="other plans of a case, deployed and ranked -> ranking.csv, plans.json")
    plans.add_argument("--devices", type=path, default=path("config/devices"), help="folder of device families")
    plans.add_argument("--states", nargs="+", required=True, help="states with an FFR: the reduced model's error")
    plans.set_defaults(run=run_plans)
    deploy = commands.add_parser("deploy", help="one of those plans: its lumen and anatomy, for the flow in 3D")
    deploy.add_argument("plan", help="its name in plans.json")
    deploy.add_argument("--plans", type=path, required=True, help="plans.json")
    deploy.add_argument("--devices", type=path, default=path("config/devices"), help="folder of device families")
    deploy.set_defaults(run=run_deploy)
    lumens = commands.add_parser("lumens", help="FFR of given lumens by the calibrated network -> a JSON file")
    lumens.add_argument("lumens", nargs="+", help="folders below the case's, each with an anatomy/")
    lumens.add_argument("--states", nargs="+", required=True, help="states with an FFR: the reduced model's error")
    lumens.set_defaults(run=run_lumens)
    flow = commands.add_parser("flow", help="FFR over the uncertain inputs of the flow -> two CSV files")
    flow.add_argument("--states", nargs="+", default=[BEFORE, PLANNED], help="states with an FFR: the intervals")
    flow.set_defaults(run=run_flow)
    deployment = commands.add_parser(
        "deployment", help="FFR and stent area over pressures, places and stiffnesses -> two CSV files; minutes"
    )
    deployment.set_defaults(run=run_deployment)
    for command in (flow, deployment):
        command.add_argument("--config", type=path, required=True, help="config/cases/<case>.yaml, for the patient")
        command.add_argument("--intervals", type=path, required=True, help="the CSV file of the Latin hypercube")
    for command in commands.choices.values():
        command.add_argument("--case-dir", type=path, required=True, help="results/cases/<case>, computed")
        command.add_argument("--programs", type=path, default=path("build"), help="folder of vci and lumen (build)")
        command.add_argument("--edge", type=float, default=0.4, help="of the deployed lumen, as `lumen process` (0.4)")
        command.add_argument("--spacing", type=float, default=0.5, help="of its sections, mm (0.5)")
        command.add_argument("--out", type=path, required=True, help="the file; of deploy a folder")
    return root


@guarded
def main(arguments=None):
    """Runs one command; exit codes as in docs/design.md."""
    options = parser().parse_args(arguments)
    options.run(options)


if __name__ == "__main__":
    main()

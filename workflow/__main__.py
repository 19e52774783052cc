"""Command line of the study: configuration, scenes, provenance, manifests, failed steps, cohorts."""

import argparse
import pathlib
import sys
import time

from common.errors import InputError, UserError, guarded


def run_validate(options):
    from flow.inputs.boundary import patient_warnings
    from workflow.configuration import Configuration

    configuration = Configuration(options.folder)
    for name, case in configuration.cases.items():
        fraction = configuration.settings(name)["flow"]["hyperaemia_fraction"]
        for doubt in patient_warnings(case["patient"], case.get("measured"), fraction):
            print(f"warning: {configuration.case_file(name)}: {doubt}", file=sys.stderr)
    print(
        f"{options.folder}: {len(configuration.cases)} cases and {len(configuration.devices)} device families are valid"
    )


def run_scene(options):
    from workflow.scene import write_scene

    write_scene(options.plan, options.settings, options.out)


def run_provenance(options):
    from workflow.configuration import Configuration
    from workflow.provenance import write_provenance

    study = Configuration(options.folder, leave_out_bad_cases=True)  # bad files of other cases must not stop this study
    write_provenance(study, options.cases, options.results, options.programs, options.software, options.out)


def run_manifest(options):
    from workflow.manifest import write_manifest

    write_manifest(options.results, options.out)
    print(f"{options.out}: what {options.results} holds")


def run_verify(options):
    from workflow.manifest import verify

    count = verify(options.manifest, options.results)
    print(f"{options.results} agrees with {options.manifest}: {count} comparisons")


def run_failed(options):
    from workflow.failed import write_failed

    steps = write_failed(options.out, options.results, options.since)
    for step in steps:
        print(f"{step['case']} failed at {step['step']}: {step['message'].splitlines()[0]}", file=sys.stderr)
    if not steps:
        sys.exit(1)


def run_agreement(options):
    from workflow.agreement import write_agreement

    count = write_agreement(options.manifest, options.results, options.out)
    print(f"{options.out}: {count} numbers agree with {options.manifest}")


def run_cohort(options):
    from workflow.cohort import draw_shards, projected_costs, run_shards

    start = time.monotonic()
    shards = draw_shards(options.count, options.seed, options.out, options.folder, options.full, options.cores)
    rows = run_shards(shards, options.cores, dry_run=options.dry_run, keep_all=options.keep_all)
    total = {key: sum(row[key] for row in rows) for key in ("patients", "finished", "cpu_s", "kept_mb")}
    outcome = "planned" if options.dry_run else f"finished {total['finished']} of"
    print(f"{outcome} {total['patients']} patients in {len(rows)} shards: {time.monotonic() - start:.0f} s,", end=" ")
    print(f"{total['cpu_s']:.0f} s of processor time in Snakemake; {total['kept_mb']:.0f} MB kept")
    for row in [] if options.dry_run else projected_costs(options.out, options.cores):
        print(", ".join(f"{key} {value}" for key, value in row.items()))
    refused = [row["shard"] for row in rows if options.dry_run and row["exit_code"]]
    if refused:
        raise InputError(
            "a shard cannot be planned", options.out / "shards", ", ".join(refused), "see snakemake.log there"
        )
    stopped = [row["shard"] for row in rows if not options.dry_run and not row["computed"]]
    if stopped:
        remedy = "the end of snakemake.log there says why; make unlock frees a folder whose run was killed"
        raise UserError("Snakemake stopped before any patient", options.out / "shards", ", ".join(stopped), remedy)


def run_stent_alone(options):
    from workflow.stent_alone import write_stent_alone

    write_stent_alone(options.plan, options.out)


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
    provenance = commands.add_parser("provenance", help="hashes, versions, seeds and commands of a finished study")
    provenance.add_argument("--folder", type=pathlib.Path, default=folder, help="of the configuration (config)")
    provenance.add_argument("--cases", nargs="+", required=True, help="names of the study's cases")
    provenance.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    provenance.add_argument("--programs", nargs="+", type=pathlib.Path, required=True, help="vci, lumen, modules")
    provenance.add_argument("--software", type=pathlib.Path, required=True, help="software.json of the study")
    provenance.add_argument("--out", type=pathlib.Path, required=True, help="provenance.json")
    provenance.set_defaults(run=run_provenance)
    manifest = commands.add_parser("manifest", help="what a finished study must give again on another machine")
    manifest.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    manifest.add_argument("--out", type=pathlib.Path, required=True, help="config/manifests/<cohort>.json")
    manifest.set_defaults(run=run_manifest)
    verify = commands.add_parser("verify", help="compare a study with a manifest; exit code 3 where they differ")
    verify.add_argument("--manifest", type=pathlib.Path, required=True, help="config/manifests/<cohort>.json")
    verify.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    verify.set_defaults(run=run_verify)
    words = "the steps of cases that failed; exit code 1, and no file, where none did"
    failed = commands.add_parser("failed", help=words)
    failed.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    failed.add_argument("--since", type=float, default=0.0, help="only from this time on, in seconds since 1970 (0)")
    failed.add_argument("--out", type=pathlib.Path, required=True, help="failed.json, for `snakemake --config failed=`")
    failed.set_defaults(run=run_failed)
    agreement = commands.add_parser(
        "agreement", help="a page on a study beside the manifest of another system; exit code 3"
    )
    agreement.add_argument("--manifest", type=pathlib.Path, required=True, help="config/manifests/<cohort>.json")
    agreement.add_argument("--results", type=pathlib.Path, default=results, help="root of the products (results)")
    agreement.add_argument("--out", type=pathlib.Path, required=True, help="Markdown page")
    agreement.set_defaults(run=run_agreement)
    cohort = commands.add_parser("cohort", help="draw patients and run them in shards, up to their metrics")
    cohort.add_argument("--count", type=int, required=True, help="number of patients")
    cohort.add_argument("--seed", type=int, required=True, help="patient k of a seed is the same whatever the count")
    cohort.add_argument("--out", type=pathlib.Path, required=True, help="folder of the shards")
    cohort.add_argument("--folder", type=pathlib.Path, default=folder, help="of study.yaml and devices (config)")
    cohort.add_argument("--cores", type=int, default=1, help="jobs side by side (1)")
    cohort.add_argument("--full", action="store_true", help="flow in three dimensions and CT; else the reduced model")
    cohort.add_argument("--keep-all", action="store_true", help="keep surfaces, meshes and fields of finished patients")
    cohort.add_argument("--dry-run", action="store_true", help="plan only")
    cohort.set_defaults(run=run_cohort)
    stent_alone = commands.add_parser("stent-alone", help="a plan with its stents' steps only")
    stent_alone.add_argument("plan", type=pathlib.Path, help="plan.json, made by `anatomy plan`")
    stent_alone.add_argument(
        "--out", type=pathlib.Path, required=True, help="plan.json, in another folder of the same case"
    )
    stent_alone.set_defaults(run=run_stent_alone)
    options = parser.parse_args(arguments)
    options.run(options)


if __name__ == "__main__":
    main()

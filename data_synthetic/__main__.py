"""Command line: python3 -m data_synthetic COMMAND; --help lists the commands."""

import argparse
import pathlib

from common.errors import InputError, guarded


def _parser():
    parser = argparse.ArgumentParser(prog="data_synthetic", description="Virtual patients and their post-PCI truth.")
    commands = parser.add_subparsers(dest="command", required=True)
    generate = commands.add_parser("generate", help="virtual patient from a case of kind synthetic")
    generate.add_argument("case", type=pathlib.Path, help="case file, config/cases/<case>.yaml")
    generate.add_argument("--out", type=pathlib.Path, required=True, help="folder for lumen.vtp and truth.json")
    draw = commands.add_parser("draw", help="cases of a random cohort from stated distributions")
    draw.add_argument("--count", type=int, required=True, help="number of patients")
    draw.add_argument("--seed", type=int, required=True, help="patient k of a seed is the same whatever the count")
    draw.add_argument("--out", type=pathlib.Path, required=True, help="folder for patient001.yaml, ...")
    reference = commands.add_parser("reference", help="independent finite-element post-PCI lumen")
    reference.add_argument("--scene", type=pathlib.Path, required=True, help="scene.json: devices and procedure")
    reference.add_argument("--anatomy", type=pathlib.Path, required=True, help="folder with the pre-PCI lumen.vtp")
    reference.add_argument("--truth", type=pathlib.Path, required=True, help="truth.json of the virtual patient")
    reference.add_argument(
        "--settings", type=pathlib.Path, help="YAML or JSON with the keys of the section `reference`"
    )
    reference.add_argument(
        "--out", type=pathlib.Path, required=True, help="folder for lumen.vtp, lumen.stl, reference.json"
    )
    solid = commands.add_parser(
        "reference-3d", help="how far the slices are from a solid in three dimensions (minutes)"
    )
    bent = commands.add_parser(
        "straightening-3d", help="how far the straightening by beams is from a solid in three dimensions (minutes)"
    )
    mesh_help = "elements round x through the wall x length in mm, coarse to fine"
    for command, document, meshes in (
        (solid, "slices_vs_3d.json", ["8x3x2", "12x4x1.2"]),
        (bent, "straightening_vs_3d.json", ["6x2x3", "8x3x2"]),
    ):
        command.add_argument("--scene", type=pathlib.Path, required=True, help="scene.json: devices and procedure")
        command.add_argument("--truth", type=pathlib.Path, required=True, help="truth.json of the virtual patient")
        command.add_argument("--settings", type=pathlib.Path, help="YAML or JSON: keys of the section `reference`")
        command.add_argument("--meshes", nargs="+", default=meshes, metavar="NxNxMM", help=mesh_help)
        command.add_argument("--out", type=pathlib.Path, required=True, help=f"folder for {document}")
    sensitivity = commands.add_parser(
        "reference-sensitivity", help="how much the reference depends on its constants (a minute)"
    )
    sensitivity.add_argument("--scene", type=pathlib.Path, required=True, help="scene.json: devices and procedure")
    sensitivity.add_argument("--truth", type=pathlib.Path, required=True, help="truth.json of the virtual patient")
    sensitivity.add_argument(
        "--settings", type=pathlib.Path, help="YAML or JSON with the keys of the section `reference`"
    )
    sensitivity.add_argument("--out", type=pathlib.Path, required=True, help="folder for sensitivity.csv")
    calculix = commands.add_parser("reference-ccx", help="slices against CalculiX, where that is installed")
    calculix.add_argument("--scene", type=pathlib.Path, help="plan.json: a slice of this case instead (with --truth)")
    calculix.add_argument("--truth", type=pathlib.Path, help="truth.json of the virtual patient")
    calculix.add_argument("--settings", type=pathlib.Path, help="YAML or JSON with the keys of the section `reference`")
    calculix.add_argument(
        "--s", type=float, metavar="MM", help="arc length of that slice; else the tightest stented one"
    )
    calculix.add_argument("--program", default="ccx", help="CalculiX (Debian package calculix-ccx)")
    calculix.add_argument(
        "--out", type=pathlib.Path, required=True, help="folder for slices_vs_calculix.json, case_vs_calculix.json"
    )
    scan = commands.add_parser("phantom", help="CT volume of a lumen")
    scan.add_argument("lumen", type=pathlib.Path, help="closed lumen.vtp with flat ends")
    scan.add_argument("--settings", type=pathlib.Path, help="YAML or JSON with the keys of the section `ct`")
    stents = scan.add_mutually_exclusive_group()
    stents.add_argument("--struts", type=pathlib.Path, help="vtp of lines: struts of the stents in this lumen")
    stents.add_argument("--scene", type=pathlib.Path, help="plan.json or scene.json: its stents laid on the wall")
    scan.add_argument("--centreline", type=pathlib.Path, help="this lumen's centreline.vtp (needed with --scene)")
    scan.add_argument("--out", type=pathlib.Path, required=True, help="folder for ct.nii.gz and ct.json")
    study = commands.add_parser("ct-study", help="table of how well the segmentation finds known lumens")
    study.add_argument("cases", type=pathlib.Path, nargs="+", help="synthetic cases, config/cases/<case>.yaml")
    study.add_argument("--voxels", type=float, nargs="+", default=[0.35, 0.5], help="voxel edges in mm")
    study.add_argument("--seeds", type=int, default=3, help="number of noise seeds")
    study.add_argument("--methods", nargs="+", help="of segmentation (all three)")
    study.add_argument("--settings", type=pathlib.Path, help="YAML or JSON with the keys of the section `ct`")
    study.add_argument("--out", type=pathlib.Path, required=True, help="table (CSV)")
    return parser


@guarded
def main(arguments=None):
    """Runs one command; exit code 2 for bad input, 3 for a computation that failed."""
    options = _parser().parse_args(arguments)
    if options.command == "generate":
        from . import generate

        generate.run(options.case, options.out)
    elif options.command == "draw":
        from . import draw

        for path in draw.run(options.count, options.seed, options.out):
            print(path)
    elif options.command == "reference-3d":
        from .reference.checks import against_solid

        against_solid.compare(options.scene, options.truth, options.out, options.meshes, options.settings)
    elif options.command == "straightening-3d":
        from .reference.checks import straightening_in_solid

        straightening_in_solid.compare(options.scene, options.truth, options.out, options.meshes, options.settings)
    elif options.command == "reference-sensitivity":
        from .reference.checks import sensitivity

        sensitivity.write_sensitivity(options.scene, options.truth, options.out, options.settings)
    elif options.command == "reference-ccx":
        from .reference.checks import against_calculix, calculix_case

        if (options.scene is None) != (options.truth is None):
            raise InputError("one of two is missing", "--scene, --truth", "given alone", "give both, or neither")
        if options.scene:
            inputs = (options.scene, options.truth, options.out, options.program)
            calculix_case.compare(*inputs, options.s, options.settings)
        else:
            against_calculix.compare(options.out, options.program)
    elif options.command == "phantom":
        from .ct import scan

        scan.run(options.lumen, options.out, options.settings, options.struts, options.scene, options.centreline)
    elif options.command == "ct-study":
        from .ct import study

        methods = options.methods or study.METHODS
        study.run(options.cases, options.voxels, options.seeds, options.out, methods, options.settings)
    else:
        from .reference import run

        run.run(options.scene, options.anatomy, options.truth, options.out, options.settings)


if __name__ == "__main__":
    main()

"""How many drawn patients, reconstructed in many ways, go through `lumen process`.

Run: /usr/bin/python3 tests/verification/anatomy/campaign.py --patients 20 --seed 1 --out FOLDER [--build build]
[--styles "loft 16" ...] [--through 2]: campaign.csv has a row for each surface with outcome, seconds and reason,
outcomes.csv counts them; a surface that was refused or came out wrong stays in FOLDER/kept with a picture. Of the first
patients (--through) each style goes on through plan, deployment and volume mesh, and so do the real surfaces of the
shared data. Right is: every end within 1 mm of the truth and no other, as many branches, and the worst lesion within
1 mm and 3 % of diameter, or within the band that a warning in anatomy.json states. false_stubs counts the warnings of
stubs, which no drawn patient has.
"""

import argparse
import csv
import json
import pathlib
import resource
import shutil
import subprocess
import sys

import campaign_truth
import lofts
import surfaces
from campaign_styles import STYLES, write_style_file
from drawn_patient import Patient

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))
import campaign_steps  # noqa: E402  (takes the study's settings from the repository)

from common.errors import error_message  # noqa: E402
from places import build_folder  # noqa: E402

COLUMNS = ["patient", "style", "outcome", "step", "cpu_s", "ends", "ends_expected", "lesion_mm", "lesion_percent"]
COLUMNS += ["false_stubs", "reason"]


def run(command, seconds=600):
    """(exit code, error message or last line of standard error, CPU seconds) of a command in the repository."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run([str(c) for c in command], cwd=ROOT, text=True, capture_output=True, timeout=seconds)
        code, text = done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        code, text = -1, f"longer than {seconds} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    lines = [line.strip() for line in error_message(text, last_lines=1).splitlines() if line.strip()]
    return code, " ".join(lines), round(cpu, 1)


def draw(count, seed, folder):
    """The drawn patients' names, their sources made in `folder`."""
    code, reason, _ = run(
        [sys.executable, "-m", "data_synthetic", "draw", "--count", count, "--seed", seed, "--out", folder / "cases"]
    )
    assert code == 0, reason
    names = []
    for case in sorted((folder / "cases").glob("*.yaml"))[:count]:
        source = folder / "source" / case.stem
        if not (source / "truth.json").exists():
            code, reason, _ = run([sys.executable, "-m", "data_synthetic", "generate", case, "--out", source])
            if code:
                print(f"{case.stem}: not generated: {reason}", file=sys.stderr)
                continue
        names.append(case.stem)
    return names


def draw_found_ends(lumen, surface, folder):
    """Draws what was taken for ends of a surface that failed, where it got as far as that."""
    shape = surface
    if surface.suffix == ".stl":
        shape = surfaces.write(folder / "surface.vtp", *surfaces.arrays(_read_stl(surface)))
    found = folder / "ends.json"
    run([lumen, "check", surface, "--ends", found, "--repaired", folder / "repaired.vtp"])
    shape = folder / "repaired.vtp" if (folder / "repaired.vtp").exists() else shape
    command = [sys.executable, "-m", "anatomy", "ends", "--surface", shape, "--out", folder / "ends.png"]
    run(command + (["--ends", found] if found.exists() else []))


def _read_stl(path):
    reader = surfaces.vtk.vtkSTLReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def run_further_steps(row, case, folder, build):
    """Takes a surface whose anatomy is right through the further steps; the first that fails is the row's outcome."""
    for step, command in campaign_steps.steps_of(case, folder, build):
        code, reason, seconds = run(command)
        row["cpu_s"] = round(row["cpu_s"] + seconds, 1)
        if code:
            row.update(step=step, outcome={2: "refused", 3: "failed"}.get(code, "broken"), reason=reason)
            return
    row["step"] = "volume mesh"


def real_row(surface, ends, out, build, through):
    """The row of a real surface, of which only the number of ends is known; with `through` up to the volume mesh."""
    row = dict.fromkeys(COLUMNS, "") | {"patient": surface.stem, "style": "real", "ends_expected": ends}
    folder = out / "work"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / "case.yaml").write_text(campaign_steps.CASE.format(name=surface.stem, path=surface))
    code, reason, row["cpu_s"] = run([build / "lumen", "process", surface, "--out", folder / "anatomy"])
    row.update(step="anatomy", outcome={0: "right", 2: "refused", 3: "failed"}.get(code, "broken"), reason=reason)
    if code == 0:
        row["reason"], row["ends"] = "", len(json.loads((folder / "anatomy" / "anatomy.json").read_text())["ends"])
        if row["ends"] != ends:
            row.update(outcome="wrong", reason=f"{row['ends']} ends, not {ends}")
        elif through:
            run_further_steps(row, folder / "case.yaml", folder, build)
    return row


def keep_failed_surface(row, surface, out, lumen):
    """Leaves the surface of a row that is not right in out/kept, with a picture."""
    kept = out / "kept" / f"{row['patient']} {row['style']}".replace(" ", "_")
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(out / "work", kept)
    draw_found_ends(lumen, surface, kept)


def write_tables(rows, out):
    """campaign.csv, and outcomes.csv: how many of each style, outcome and step, and their seconds."""
    with (out / "campaign.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    counts = {}
    for row in rows:
        entry = counts.setdefault((row["style"], row["outcome"], row["step"]), [0, 0, 0.0])
        entry[:] = entry[0] + 1, entry[1] + bool(row["false_stubs"]), entry[2] + row["cpu_s"]
    with (out / "outcomes.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["style", "outcome", "step", "count", "with_false_stubs", "mean_cpu_s"])
        writer.writerows([*key, n, stubs, round(seconds / n, 1)] for key, (n, stubs, seconds) in sorted(counts.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--styles", nargs="+", default=list(STYLES), choices=list(STYLES))
    parser.add_argument(
        "--through",
        type=int,
        default=2,
        help="patients whose surfaces go on to the volume mesh, the real surfaces with them; 0: anatomy alone",
    )
    parser.add_argument("--build", type=pathlib.Path, default=build_folder())
    parser.add_argument("--out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    build = options.build.resolve()
    lumen = build / "lumen"
    options.out.mkdir(parents=True, exist_ok=True)
    out = options.out.resolve()
    rows = []

    def done(row, surface):
        if row["outcome"] != "right":
            keep_failed_surface(row, surface, out, lumen)
        rows.append(row)
        print(*(row[key] for key in COLUMNS), sep="  ", flush=True)
        write_tables(rows, out)

    for surface, ends in campaign_steps.real_surfaces():
        done(real_row(surface, ends, out, build, options.through > 0), surface)
    for number, name in enumerate(draw(options.patients, options.seed, out)):
        patient = Patient(out / "source" / name)
        for style in options.styles:
            row = dict.fromkeys(COLUMNS, "")
            row.update(patient=name, style=style, ends_expected=len(patient.ends()), step="anatomy")
            folder = out / "work"
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            try:
                made = STYLES[style](patient)
            except lofts.UnionFailed as reason:
                print(f"{name} {style}: not made: {reason}", file=sys.stderr)
                continue
            surface = write_style_file(made, folder)
            code, reason, row["cpu_s"] = run([lumen, "process", surface, "--out", folder / "anatomy"])
            row["reason"] = reason if code else ""
            row["outcome"] = {0: "right", 2: "refused", 3: "failed"}.get(code, "broken")
            if code == 0:
                found = campaign_truth.compare(patient, style, folder / "anatomy")
                wrong, row["ends"], row["lesion_mm"], row["lesion_percent"] = found
                row["false_stubs"] = campaign_truth.false_stubs(folder / "anatomy")
                if wrong:
                    row.update(outcome="wrong", reason=wrong)
                elif number < options.through:
                    run_further_steps(row, out / "cases" / f"{name}.yaml", folder, build)
            done(row, surface)
    right = sum(row["outcome"] == "right" for row in rows)
    warned = sum(bool(row["false_stubs"]) for row in rows)
    print(f"{right} of {len(rows)} right, {warned} with a false warning of a stub")


if __name__ == "__main__":
    main()

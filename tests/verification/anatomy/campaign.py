"""How many drawn patients, reconstructed in many ways, go through `lumen process`.

Run: /usr/bin/python3 tests/verification/anatomy/campaign.py --patients 20 --seed 1 --out FOLDER [--build build]
[--styles "loft 16" ...] [--through 2]: campaign.csv has a row for each surface with outcome, seconds and reason,
outcomes.csv counts them; a surface that was refused or came out wrong stays in FOLDER/kept with a picture. Of the first
patients (--through) each style goes on through plan, deployment and volume mesh, and so do the real surfaces of the
shared data. Right is: every end within 1 mm of the truth and no other, as many branches, and the worst lesion within
1 mm and 3 % of diameter, or within the band that a warning in anatomy.json states.
"""

import argparse
import csv
import json
import pathlib
import resource
import shutil
import subprocess
import sys

import lofts
import masks
import numpy as np
import surfaces

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))
import campaign_steps  # noqa: E402  (takes the study's settings from the repository)

COLUMNS = ["patient", "style", "outcome", "step", "cpu_s", "ends", "ends_expected", "lesion_mm", "lesion_percent"]
COLUMNS.append("reason")
NEAR_MM, STENOSIS_PERCENT = 1.0, 3.0
LEAST_LESION = 30.0  # per cent by diameter: milder ones are not looked for
FEW_VOXELS, QUARTER = "lumen of few voxels", "up to a quarter"  # a warning of `lumen`, and the error of areas it states
STUB_MM = 2.0
VOXEL_MM = 0.35
ROOT_SHARE = 0.8  # of the parent's radius: where a lofted side branch begins, it widens by 45 degrees


class Patient:
    """A drawn patient's truth: axes, radii and worst lesion; and its exact surface."""

    def __init__(self, folder):
        self.truth = json.loads((folder / "truth.json").read_text())
        self.points, self.triangles = surfaces.arrays(surfaces.read(folder / "lumen.vtp"))
        self.branches = [
            {key: np.array(branch[key]) for key in ("s_mm", "points_mm", "radius_mm", "healthy_radius_mm")}
            for branch in self.truth["branches"]
        ]

    def ends(self):
        """[(centre (3,), outward direction (3,), radius)] of the inlet and the outlets, mm."""
        found = []
        for number, branch in enumerate(self.branches):
            for at, beside in ((0, 1), (-1, -2)) if number == 0 else ((-1, -2),):
                outward = branch["points_mm"][at] - branch["points_mm"][beside]
                outward /= np.linalg.norm(outward)
                found.append((branch["points_mm"][at], outward, branch["radius_mm"][at]))
        return found

    def lesion(self):
        """(places (n, 3) mm, least and most diameter stenosis in per cent) of the worst lesion, or None.

        Two throats of nearly one width are both the worst place: no measurement tells them apart.
        Where a side branch opens a throat, its tube is not the lumen. What is measured there lies between the
        stenosis of the tube and the worst one of a section that no other branch touches; so does its place.
        """
        every = [(lesion, k) for k, branch in enumerate(self.truth["branches"]) for lesion in branch["lesions"]]
        if not every:
            return None
        worst, k = max(every, key=lambda one: one[0]["true_diameter_stenosis_percent"])
        s, percent = self.branches[k]["s_mm"], worst["true_diameter_stenosis_percent"]
        throat = np.argmin(np.abs(s - worst["true_s_mla_mm"]))
        within = np.abs(s - worst["centre_s_mm"]) < 0.5 * worst["length_mm"]
        narrowed = 1 - self.branches[k]["radius_mm"] / self.branches[k]["healthy_radius_mm"]
        if self.untouched(k)[throat]:
            alike = within & (100 * narrowed > percent - STENOSIS_PERCENT)
            alike[throat] = True
            return self.branches[k]["points_mm"][alike], percent, percent
        stenosis = np.where(self.untouched(k) & within, narrowed, 0)
        beside = np.argmax(stenosis)
        reach = abs(s[beside] - s[throat])
        places = np.abs(s - s[throat]) <= reach
        return self.branches[k]["points_mm"][places], 100 * float(stenosis[beside]), percent

    def untouched(self, number):
        """Whether the tube of a branch is clear of every other one's, at each of its samples: (n,) bool."""
        x, r = self.branches[number]["points_mm"], self.branches[number]["radius_mm"]
        clear = np.full(len(r), True)
        for k, other in enumerate(self.branches):
            if k != number:
                away = np.linalg.norm(x[:, None] - other["points_mm"][None], axis=2)
                clear &= (away - other["radius_mm"]).min(axis=1) > r
        return clear

    def pieces(self, corners, spacing, caps="fan", slant=0.0, stub=None):
        """A loft of each branch; a side branch begins inside its parent and with `stub` ends that many mm outside."""
        made = []
        for number, branch in enumerate(self.branches):
            s, x, r = branch["s_mm"], branch["points_mm"], branch["radius_mm"]
            length = s[-1]
            if number:
                x, r = self.from_parent(number)
            if stub is not None and number:
                length = min(length, self.outside(number) + stub)
            axis = _extended(s, x)
            radius = lambda at, s=s, r=r: np.interp(at, s, r)  # noqa: E731
            made.append(lofts.loft(axis, radius, length, corners, spacing, caps, slant))
        return made

    def from_parent(self, number):
        """(axis (n, 3), radii (n,)) mm of a side branch that starts on its parent's lumen axis, within its lumen.

        Plaque moves the lumen away from the healthy axis, where the drawn branch starts as wide as it is outside.
        """
        branch, parent = self.branches[number], self.parent(number)
        root = np.argmin(np.abs(parent["s_mm"] - self.truth["branches"][number]["s_on_parent_mm"]))
        s = branch["s_mm"]
        fade = np.clip(1 - s / self.outside(number), 0, 1)
        axis = branch["points_mm"] + fade[:, None] * (parent["points_mm"][root] - branch["points_mm"][0])
        return axis, np.minimum(branch["radius_mm"], ROOT_SHARE * parent["radius_mm"][root] + s)

    def parent(self, number):
        """The branch that a side branch leaves."""
        names = [one["name"] for one in self.truth["branches"]]
        return self.branches[names.index(self.truth["branches"][number]["parent"])]

    def outside(self, number):
        """Arc length (mm) at which a side branch leaves its parent's wall."""
        branch, parent = self.branches[number], self.parent(number)
        away = np.linalg.norm(branch["points_mm"][:, None] - parent["points_mm"][None], axis=2)
        clear = (away - parent["radius_mm"][None]).min(axis=1) - branch["radius_mm"]
        return float(branch["s_mm"][np.argmax(clear > 0)])


def _extended(s, x):
    """The axis as a function of arc length, straight beyond its ends."""

    def axis(at):
        at = np.asarray(at, float)
        inside = np.column_stack([np.interp(at, s, x[:, k]) for k in range(3)])
        first, last = (x[1] - x[0]) / (s[1] - s[0]), (x[-1] - x[-2]) / (s[-1] - s[-2])
        return inside + np.minimum(at - s[0], 0)[:, None] * first + np.maximum(at - s[-1], 0)[:, None] * last

    return axis


def _opened(patient):
    points, triangles = patient.points, patient.triangles
    middle = points[triangles].mean(axis=1)
    cap = np.zeros(len(triangles), bool)
    for centre, outward, radius in patient.ends():
        on = np.abs((middle - centre) @ outward) < 1e-3
        cap |= on & (np.linalg.norm(middle - centre, axis=1) < 1.2 * radius)
    return points, triangles[~cap]


STYLES = {
    "as it is": lambda p: (p.points, p.triangles),
    "open": _opened,
    "loft 8": lambda p: lofts.fused(p.pieces(8, 0.8)),
    "loft 12": lambda p: lofts.fused(p.pieces(12, 0.6)),
    "loft 16": lambda p: lofts.fused(p.pieces(16, 0.5)),
    "loft 24": lambda p: lofts.fused(p.pieces(24, 1.0)),
    "loft 16 polygon caps": lambda p: lofts.fused(p.pieces(16, 0.7, "polygon")),
    "slanted": lambda p: lofts.fused(p.pieces(24, 0.5, slant=30)),
    "rounded": lambda p: lofts.fused(p.pieces(24, 0.5, "round")),
    "stubs": lambda p: lofts.fused(p.pieces(24, 0.5, stub=STUB_MM)),
    "mask .35": lambda p: lofts.contoured(p.points, p.triangles, VOXEL_MM),
    "label .35": lambda p: lofts.voxelised(p.points, p.triangles, VOXEL_MM),
    "decimated": lambda p: lofts.decimated(p.points, p.triangles, 0.1),
    "noise .02": lambda p: (lofts.noised(p.points, 0.02, 1), p.triangles),
    "noise .05": lambda p: (lofts.noised(p.points, 0.05, 1), p.triangles),
}


def compare(patient, style, folder):
    """(what is wrong, or empty; ends found; distance of the lesion in mm; its error in points of per cent)."""
    found = json.loads((folder / "anatomy.json").read_text())
    expected = patient.ends()
    wrong, off_mm, off_percent = [], "", ""
    if len(found["ends"]) != len(expected):
        wrong.append(f"{len(found['ends'])} ends, not {len(expected)}")
    elif style != "stubs":
        centres = np.array([end["centre_mm"] for end in found["ends"]])
        for centre, outward, radius in expected:
            lost = radius * (
                style in ("mask .35", "label .35", "rounded", "noise .05", "noise .02")
            )  # the caps are not kept there
            if np.linalg.norm(centres - centre, axis=1).min() > NEAR_MM + lost:
                wrong.append(f"no end near {np.round(centre, 1).tolist()}")
    if len(found["branches"]) != len(patient.branches):
        wrong.append(f"{len(found['branches'])} branches, not {len(patient.branches)}")
    lesion = patient.lesion()
    if lesion and lesion[2] > LEAST_LESION:
        if not found["lesions"]:
            wrong.append("no lesion")
        else:
            places, least, most = lesion

            def distance(one):
                return float(np.linalg.norm(places - _place(one, folder), axis=1).min())

            best = min(found["lesions"], key=distance)
            off_mm, percent = round(distance(best), 2), best["diameter_stenosis_percent"]
            off_percent = round(percent - np.clip(percent, least, most), 1)
            if off_mm > NEAR_MM or abs(off_percent) > max(STENOSIS_PERCENT, stated_band(found, percent)):
                wrong.append(f"lesion {off_mm} mm and {off_percent} % off")
    return "; ".join(wrong), len(found["ends"]), off_mm, off_percent


def stated_band(anatomy, percent):
    """Points of per cent that a diameter stenosis may be off by what a warning says of the areas; 0: nothing said."""
    said = [one["detail"] for one in anatomy["repairs"] if one["what"] == FEW_VOXELS]
    return (1 - np.sqrt(0.75)) * (100 - percent) if said and QUARTER in said[0] else 0.0


def written(made, folder):
    """The file of a style's surface, or of its labels (nx, ny, nz) with their low corner."""
    if made[0].ndim < 3:
        return surfaces.write(folder / "surface.stl", *made)
    labels, low = made
    affine = np.diag([VOXEL_MM, VOXEL_MM, VOXEL_MM, 1.0])
    affine[:3, 3] = low
    return masks.nifti(folder / "surface.nii.gz", labels, affine)


def _place(lesion, folder):
    with (folder / "sections.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["branch"] == lesion["branch"]]
    best = min(rows, key=lambda row: abs(float(row["s_mm"]) - lesion["s_mla_mm"]))
    return np.array([float(best[key]) for key in ("x_mm", "y_mm", "z_mm")])


def run(command, seconds=600):
    """(exit code, last lines of standard error, CPU seconds) of a command in the repository."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run([str(c) for c in command], cwd=ROOT, text=True, capture_output=True, timeout=seconds)
        code, text = done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        code, text = -1, f"longer than {seconds} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    errors = [k for k, line in enumerate(lines) if "error:" in line]
    return code, " ".join(lines[errors[-1] :] if errors else lines[-1:]), round(cpu, 1)


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


def picture(lumen, surface, folder):
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


def go_through(row, case, folder, build):
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
            go_through(row, folder / "case.yaml", folder, build)
    return row


def keep(row, surface, out, lumen):
    """Leaves the surface of a row that is not right in out/kept, with a picture."""
    kept = out / "kept" / f"{row['patient']} {row['style']}".replace(" ", "_")
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(out / "work", kept)
    picture(lumen, surface, kept)


def write_tables(rows, out):
    """campaign.csv, and outcomes.csv: how many of each style and outcome, at which step, and their seconds."""
    with (out / "campaign.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    counts = {}
    for row in rows:
        entry = counts.setdefault((row["style"], row["outcome"], row["step"]), [0, 0.0])
        entry[0], entry[1] = entry[0] + 1, entry[1] + row["cpu_s"]
    with (out / "outcomes.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["style", "outcome", "step", "count", "mean_cpu_s"])
        writer.writerows([*key, n, round(seconds / n, 1)] for key, (n, seconds) in sorted(counts.items()))


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
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    build = options.build.resolve()
    lumen = build / "lumen"
    options.out.mkdir(parents=True, exist_ok=True)
    out = options.out.resolve()
    rows = []

    def done(row, surface):
        if row["outcome"] != "right":
            keep(row, surface, out, lumen)
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
            except lofts.NotMade as reason:
                print(f"{name} {style}: not made: {reason}", file=sys.stderr)
                continue
            surface = written(made, folder)
            code, reason, row["cpu_s"] = run([lumen, "process", surface, "--out", folder / "anatomy"])
            row["reason"] = reason if code else ""
            row["outcome"] = {0: "right", 2: "refused", 3: "failed"}.get(code, "broken")
            if code == 0:
                wrong, row["ends"], row["lesion_mm"], row["lesion_percent"] = compare(
                    patient, style, folder / "anatomy"
                )
                if wrong:
                    row.update(outcome="wrong", reason=wrong)
                elif number < options.through:
                    go_through(row, out / "cases" / f"{name}.yaml", folder, build)
            done(row, surface)
    right = sum(row["outcome"] == "right" for row in rows)
    print(f"{right} of {len(rows)} right")


if __name__ == "__main__":
    main()

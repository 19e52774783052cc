"""Study, cases and devices in YAML with bad values, keys, tags or names, and unusual ones that are allowed."""

import shutil

from input_cases import input_case, module
from places import ROOT

CASE = "cases/one.yaml"
SURFACE = """kind: surface
description: a vessel of one's own
patient: {lvm_g: 130, sbp_mmhg: 125, dbp_mmhg: 78}
lumen: {path: data/vessel.stl, units: mm}
"""


def study(folder, case=None, name=CASE):
    """Makes a folder like config/ with all devices and one case; returns the command that validates it.

    The case is the shipped quick_focal, or the text `case`.
    """
    config = folder / "config"
    shutil.copytree(ROOT / "config" / "devices", config / "devices")
    (config / "cases").mkdir()
    text = (ROOT / "config" / "cases" / "quick_focal.yaml").read_text() if case is None else case
    (config / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    (config / "study.yaml").write_text("cohorts:\n  quick: [one]\n")
    return module("workflow", "validate", "--folder", config)


def edited(folder, old, new, file=CASE):
    """The command of `study` after one text of a file was replaced; the text must occur in the file."""
    command = study(folder)
    path = folder / "config" / file
    text = path.read_text()
    assert old in text, old
    path.write_text(text.replace(old, new, 1))
    return command


EDITS = {
    "a mass of less than nothing": ("lvm_g: 130", "lvm_g: -130"),
    "a mass in kilograms": ("lvm_g: 130", "lvm_g: 0.13"),
    "a mass in quotation marks": ("lvm_g: 130", 'lvm_g: "130"'),
    "a mass with a decimal comma": ("lvm_g: 130", "lvm_g: 130,5"),
    "a mass that is infinite": ("lvm_g: 130", "lvm_g: 1e999"),
    "a mass of five thousand digits": ("lvm_g: 130", "lvm_g: 1" + 5000 * "0"),
    "a mass in minutes and seconds": ("lvm_g: 130", "lvm_g: 2:10"),
    "no mass at all": ("lvm_g: 130, ", ""),
    "pressures that are swapped": ("sbp_mmhg: 125, dbp_mmhg: 78", "sbp_mmhg: 78, dbp_mmhg: 125"),
    "pressures in kilopascals": ("sbp_mmhg: 125", "sbp_mmhg: 16.6"),
    "a misspelt key": ("lvm_g: 130", "lvmg: 130"),
    "a key given twice": ("lvm_g: 130", "lvm_g: 130, lvm_g: 140"),
    "a key that is a list": ("lvm_g: 130", "? [lvm_g]\n  : 130"),
    "a tab in the indentation": ("patient:", "\tpatient:"),
    "a tag that runs a program": ("seed: 4", 'seed: !!python/object/apply:os.system ["true"]'),
    "a tag of one's own": ("seed: 4", "seed: !mine 4"),
    "a tag that its value does not fit": ("seed: 4", "seed: !!int four"),
    "an alias of nothing": ("seed: 4", "seed: *none"),
    "an alias within its own anchor": ("seed: 4", "seed: &a [*a]"),
    "half a character": ("description: Small", 'description: "\\ud800" #'),
    "two documents in one file": ("settings:", "---\nsettings:"),
    "three thousand side branches": ("side_branches:", "side_branches:\n" + 3000 * "    - {s_mm: 9}\n"),
    "a narrowing of more than all": ("diameter_stenosis_percent: 50", "diameter_stenosis_percent: 150"),
    "a narrowing past the vessel's end": ("centre_s_mm: 15", "centre_s_mm: 500"),
    "a device that is not in the catalogue": ("device: semi_compliant", "device: ../semi_compliant"),
    "a size that the family does not have": ("diameter_mm: 2.5, length_mm: 15", "diameter_mm: 2.6, length_mm: 15"),
    "a pressure above the rated burst": ("pressure_bar: 10", "pressure_bar: 30"),
    "a balloon in a stent's step": ("device: des", "device: non_compliant"),
    "a device without a place": ("branch: main, lesion: 1, pressure_bar: 10", "branch: main, pressure_bar: 10"),
    "a branch that runs a shell": ("branch: main, lesion: 1", "branch: $(reboot), lesion: 1"),
    "a setting of no section": ("reference: {", "refrence: {"),
}


def make(name, old, new):
    input_case(name)(lambda folder: edited(folder, old, new))


for one, (before, after) in EDITS.items():
    make(one, before, after)


@input_case("a case file of nothing")
def _(folder):
    return study(folder, "")


@input_case("a case file of one word")
def _(folder):
    return study(folder, "vessel\n")


@input_case("a case file that is not text")
def _(folder):
    return study(folder, bytes(range(256)))


@input_case("a case file in UTF-16")
def _(folder):
    return study(folder, SURFACE.encode("utf-16"))


@input_case("lists of lists of aliases, 9^9 values")
def _(folder):
    laughs = "".join(f"k{i}: &k{i} [{','.join(9 * [f'*k{i - 1}'])}]\n" for i in range(1, 10))
    return study(folder, "k0: &k0 [1]\n" + laughs)


@input_case("lists three thousand deep")
def _(folder):
    return study(folder, "kind: " + 3000 * "[" + 3000 * "]")


@input_case("a case named like an option")
def _(folder):
    return study(folder, name="cases/--help.yaml")


@input_case("a case named with a blank and a semicolon")
def _(folder):
    return study(folder, name="cases/one; reboot.yaml")


@input_case("a case that ends in .yml")
def _(folder):
    return study(folder, name="cases/one.yml")


@input_case("a cohort of a case that is not there")
def _(folder):
    return edited(folder, "[one]", "[one, two]", "study.yaml")


@input_case("a study without cohorts")
def _(folder):
    return edited(folder, "cohorts:\n  quick: [one]", "flow: {}", "study.yaml")


@input_case("a study that is a link to nothing")
def _(folder):
    command = study(folder)
    (folder / "config" / "study.yaml").unlink()
    (folder / "config" / "study.yaml").symlink_to("gone.yaml")
    return command


@input_case("a folder without a configuration")
def _(folder):
    return module("workflow", "validate", "--folder", folder)


@input_case("a balloon's chart that is not 100 % at nominal")
def _(folder):
    return edited(folder, "nominal_pressure_bar: 8", "nominal_pressure_bar: 7", "devices/semi_compliant.yaml")


@input_case("a balloon's chart of columns of two lengths")
def _(folder):
    return edited(
        folder, "[2, 4, 6, 8, 10, 12, 14, 16, 18]", "[2, 4, 6, 8, 10, 12, 14, 16]", "devices/semi_compliant.yaml"
    )


@input_case("a balloon's chart that falls")
def _(folder):
    return edited(folder, "92.0, 95.2", "95.2, 92.0", "devices/semi_compliant.yaml")


@input_case("a balloon that is wider crimped than open")
def _(folder):
    return edited(folder, "crimped_diameter_mm: 0.85", "crimped_diameter_mm: 1.9", "devices/semi_compliant.yaml")


@input_case("a stent whose delivery balloon is no balloon")
def _(folder):
    return edited(folder, "delivery_balloon: des_balloon", "delivery_balloon: des", "devices/des.yaml")


@input_case("a device of no kind")
def _(folder):
    return edited(folder, "kind: balloon", "kind: laser", "devices/semi_compliant.yaml")


@input_case("a lumen given in two ways")
def _(folder):
    return study(
        folder,
        SURFACE.replace("units: mm", "units: mm, ct: {path: a.nii, inlet_mm: [0, 0, 0], outlets_mm: [[9, 0, 0]]}"),
    )


@input_case("a label of nothing")
def _(folder):
    return study(folder, SURFACE.replace("units: mm", "units: mm, label: 0"))


@input_case("a point of two coordinates")
def _(folder):
    return study(folder, SURFACE.replace("units: mm", "units: mm, inlet_point_mm: [1, 2]"))


@input_case("a vessel to generate and a surface at once")
def _(folder):
    return study(folder, SURFACE + "vessel: {seed: 1}\n")


@input_case("a measured FFR without a place")
def _(folder):
    return study(folder, SURFACE + "measured: {ffr_pre: 0.8}\n")


@input_case("a measured FFR in percent")
def _(folder):
    return study(folder, SURFACE + "measured: {ffr_pre: 80, probe: {branch: main, s_mm: 10}}\n")


@input_case("a cardiac output for a single artery that is not named")
def _(folder):
    return study(folder, SURFACE.replace("lvm_g: 130", "cardiac_output_l_per_min: 5"))


@input_case("a measured inflow in mL/s")
def _(folder):
    return study(folder, SURFACE.replace("lvm_g: 130", "hyperaemic_inflow_ml_per_min: 2.3"))


# Inputs that are unusual, but allowed.

ALLOWED = {
    "a description of markup, quotes and an emoji": (
        "description: Small",
        "description: <script>alert('1')</script> \U0001f600 Small",
    ),
    "a description that is a date": ("description: Small", "description: 2026-01-02 #"),
    "a description of ten thousand characters": ("description: Small", "description: " + 10000 * "long "),
    "numbers with leading zeros and exponents": ("lvm_g: 130, sbp_mmhg: 125", "lvm_g: 0130, sbp_mmhg: 1.25e+2"),
    "values in an anchor and its alias": ("seed: 4", "seed: &number 4"),
    "a merge key": ("patient: {lvm_g: 130", "patient: {<<: {lvm_g: 130}"),
    "a seed of nought": ("seed: 4", "seed: 0"),
    "the heaviest heart and the lowest pressure": (
        "lvm_g: 130, sbp_mmhg: 125, dbp_mmhg: 78",
        "lvm_g: 500, sbp_mmhg: 60, dbp_mmhg: 30",
    ),
}
for one, (before, after) in ALLOWED.items():
    make(one, before, after)


@input_case("a case file with a byte-order mark")
def _(folder):
    return study(folder, ("\ufeff" + SURFACE).encode())


@input_case("a case file with lines that end as on Windows")
def _(folder):
    return study(folder, SURFACE.replace("\n", "\r\n"))


@input_case("a case file that is a link")
def _(folder):
    command = study(folder, SURFACE, name="mine.yaml")
    (folder / "config" / CASE).symlink_to(folder / "config" / "mine.yaml")
    return command


@input_case("a case file in the form of JSON")
def _(folder):
    patient = '{"lvm_g": 130, "sbp_mmhg": 125, "dbp_mmhg": 78}'
    lumen = '{"path": "data/a b.stl", "units": "mm"}'
    return study(folder, f'{{"kind": "surface", "description": "\\u00e9", "patient": {patient}, "lumen": {lumen}}}')


@input_case("a path with blanks and quotes")
def _(folder):
    return study(folder, SURFACE.replace("data/vessel.stl", '"/data/it\'s a vessel; 1.stl"'))


@input_case("a study of one case in two cohorts")
def _(folder):
    return edited(folder, "quick: [one]", "quick: [one]\n  again: [one]", "study.yaml")

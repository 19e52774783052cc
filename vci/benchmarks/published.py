"""Compares engine and finite-element truth with measured stents and balloons on benches, in cadavers and in patients.

Writes published.csv, a row for each published figure. SOURCES names all measurements that were read. NOT_COMPARED lists
the figures that have none of ours beside them, with the reason.
"""

import argparse
import csv
import dataclasses
import json
import pathlib
import sys
import tempfile

import numpy as np
import yaml

from common.documents.config import load_devices
from common.errors import guarded
from common.files import replacing
from vci.benchmarks import bench_cases, scenes
from vci.benchmarks.device_shapes import ring_diameters
from vci.benchmarks.programs import run_program

AZIZ = "Aziz 2007, Heart 93:1562 (499 lesions)"
SANGIORGI = "Sangiorgi, Romagnoli and Colombo, a review in Cardiovascular News; its own source was not read"
ILUMIEN = "ILUMIEN II, Maehara 2015 (OCT)"
YANG = "Yang 2025, doi 10.3389/fcvm.2025.1524390 (416 lesions, IVUS)"
FUJINO = "Fujino 2018, doi 10.4244/EIJ-D-17-00962 (OCT, 261 patients)"
EX_VIVO = "OCT of ten calcified hearts ex vivo, non-compliant balloon 1:1"
GAIN = "OCT before and after stenting, PMC8920319 (about 200 frames); its own finite elements give 1.43 (0.41)"
SCHMIDT = "Schmidt 2017, doi 10.1515/cdbme-2017-0029 (five 3.0 mm stents)"
WIESENT = "Wiesent 2019, doi 10.1371/journal.pone.0224026"
MARTIN = "Martin and Boyle 2013, doi 10.1002/cnm.2557"
KITAHARA = "Kitahara 2016, doi 10.4244/EIJV12I2A32 (eight 3.0 mm stents, OCT)"
HERING = "Hering 1996, Z Kardiol 85:273 (44 patients, angioplasty without stent)"
ROZENMAN = "Rozenman 1993, Am J Cardiol 72:1020 (696 lesions, angioplasty without stent)"
MAXIMAL = "micro-CT of 4.0 mm stents after two 6.0 mm balloons (EuroIntervention)"
SOURCES = (
    *(AZIZ, SANGIORGI, ILUMIEN, YANG, FUJINO, EX_VIVO, GAIN, HERING, ROZENMAN),  # patients and cadavers
    *(SCHMIDT, WIESENT, MARTIN, KITAHARA, MAXIMAL),  # benches
)


@dataclasses.dataclass(frozen=True)
class NotCompared:
    """A published figure without one of ours beside it.

    source: one of SOURCES. measured: the figure in words, with its value where one is known. reason: why there is none
    of ours, as sentences.
    """

    source: str
    measured: str
    reason: str


THICKNESS = NotCompared(
    FUJINO,
    "change of expansion by 0.5 mm of the calcium's thickness: -3.40 %",
    "A drawn sheet of calcium is half as thick as its plaque. So it cannot change alone.",
)
NOT_COMPARED = (
    THICKNESS,
    NotCompared(
        AZIZ,
        "the balloon's shortfall grows with the ratio of balloon to vessel; recoil does not depend on predilatation",
        "Twelve drawn patients are too few for a trend, and their plans are proposed by one rule.",
    ),
    NotCompared(
        YANG,
        "the smallest stent area falls with the lesion's calcium score (r 0.80)",
        "Twelve drawn patients are too few: calcium is in three of ten lesions.",
    ),
    NotCompared(
        EX_VIVO,
        "a balloon 1.0 mm wider than the stent ruptured 6 of 10 vessels at 20 atm",
        "No tissue of either model can tear.",
    ),
    NotCompared(
        WIESENT,
        "diameter and dog-bone against pressure, of two stents in air",
        "The curves are figures of an open paper, but no copy beyond its abstract was in reach. The abstract has no "
        "number. So the rows of free expansion stand alone.",
    ),
    NotCompared(
        MARTIN,
        "diameter against pressure, for three models of a balloon",
        "It is a simulation. Only its abstract was in reach, and that has no number. What folding changes in this "
        "engine is in the section on folded balloons.",
    ),
    NotCompared(
        KITAHARA,
        "stents of three metals in a silicone vessel at nominal pressure, and after 3.25 mm at 20 atm: while inflated, "
        "steel opens less; after post-dilatation, steel recoils less",
        "The catalogue has one metal, and a stent's recoil in air is an input of both models. Only the abstract was in "
        "reach. It has no area, nor the vessel's size and stiffness.",
    ),
)
COLUMNS = ["bench", "quantity", "unit", "published", "engine", "truth", "n", "remark", "source"]
VESSEL_MM = 3.0  # healthy diameter of the narrowed vessels
STENOSIS_PERCENT = 65  # of their diameter
ARCS_DEG, LENGTHS_MM = (90, 180, 270), (5, 10)  # arcs and lengths of the calcium
ATMOSPHERES = (10, 20, 30)  # balloon pressures; one atmosphere is taken as one bar
BALLOON_BAR = (1, 1.5, 2, 3, 4, 6, 8, 12)  # pressures of a balloon without stent
TISSUES = {  # plaque of the lesion in which it is inflated
    "lipid plaque": {"plaque": "lipid"},
    "fibrous plaque": {"plaque": "fibrous"},
    "calcium of 90 degrees": {"plaque": "fibrous", "calcium": {"arc_deg": 90, "length_mm": 10}},
    "calcium of 270 degrees": {"plaque": "fibrous", "calcium": {"arc_deg": 270, "length_mm": 10}},
}
NO_SOURCE = "no measured value was found"
NO_TRUTH_REMARK = "the truth's slices have no axial coupling"


def catalogue_entry(families, family, diameter, length):
    """A balloon or stent of config/devices in one size (mm), as an entry of a scene's devices.

    A stent's entry names its delivery balloon "delivery", which the caller must add.
    """
    entry = dict(families[family])
    for key in ("description", "source", "diameters_mm", "lengths_mm", "designs", "delivery_balloon"):
        entry.pop(key, None)
    if entry["kind"] == "balloon":
        percent = entry["chart"]["diameter_percent"]
        entry["chart"] = {
            "pressure_bar": entry["chart"]["pressure_bar"],
            "diameter_mm": [diameter * p / 100 for p in percent],
        }
    else:
        design = next(d for d in families[family]["designs"] if diameter <= d["up_to_diameter_mm"])
        entry |= {key: design[key] for key in ("maximal_diameter_mm", "crowns", "links")}
        entry["balloon"] = "delivery"
    return entry | {"nominal_diameter_mm": diameter, "length_mm": length}


def stent_diameters(folder, build, families, tube, pressure_bar, wall=None):
    """(places (n,), diameters (n,)) in mm along a stent that its balloon holds open in a tube.

    The stent is of the family `des`, 3.0 mm wide and 18 mm long. The run may be refused after the last stage, because a
    stent that opens freely touches no wall. So the diameters are read from a frame of an earlier stage.
    """
    path = scenes.write_scene(folder, tube, wall=wall)
    scene = json.loads(path.read_text())
    scene["devices"] = {
        "delivery": catalogue_entry(families, "des_balloon", 3.0, 18),
        "stent": catalogue_entry(families, "des", 3.0, 18),
    }
    scene["procedure"] = [scene["procedure"][1]]
    scene["procedure"][0]["devices"][0]["pressure_bar"] = pressure_bar
    path.write_text(json.dumps(scene))
    frames = folder / "frames"
    run_program([build / "vci", "deploy", path, "--out", folder / "out", "--frames", frames])
    return ring_diameters(frames / "frame_device1_0001.vtp")  # the state at the end of the second of three stages


def free_expansion(folder, build, families):
    """Yields rows for a stent that opens without touching a wall: its diameters in the middle and at its ends."""
    for bar in (2, 3, 4, 5, 8, 11, 16):
        _, diameters_mm = stent_diameters(
            folder / f"free_{bar}", build, families, scenes.Tube(30.0, 2.5, 0.0, edge=0.8), bar
        )
        middle, end = diameters_mm[len(diameters_mm) // 2], 0.5 * (diameters_mm[0] + diameters_mm[-1])
        yield {
            "bench": "free expansion",
            "quantity": f"3.0 mm stent at {bar} bar: middle, ends, dog-bone",
            "unit": "mm, mm, %",
            "published": "curves, not in reach as numbers",
            "engine": f"{middle:.2f}, {end:.2f}, {100 * (end - middle) / end:.0f}",
            "source": WIESENT,
            "remark": NO_TRUTH_REMARK,
        }


def maximal_expansion(folder, build, families):
    """Yields a row for a 4.0 mm stent that a 6.0 mm balloon widens in air, after its own balloon."""
    path = scenes.write_scene(folder / "maximal", scenes.Tube(30.0, 4.0, 0.0, edge=0.8))
    scene = json.loads(path.read_text())
    stent = catalogue_entry(families, "des", 4.0, 18)
    limit = stent["maximal_diameter_mm"]
    scene["devices"] = {
        "delivery": catalogue_entry(families, "des_balloon", 4.0, 18),
        "stent": stent | {"maximal_diameter_mm": 6.5},  # else the engine refuses the large balloon
        "large": catalogue_entry(families, "non_compliant", 6.0, 15),
    }
    _, opening, widening = scene["procedure"]
    opening["devices"][0]["pressure_bar"] = families["des_balloon"]["nominal_pressure_bar"]
    widening["devices"] = [opening["devices"][0] | {"device": "large", "pressure_bar": 14}]
    scene["procedure"] = [opening, widening]
    path.write_text(json.dumps(scene))
    frames = folder / "maximal" / "frames"
    run_program([build / "vci", "deploy", path, "--out", folder / "maximal" / "out", "--frames", frames])
    # the second step's second and third stage: its balloon is at full pressure, then out
    held, free = (ring_diameters(frames / f"frame_device1_000{stage}.vtp")[1] for stage in (4, 5))
    middle = len(held) // 2
    yield {
        "bench": "maximal expansion",
        "quantity": "4.0 mm stent after a 6.0 mm balloon at 14 bar",
        "unit": "mm",
        "published": "5.4 to 6.0",
        "engine": f"{free[middle]:.2f}",
        "source": MAXIMAL,
        "remark": f"{held[middle]:.2f} mm on the balloon; the catalogue allows {limit} mm; {NO_TRUTH_REMARK}",
    }


def steel_ring(folder, build, families):
    """Yields rows for a stent that opens in a rigid ring of 1.20 mm: the stent's largest diameter, beside the ring."""
    rigid = {"plaque": {"calcified": {"youngs_modulus_mpa": 1e5, "yield_strain": None}}}
    tube = scenes.Tube(30.0, 2.2, 1 - 1.2 / 4.4, lesion_length=4.0, calcium_deg=360)
    delivery = families["des_balloon"]
    for pressure, label, published in (
        (delivery["nominal_pressure_bar"], "nominal", "2.92 to 3.56"),
        (delivery["rated_burst_pressure_bar"], "rated burst", "3.39 to 3.98"),
    ):
        _, diameters_mm = stent_diameters(folder / f"ring_{label.split()[0]}", build, families, tube, pressure, rigid)
        yield {
            "bench": "steel ring of 1.20 mm",
            "quantity": f"largest diameter at {label} pressure ({pressure} bar)",
            "unit": "mm",
            "published": published,
            "engine": f"{diameters_mm.max():.2f}",
            "source": SCHMIDT,
            "remark": f"{diameters_mm.min():.2f} mm within the ring; {NO_TRUTH_REMARK}",
        }


def drawn_cohort(folder, build, count, seed):
    """Yields rows for randomly drawn patients with proposed plans: shortfall from the chart, recoil, expansion.

    count: number of patients. seed: seed of the random numbers by which they are drawn.
    """
    run_program([bench_cases.PYTHON, "-m", "data_synthetic", "draw", "--count", count, "--seed", seed, "--out", folder])
    outcomes = [
        bench_cases.run_engine_and_truth(path, folder / path.stem, build)
        for path in sorted(folder.glob("patient*.yaml"))
    ]
    values = [bench_cases.stenting_figures(outcome) for outcome in outcomes if not outcome.refusal]
    refused = len(outcomes) - len(values)
    for key, label, unit, published, source in (
        ("below_chart_percent", "smallest diameter left below the largest balloon's chart", "%", "27.2 (7.2)", AZIZ),
        (
            "short_of_chart_mm",
            "inflated delivery balloon's smallest diameter short of its chart",
            "mm",
            "0.65 (0.27)",
            AZIZ,
        ),
        ("recoil_mm", "recoil", "mm", "0.28 (0.17)", AZIZ),
        (
            "area_of_chart_percent",
            "smallest area over the circle of the largest balloon's chart",
            "%",
            "75 to 79",
            SANGIORGI,
        ),
        ("expansion_percent", "smallest area over healthy area", "%", "72.8 [63 to 81]", ILUMIEN),
        ("gain_mm", "gain in lumen diameter along the stent", "mm", "1.52 (0.51)", GAIN),
    ):
        row = {"bench": "drawn cohort", "quantity": label, "unit": unit, "published": published, "source": source}
        for model in ("engine", "truth"):
            row[model] = mean_sd([value[model][key] for value in values])
        yield row | {"n": len(values), "remark": f"{refused} of {len(outcomes)} refused; mean (SD)"}
    small = {m: [value[m]["expansion_percent"] < 80 for value in values] for m in ("engine", "truth")}
    yield {
        "bench": "drawn cohort",
        "quantity": "patients with a smallest area below 80 % of the healthy one",
        "unit": "%",
        "published": "34.6",
        "n": len(values),
        "source": YANG,
        "remark": "published: of the mean of both reference areas; here: of the healthy area at the same place",
    } | {model: f"{100 * np.mean(found):.0f}" if found else "-" for model, found in small.items()}


def mean_sd(values):
    """Text with mean and sample standard deviation, as "14.5 (4.5)"; "-" for fewer than two values."""
    return f"{np.mean(values):.3g} ({np.std(values, ddof=1):.2g})" if len(values) > 1 else "-"


def narrowed_case(path, plaque, steps):
    """Writes a case file and returns its path: a vessel of VESSEL_MM with a stenosis of STENOSIS_PERCENT.

    plaque: entries of the lesion that describe its plaque. steps: the case's plan, a list of results of plan_step().
    """
    lesion = {"centre_s_mm": 20, "length_mm": 14, "diameter_stenosis_percent": STENOSIS_PERCENT, **plaque}
    main = {"length_mm": 40, "ostial_diameter_mm": VESSEL_MM, "taper_percent_per_cm": 0}
    main |= {"mean_curvature_per_mm": 0.02, "max_curvature_per_mm": 0.05}
    case = {"kind": "synthetic", "description": "a bench", "patient": {"lvm_g": 150, "sbp_mmhg": 120, "dbp_mmhg": 80}}
    case |= {"vessel": {"seed": 1, "main": main, "lesions": [lesion]}, "plan": steps}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(yaml.safe_dump(case))
    return path


def calcified_case(path, arc_deg, length_mm, steps):
    """narrowed_case() with calcium of this arc (degrees) and length (mm) in fibrous plaque."""
    calcium = {"arc_deg": arc_deg, "length_mm": length_mm}
    return narrowed_case(path, {"plaque": "fibrous", "calcium": calcium}, steps)


def plan_step(action, device, diameter, length, bar):
    """A step of a case's plan, with one device in the middle of the lesion. Lengths in mm."""
    place = {"branch": "main", "centre_s_mm": 20, "pressure_bar": bar}
    return {"action": action, "devices": [{"device": device, "diameter_mm": diameter, "length_mm": length, **place}]}


STENTING_PLAN = [
    plan_step("predilatation", "semi_compliant", 2.5, 15, 12),
    plan_step("stent", "des", 3.0, 18, 11),
    plan_step("postdilatation", "non_compliant", 3.0, 15, 16),
]


def calcium_slopes(folder, build):
    """Yields rows for the change of a stent's expansion with the calcium's arc and length, by linear regression."""
    regressors, expansions = [], {"engine": [], "truth": []}
    for arc in ARCS_DEG:
        for length in LENGTHS_MM:
            path = calcified_case(folder / f"calcium_{arc}_{length}.yaml", arc, length, STENTING_PLAN)
            outcome = bench_cases.run_engine_and_truth(path, folder / path.stem, build)
            if not outcome.refusal:
                regressors.append([1.0, arc / 180, length / 5])
                for model, values in bench_cases.stenting_figures(outcome).items():
                    expansions[model].append(values["expansion_percent"])
    slopes = {
        model: np.linalg.lstsq(np.array(regressors), np.array(values), rcond=None)[0]
        for model, values in expansions.items()
    }
    case_count = len(ARCS_DEG) * len(LENGTHS_MM)
    base_row = {"bench": "calcium and expansion", "unit": "%", "source": FUJINO, "n": len(regressors)}
    base_row[
        "remark"
    ] = f"{case_count - len(regressors)} of {case_count} refused; 65 % narrowing in 3.0 mm, 11 and 16 bar"
    for k, label, published in ((1, "180 degrees of arc", "-7.43"), (2, "5 mm of length", "-2.32")):
        row = {model: f"{slopes[model][k]:+.2f}" for model in slopes}
        yield {**base_row, "quantity": f"change of expansion by {label}", "published": published, **row}
    yield {
        **base_row,
        "quantity": "change of expansion by 0.5 mm of thickness",
        "published": "-3.40",
        "remark": f"not computed. {THICKNESS.reason}",
    }
    for model in expansions:
        base_row[model] = f"{min(expansions[model]):.0f} to {max(expansions[model]):.0f}"
    yield {**base_row, "quantity": "expansion", "published": "78 (worst score) to 96"}


def expansion_by_pressure(folder, build):
    """Yields rows for a stent's expansion after a non-compliant balloon as wide as the vessel, at three pressures."""

    def set_pressure(plan):
        use = plan["procedure"][-1]["devices"][0]
        chart = plan["devices"][use["device"]]["chart"]
        bar, mm = chart["pressure_bar"], chart["diameter_mm"]
        chart["diameter_mm"] = mm + [mm[-1] + (mm[-1] - mm[-2]) / (bar[-1] - bar[-2]) * (32 - bar[-1])]
        chart["pressure_bar"] = bar + [32]
        use["pressure_bar"] = pressure_bar

    for label, arc, length in (("little", 90, 5), ("much", 270, 10)):
        for pressure_bar in ATMOSPHERES:
            # A pressure above the rated burst pressure is refused in a case file. So it is set in the plan instead.
            steps = [*STENTING_PLAN[:2], plan_step("postdilatation", "non_compliant", VESSEL_MM, 15, 10)]
            path = calcified_case(folder / f"pressure_{label}_{pressure_bar}.yaml", arc, length, steps)
            outcome = bench_cases.run_engine_and_truth(path, folder / path.stem, build, set_pressure)
            published = {("little", 10): "80 or more", ("much", 30): "80 or more"}.get((label, pressure_bar), "")
            row = {"bench": f"stent in {label} calcium", "unit": "%", "published": published, "source": EX_VIVO}
            row |= {"quantity": f"expansion after a balloon at {pressure_bar} atm", "n": 1}
            row["remark"] = outcome.refusal or f"{arc} degrees, {length} mm long, 65 % narrowing in 3.0 mm"
            if not outcome.refusal:
                figures = bench_cases.stenting_figures(outcome)
                row |= {model: f"{values['expansion_percent']:.0f}" for model, values in figures.items()}
            yield row


def plain_balloon(folder, build):
    """Yields rows for a balloon without stent in a lesion of each tissue: where it opens, and how far it springs back.

    A non-compliant balloon as wide as the healthy vessel is inflated once, to each of BALLOON_BAR in a vessel of its
    own. Diameters are those in the lesion's middle. A pressure at which a model is refused is left out for that model.
    """
    half_open_mm = (1 - 0.5 * STENOSIS_PERCENT / 100) * VESSEL_MM  # half way from the narrowed to the healthy diameter
    for tissue, plaque in TISSUES.items():
        curves, refused = {"engine": {}, "truth": {}}, []
        for bar in BALLOON_BAR:
            steps = [plan_step("predilatation", "non_compliant", VESSEL_MM, 15, bar)]
            path = narrowed_case(folder / f"balloon_{tissue.replace(' ', '_')}_{bar}.yaml", plaque, steps)
            outcome = bench_cases.run_engine_and_truth(path, folder / path.stem, build, continue_chart)
            found = bench_cases.balloon_figures(outcome)
            for model, figures in found.items():
                curves[model][bar] = figures
            refused += [f"{model} at {bar:g} bar" for model in curves if model not in found]
        remark = f"{STENOSIS_PERCENT} % narrowing in 3.0 mm, 3.0 mm non-compliant balloon"
        first = {"source": NO_SOURCE, "remark": f"{remark}; its chart is continued below 2 bar"}
        first["remark"] += f"; refused: {', '.join(refused)}" if refused else ""
        base_row = {"bench": f"balloon in {tissue}", "n": 1, "remark": remark}
        quantity = f"pressures that open it to {half_open_mm:.1f} mm, half way to the healthy diameter"
        yield {**base_row, "quantity": quantity, "unit": "bar", **first} | {
            model: opening_pressures({bar: one["inflated_mm"] for bar, one in curve.items()}, half_open_mm)
            for model, curve in curves.items()
        }
        for bar, published in ((8, "84 (9), below 10 atm"), (12, "94 (12), 10 atm or more")):
            quantity = f"diameter of the inflated balloon at {bar} bar over its nominal diameter"
            yield {**base_row, "quantity": quantity, "unit": "%", "published": published, "source": HERING} | {
                model: f"{100 * curve[bar]['inflated_mm'] / VESSEL_MM:.0f}"
                for model, curve in curves.items()
                if bar in curve
            }
        last = BALLOON_BAR[-1]
        quantity = f"recoil after {last} bar"
        yield {**base_row, "quantity": quantity, "unit": "mm", "published": "0.42 (0.64)", "source": ROZENMAN} | {
            model: f"{curve[last]['inflated_mm'] - curve[last]['final_mm']:.2f}"
            for model, curve in curves.items()
            if last in curve
        }


def continue_chart(plan):
    """Continues the charts of a plan's balloons down to the lowest of BALLOON_BAR, by their first slope."""
    for device in plan["devices"].values():
        bar, mm = device["chart"]["pressure_bar"], device["chart"]["diameter_mm"]
        if bar[0] > BALLOON_BAR[0]:
            lowest_mm = mm[0] - (mm[1] - mm[0]) / (bar[1] - bar[0]) * (bar[0] - BALLOON_BAR[0])
            device["chart"] = {"pressure_bar": [BALLOON_BAR[0], *bar], "diameter_mm": [lowest_mm, *mm]}


def opening_pressures(diameters_mm, wanted_mm):
    """Text of the neighbouring pressures (bar) between which the diameter reaches a wanted one.

    diameters_mm: {pressure: diameter}, from the lowest pressure.
    """
    below = None
    for bar, diameter in diameters_mm.items():
        if diameter >= wanted_mm:
            return f"{bar:g} or less" if below is None else f"{below:g} to {bar:g}"
        below = bar
    return "-" if below is None else f"more than {below:g}"


def all_rows(folder, build, families, drawn, seed):
    """Yields the rows of all benches, as dicts with some of COLUMNS. Raises ComputationError.

    folder: for all files. build: folder of the programs vci and lumen. families: the catalogue of config/devices.
    drawn, seed: number of drawn patients, and the seed of the random numbers by which they are drawn.
    """
    yield from steel_ring(folder, build, families)
    yield from free_expansion(folder, build, families)
    yield from maximal_expansion(folder, build, families)
    yield from drawn_cohort(folder / "drawn", build, drawn, seed)
    yield from calcium_slopes(folder, build)
    yield from expansion_by_pressure(folder, build)
    yield from plain_balloon(folder, build)


def write_rows(path, rows):
    with replacing(path) as partial, partial.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


@guarded
def main(arguments=None):
    """Runs all benches one at a time, from the repository's folder."""
    parser = argparse.ArgumentParser(prog="vci.benchmarks.published", description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="folder of vci and lumen")
    parser.add_argument("--drawn", type=int, default=12, help="drawn patients (12)")
    parser.add_argument("--seed", type=int, default=1, help="of the drawn patients (1)")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for published.csv")
    options = parser.parse_args(arguments)
    families = load_devices("config/devices")
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        rows = list(all_rows(scratch, options.build, families, options.drawn, options.seed))
    write_rows(options.out / "published.csv", rows)


if __name__ == "__main__":
    sys.exit(main())

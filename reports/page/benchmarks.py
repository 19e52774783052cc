"""Benchmarks for the report: the folders that `snakemake benchmarks` wrote, with tables (CSV) and figures."""

import csv

from common.errors import InputError
from reports.page.sources import benchmark_source

# folder of a benchmark: (its title, a text that says what a row of its table is)
TITLES = {
    "deployment_speed": (
        "Deployment: speed against error",
        "A row is a scene at one setting; errors are against the scene's finest balanced run, which the column "
        "reference names. A refused row says why. Medians are over the scenes that balanced.",
    ),
    "deployment_baseline": (
        "Deployment: beside the textbook scheme",
        "Textbook: whole vessel, fixed small step, plain conjugate gradients, stopped by velocity. Both at several "
        "costs. Levels: the cheapest row of each within an error of the mean area, and the ratio of their times.",
    ),
    "deployment_baseline_patients": (
        "Deployment: patients by the textbook scheme",
        "A row is a procedure by one scheme, on the study's mesh. Times: its CPU time over the default's. Errors "
        "are against the default at a tenth of its tolerance. All rows share the mesh and its error.",
    ),
    "deployment_hard_cases": (
        "Deployment: hard cases",
        "Each ends in force balance, or is refused with its reason. First steps: the same cases at five lengths of the "
        "first solver step. Such runs take other paths to the same balance; spread: how far their areas differ.",
    ),
    "deployment_against_published": (
        "Deployment: beside benches, cadavers and patients",
        "A row is a published figure. The change of expansion by the calcium's arc (Fujino 2018) is no test: by it the "
        "strength of calcium was identified in engine and finite-element truth. Empty: not computed, for the reason in "
        "the remark. In brackets: standard deviations or quartiles.",
    ),
    "deployment_calcium_strength": (
        "Deployment: how strong calcium is",
        "A row is a law of calcified plaque. Change: of a stent's expansion by 180 degrees more of calcium; measured "
        "-7.4 % in patients (Fujino 2018), by which the default was chosen. Spread: of the expansion over three first "
        "steps of the solver.",
    ),
    "deployment_sensitivity": (
        "Deployment: what contact distance and margin are worth",
        "A row is a scene with one setting off its default; changes are those of the areas from the default's.",
    ),
    "deployment_coarse_walls": (
        "Deployment: patients on longer edges",
        "A row is a patient on one mesh of wall and devices; the wall carries the study's lumen. Errors of the areas "
        "are against the patient's first row that balanced.",
    ),
    "flow_hard_cases": (
        "Blood flow: hard cases",
        "Each converges, keeps some artificial viscosity, or is refused with its reason. References "
        "are axisymmetric solutions that share no code with the solver; artificial is what is left of that viscosity.",
    ),
    "flow_against_openfoam": (
        "Blood flow: speed against error beside OpenFOAM",
        "A row is a mesh of the same narrowed tube; errors of FFR are against an axisymmetric solution. Settled: the "
        "solve's seconds until FFR kept its value; where it did not converge FFR is a mean over iterations.",
    ),
    "flow_tree_against_openfoam": (
        "Blood flow: a tree beside OpenFOAM",
        "A row is a state on the nodes of one of its meshes, with the flows of our answer given; difference: of "
        "simpleFoam's FFR at the probe from ours. The finer mesh shows simpleFoam's own error.",
    ),
    "flow_speed_error": (
        "Blood flow: error against seconds over the meshes",
        "A row is a mesh; seconds are those of all solves up to it. Errors of FFR are against an axisymmetric solution "
        "(tube) or our finest mesh (tree). Answers: where the default stops. OpenFOAM's rows are those that converged.",
    ),
    "flow_fda_jet": (
        "Blood flow: the jet of the FDA's nozzle",
        "Velocity on the axis in m/s, z mm behind the sudden expansion at a Reynolds number of 500, by five "
        "laboratories and by an axisymmetric solution of the equations.",
    ),
    "flow_finer_mesh": (
        "Blood flow: answers on the next finer mesh",
        "A row is a state of the study; difference: FFR on the next finer mesh minus that of the answer. The estimate "
        "should be no smaller.",
    ),
    "flow_starts": (
        "Blood flow: what a first guess saves",
        "A row is a state of the study, solved from rest, from the reduced models' flow and from the flow of the "
        "predicted state; difference: of FFR from that found from rest.",
    ),
    "flow_growth": (
        "Blood flow: cost by mesh",
        "A row is a mesh of the same narrowed tube; errors of FFR are against an axisymmetric solution. Exponents: of "
        "the cells, fitted to seconds and memory.",
    ),
    "flow_tolerance": (
        "Blood flow: to a tolerance",
        "A row is a narrowed tube; a finer mesh is solved on where the coarser one's error estimate is above the "
        "tolerance; errors of FFR are against an axisymmetric solution.",
    ),
    "flow_wall_shear": (
        "Blood flow: wall shear stress by boundary layers",
        "A row is a mesh of the same narrowed tube; errors in the lesion are in percent of the stress's peak.",
    ),
    "anatomy_speed": (
        "Anatomy: seconds against input size",
        "A row is the same tree with more triangles; steps in seconds.",
    ),
    "anatomy_campaign": (
        "Anatomy: drawn patients, reconstructed in many ways",
        "A row is a surface of a patient whose truth is known, or a real one. Right: its ends, its branches and the "
        "worst lesion are those of the truth. Outcomes: how many surfaces of each style ended so, and their seconds.",
    ),
    "reference_against_solid": (
        "Reference: slices against a solid in three dimensions",
        "A row is a vessel and a mesh of the solid; errors are those of the slices' area, in the stent, at its ends "
        "and beyond.",
    ),
    "reference_straightening": (
        "Reference: straightening by beams against a solid in three dimensions",
        "A row is a bent vessel and a mesh of the solid; curvature is the mean along the stent, lost: the part of it "
        "that the stent takes away.",
    ),
    "reference_against_calculix": (
        "Reference: slices against CalculiX",
        "A row is a load of an inflated ring, or a stage of one slice through its procedure, by both codes.",
    ),
    "reference_sensitivity": (
        "Reference: what its constants are worth",
        "A row is a constant changed by a factor: mean area of three stented slices, or curvature of the stented axis.",
    ),
}
# Benchmarks by which a reader judges the study: {name: cost}. If one was not run, the page says how to run it. The
# first cost is estimated from its 33 deployments and 24 finite-element runs. The others come from the tables in
# flow/measured.md and data_synthetic/measured.md.
COSTS = {
    "deployment_against_published": "some 15 minutes of processor time",
    "flow_hard_cases": "some 6 minutes of processor time",
    "reference_against_solid": "some 6 minutes of processor time",
}
UNITS = {
    "mm2": "mm²",
    "mm3": "mm³",
    "mlmin": "mL/min",
    "mm": "mm",
    "s": "s",
    "mib": "MiB",
    "percent": "%",
    "n": "N",
    "bar": "bar",
}
ABBREVIATIONS = {"ffr": "FFR", "csa": "CSA", "mla": "MLA", "cpu": "CPU", "cg": "CG", "1d": "1D", "mib": "MiB"}
WHOLE_HEADINGS = {"mib": "memory (MiB)"}
MOST_ROWS = 200
LONGEST_NUMBER = 7  # characters; longer numbers are rounded


def read_benchmarks(folder, report):
    """[{name, title, text, tables, figures, cost}] of benchmarks in the order of TITLES, other names last.

    These are the benchmarks in `folder` that were run, and those of COSTS. A benchmark of COSTS that was not run has
    no tables. Tables and figures are copied into the ReportFolder `report`. A figure is {picture, source}, a table is
    {name, columns, rows, source}. source: result of `benchmark_source`. rows: the texts of the CSV, with long numbers
    rounded to four digits. A column is {heading, text}, where `text` tells whether it holds words. Columns without a
    value are left out. Raises InputError for a table without a header.
    """
    entries = folder.iterdir() if folder is not None and folder.is_dir() else ()
    found = {entry.name: entry for entry in entries if entry.is_dir() and any(entry.glob("*.csv"))}
    order = list(TITLES)
    names = sorted({*found, *COSTS}, key=lambda name: (order.index(name) if name in TITLES else len(order), name))
    return [
        {
            "name": name,
            "title": TITLES.get(name, (name.replace("_", " "), ""))[0],
            "text": TITLES.get(name, ("", ""))[1],
            **(taken_in(found[name], report) if name in found else {"tables": [], "figures": []}),
            "cost": COSTS.get(name),
        }
        for name in names
    ]


def taken_in(folder, report):
    """{tables, figures} of a benchmark's folder, in the form that `read_benchmarks` describes."""
    tables, figures = [], []
    for path in sorted(folder.glob("*.csv")):
        data = f"{folder.name}_{path.name}"
        report.copy_data(path, "snakemake benchmarks", data)
        tables.append({**read_rows(path), "source": benchmark_source(path, [data])})
    all_data = [data for table in tables for data in table["source"]["data"]]
    for path in figure_files(folder):
        picture = report.picture(path, f"{folder.name}_{path.stem}")
        figures.append({"picture": picture, "source": benchmark_source(path, all_data)})
    return {"tables": tables, "figures": figures}


def figure_files(folder):
    """The files of a benchmark's figures: the SVG of each, or the PNG if there is no SVG."""
    vector = sorted(folder.glob("*.svg"))
    return vector + [path for path in sorted(folder.glob("*.png")) if path.with_suffix(".svg") not in vector]


def read_rows(path):
    """{name, columns, rows} of a CSV file for display."""
    with path.open(newline="") as file:
        lines = list(csv.reader(file))
    if not lines or not any(lines[0]):
        raise InputError("a benchmark's table is empty", path, "no header", "run `snakemake benchmarks` again")
    rows = [line + [""] * (len(lines[0]) - len(line)) for line in lines[1 : MOST_ROWS + 1]]
    filled = [k for k in range(len(lines[0])) if not rows or any(row[k] for row in rows)]
    columns = [
        {"heading": column_heading(lines[0][k]), "text": not any(is_number(row[k]) for row in rows)} for k in filled
    ]
    return {
        "name": path.stem.replace("_", " "),
        "columns": columns,
        "rows": [[shortened(row[k]) if k else row[k].replace("_", " ") for k in filled] for row in rows],
    }


def column_heading(column):
    """A column's name in words, its unit in brackets: mean_csa_mm2 -> mean csa (mm²)."""
    if column in WHOLE_HEADINGS:
        return WHOLE_HEADINGS[column]
    words = column.replace("ml_per_min", "mlmin").split("_")
    unit = f" ({UNITS[words.pop()]})" if len(words) > 1 and words[-1] in UNITS else ""
    return " ".join(ABBREVIATIONS.get(word, word) for word in words) + unit


def is_number(value):
    """Whether a text is a number."""
    try:
        float(value)
    except ValueError:
        return False
    return True


def shortened(value):
    """Rounds a long decimal number to four significant digits. Short numbers, integers and other texts stay."""
    if len(value) <= LONGEST_NUMBER or not is_number(value) or value.lstrip("-").isdigit():
        return value
    return f"{float(value):.4g}"

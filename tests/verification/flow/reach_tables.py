"""Tables of flow/measured.md over all states of a study: aims, what is reached, cost of meshes, reduced models."""

import pathlib

from page_tables import markdown, read_columns

FLOW = pathlib.Path(__file__).resolve().parents[3] / "flow"
STATE_BEFORE = "pre"  # the state before the intervention
TOLERANCE = 0.005  # the default of setting ffr_tolerance
SECONDS_BEFORE, SECONDS_AFTER = 120, 40  # aims for a state before and after PCI, in CPU s
REACH_COLUMNS = ("aim", "reached", "found")
MESH_COLUMNS = ("rings", "states", "answers there", "no flow", "factorizations", "CPU s", "share of CPU s, %")
MODEL_COLUMNS = ("states of the nine patients where", "axisymmetric minus 3D", "1D network minus 3D")
REDUCED_MODELS = ("axisymmetric", "network")
LOW_FFR = 0.85
RINGS = {"mesh_coarsest.msh": 2, "mesh_coarse.msh": 3, "mesh.msh": 4}


def benchmark_rows(results, benchmark, file, columns):
    """Rows of the table of a benchmark, which must have these columns; [] if it was not run. Raises InputError."""
    path = results / "benchmarks" / benchmark / file
    return read_columns(path, columns) if path.is_file() else []


def aim_for_states(aim, states, value_of, limit, unit):
    """Row on a value of each state that may be at most `limit`: in how many it is, and the largest. [] if no states.

    states: {name of the state: its answer}; value_of: function of an answer, None where the value is not known.
    """
    values = {name: value_of(answer) for name, answer in states.items()}
    if not values:
        return []
    unknown = [name for name, value in values.items() if value is None]
    known = {name: value for name, value in values.items() if value is not None}
    reached = sum(value <= limit for value in known.values())
    found = f"not known in {', '.join(unknown)}"
    if known:
        worst = max(known, key=known.get)
        found = f"at most {known[worst]:.3g}{unit} ({worst})" + (f", {found}" if unknown else "")
    return [[aim, "yes" if reached == len(values) else f"in {reached} of {len(values)}", found]]


def aim_for_sum(aim, value, limit, unit):
    """Row on one value that may be at most `limit`."""
    return [[aim, "yes" if value <= limit else "no", f"{value:.3g}{unit}"]]


def aims_of_study(answers):
    """Rows on the states of a study, [(case, state, document)]."""
    if not answers:
        return []
    before = {case: answer for case, state, answer in answers if state == STATE_BEFORE}
    after = {f"{case} {state}": answer for case, state, answer in answers if state != STATE_BEFORE}
    rows = []
    for words, states, limit in (("before", before, SECONDS_BEFORE), ("after", after, SECONDS_AFTER)):
        aim = f"a state {words} PCI in at most {limit} CPU s"
        rows += aim_for_states(aim, states, lambda answer: answer["cpu_seconds"], limit, " CPU s")
        aim = f"a state {words} PCI with an estimate within {TOLERANCE:g}"
        rows += aim_for_states(aim, states, lambda answer: (answer["error_estimate"] or {}).get("ffr"), TOLERANCE, "")
    minutes = sum(answer["cpu_seconds"] for _, _, answer in answers) / 60
    rows += aim_for_sum(
        "`flow solve` of all states in at most 35 CPU min", minutes, 35, f" CPU min, {len(answers)} states"
    )
    every = {f"{case} {state}": answer for case, state, answer in answers}
    memory = aim_for_states("at most 3 GB", every, lambda answer: answer["peak_memory_mib"] * 2**20 / 1e9, 3, " GB")
    return rows + memory


def aims_of_benchmarks(results):
    """Rows on the hard cases and the comparisons with OpenFOAM and laboratories, as far as they were run."""
    found = benchmark_rows(results, "flow_hard_cases", "hard_cases.csv", ("case", "error", "cpu_s"))
    hard = {row["case"]: row for row in found}
    straight = {case: hard[case] for case in hard if case.startswith("single_")}
    rows = aim_for_states(
        "straight tubes, 62 to 90 %: error within .001", straight, lambda row: abs(float(row["error"])), 0.001, ""
    )
    if "eccentric_62" in hard:
        seconds = float(hard["eccentric_62"]["cpu_s"])
        rows += aim_for_sum("the eccentric lesion of 62 % in at most 15 CPU s", seconds, 15, " CPU s")
    found = benchmark_rows(results, "flow_tree_against_openfoam", "tree.csv", ("state", "cells", "difference"))
    tree = {f"{row['state']}, {row['cells']} cells": row for row in found}
    rows += aim_for_states("OpenFOAM on a tree within .01", tree, lambda row: abs(float(row["difference"])), 0.01, "")
    found = benchmark_rows(results, "flow_fda_jet", "jet.csv", ("row", "within"))
    jet = [row for row in found if "rings" in row["row"]]
    for row in jet[-1:]:
        within, places = row["within"].split(" of ")
        aim = "the FDA's jet within two standard deviations of the laboratories"
        rows.append([aim, "yes" if within == places else "no", f"at {within} of {places} places"])
    found = benchmark_rows(results, "flow_finer_mesh", "finer_mesh.csv", ("state", "estimate", "difference"))
    for when, pairs in pairs_of_finer_meshes(found).items():
        if pairs:
            enough = sum(estimate != "unknown" and float(estimate) >= abs(change) for estimate, change in pairs)
            aim = f"trees {when} PCI: the estimate not below the change to the next finer mesh, in 9 of 10"
            rows.append([aim, "yes" if enough >= 0.9 * len(pairs) else "no", f"in {enough} of {len(pairs)} states"])
    return rows


def pairs_of_finer_meshes(rows):
    """{when: [(estimate, change of FFR)]} of the rows of finer_mesh.csv with a flow on the finer mesh.

    when: "before" or "after" PCI. An estimate is text, `unknown` where there is none.
    """
    pairs = {"before": [], "after": []}
    for row in rows:
        if row["difference"]:
            before = row["state"].endswith(f" {STATE_BEFORE}")
            pairs["before" if before else "after"].append((row["estimate"], float(row["difference"])))
    return pairs


def aim_for_lines():
    """Row on the lines of flow/, without tests."""
    files = [path for path in FLOW.rglob("*") if path.suffix in (".py", ".cpp")]
    lines = sum(len(path.read_text().splitlines()) for path in files)
    return [["at most 6,000 lines of code", "yes" if lines <= 6000 else "no", f"{lines} lines"]]


def reach(results, answers):
    """Markdown: the aims for the flow solver, whether they are reached, the figures. None where nothing was run.

    answers: [(case, state, content of ffr.json)].
    """
    rows = aims_of_study(answers) + aims_of_benchmarks(results)
    return markdown(REACH_COLUMNS, rows + aim_for_lines()) if rows else None


def meshes(answers):
    """Markdown with a row for each mesh of the sequence, summed over all states; None if no state was solved.

    The last row has the seconds outside solved meshes: failed solves, reduced models, reading and writing.
    """
    if not answers:
        return None
    tried = [(answer, mesh) for _, _, answer in answers for mesh in answer["meshes"]]
    total, rows, solved_seconds = sum(answer["cpu_seconds"] for _, _, answer in answers), [], 0.0
    for name, rings in RINGS.items():
        found = [(answer, mesh) for answer, mesh in tried if mesh["mesh"] == name]
        answering = sum(answer["mesh"] == name for answer, _ in found)
        failed = sum(mesh["status"] == "no flow" for _, mesh in found)
        seconds = sum(mesh.get("cpu_seconds", 0.0) for _, mesh in found)
        solved_seconds += seconds
        line = [f"{len(found)}", f"{answering}", f"{failed}", f"{sum(mesh['factorizations'] for _, mesh in found)}"]
        rows.append([f"{rings}", *line, *share_of(seconds, total)])
    rows.append(["failed solves, files", *[""] * 4, *share_of(total - solved_seconds, total)])
    return markdown(MESH_COLUMNS, rows)


def reduced_models(answers):
    """Markdown: how far the FFR of the reduced models is from that in 3D, over the states; None if none was solved.

    The differences are those of largest size, where the model's own FFR is below LOW_FFR and where it is not. The last
    row has the largest range of the difference over the states after PCI of one patient.
    """
    differences = [
        (model, answer["models"][model]["ffr"], answer["models"][model]["ffr"] - answer["ffr"], case, state)
        for case, state, answer in answers
        for model in REDUCED_MODELS
        if answer["models"].get(model, {}).get("ffr") is not None
    ]
    if not differences:
        return None
    rows = []
    for words, is_low in ((f"the model's FFR is below {LOW_FFR:g}", True), ("it is not", False)):
        row = [words]
        for model in REDUCED_MODELS:
            found = [one for one in differences if one[0] == model and (one[1] < LOW_FFR) == is_low]
            worst = max(found, key=lambda one: abs(one[2]), default=None)
            row.append(f"{worst[2]:+.4f} ({worst[3]} {worst[4]})" if worst else "")
        rows.append(row)
    row = ["range within one patient after PCI"]
    for model in REDUCED_MODELS:
        by_case = {}
        for _, _, difference, case, _ in (one for one in differences if one[0] == model and one[4] != STATE_BEFORE):
            by_case.setdefault(case, []).append(difference)
        ranges = {case: max(found) - min(found) for case, found in by_case.items()}
        worst = max(ranges, key=ranges.get, default=None)
        row.append(f"{min(ranges.values()):.4f} to {ranges[worst]:.4f} ({worst})" if worst else "")
    return markdown(MODEL_COLUMNS, [*rows, row])


def share_of(seconds, total):
    """Cells with seconds and their share in percent of `total`."""
    return [f"{seconds:.0f}", f"{100 * seconds / total:.0f}"]

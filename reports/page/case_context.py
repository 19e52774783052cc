"""The report's content on one case, read from its files for the templates."""

import json

from reports.study.cohort import describe_device, describe_procedure
from reports.measuring.pressure_wire import wire_pair
from reports.inputs.case_files import states_in_3d
from reports.page.geometry import viewer_data
from reports.measuring.profiles import ffr_error_estimate
from reports.measuring.stent_edges import EDGE_SEGMENT_MM, RUPTURE_STRETCH
from reports.inputs.reading import read_json
from reports.whatif.page_context import planner_context

CURVES = (
    ("pullback", "FFR along the stented branch, from the inlet to the outlet, with the band of its estimated error"),
    ("area", "Cross-sectional area (CSA) of the lumen along the treated segment and its margins"),
    ("curvature", "Curvature of the centreline along the treated segment and its margins"),
)


# key of deployment.json, words, digits, unit
READOUTS = (
    ("minimal_stent_area_mm2", "Minimal stent area", 2, " mm²"),
    ("minimal_lumen_area_in_stent_mm2", "smallest lumen within the stent", 2, " mm²"),
    ("expansion_index", "expansion index", 2, ""),
    ("recoil_percent", "recoil", 1, " %"),
    ("foreshortening_percent", "foreshortening", 1, " %"),
    ("straightening_deg", "straightening", 1, "°"),
    ("maximal_malapposition_mm", "largest gap between stent and wall", 2, " mm"),
)


def case_context(files, figures_dir, folder):
    """The context of templates/case.html.j2. Copies the pictures into the ReportFolder `folder`.

    Raises InputError for a missing figure or file.
    """
    metrics = read_json(files.metrics, "reports metrics")
    flow = {state: flow_row(files, state) for state, entry in metrics["states"].items() if entry["ffr"] is not None}
    deployment = read_json(files.deployment, "vci deploy") if "vci" in metrics["states"] else None
    edges = metrics["deployment"]["stent_edges"] if metrics["deployment"] else []
    return {
        "name": files.case,
        "id": "case-" + files.case,
        "metrics": metrics,
        "steps": [
            {
                "action": step["action"].replace("_", " "),
                "brief": describe_procedure([step]),
                "devices": [
                    f"{describe_device(use)}, centre at {use['centre_s_mm']:.1f} mm of {use['branch']}"
                    for use in step["devices"]
                ],
            }
            for step in metrics["procedure"]
        ],
        "deployment": deployment,
        "stent_edges": edges,
        "readouts": [
            f"{words} {deployment[key]:.{digits}f}{unit}"
            for key, words, digits, unit in READOUTS
            if deployment and deployment.get(key) is not None
        ]
        + edge_readouts(edges),
        "deployment_warnings": (deployment or {}).get("warnings", []) + edge_warnings(edges),
        "switched_off": [as_text(item) for item in (deployment or {}).get("switched_off", [])],
        "flow": flow,
        "probes": probe_rows(flow),
        "flow_ranges": flow_ranges(flow),
        "flow_warnings": flow_warnings(flow),
        "modified": [state for state, row in flow.items() if not _steady(row["solution"])],
        "reference": optional_json(files.folder / "reference" / "reference.json"),
        "still": folder.picture(figures_dir / f"{files.case}_lumen.png"),
        "procedure_picture": folder.optional_picture(figures_dir / f"{files.case}_procedure.png"),
        "ct_picture": folder.optional_picture(figures_dir / f"{files.case}_ct.png"),
        "sensitivity_picture": folder.optional_picture(figures_dir / f"{files.case}_sensitivity.svg"),
        **planner_context(files.folder),
        "stations_picture": folder.picture(figures_dir / f"{files.case}_stations.png"),
        "plan_picture": folder.optional_picture(files.folder / "vci" / "plan.png", f"{files.case}_plan"),
        "curves": [
            {"name": name, "picture": folder.picture(figures_dir / f"{files.case}_{name}.svg"), "alt": text}
            for name, text in CURVES
        ],
        "wire": wire_rows(metrics),
        "viewer": viewer_data(files, metrics),
        "pictured": states_in_3d(metrics["states"]),
    }


def edge_readouts(edges):
    """The wall's stretch at both edges of each stent, in words. edges: `stent_edges` of metrics.json."""
    by_stent = {}
    for row in edges:
        by_stent.setdefault(row["stent"], []).append(f"{row['largest_stretch']:.2f} {row['end']}")
    before = f"largest wall stretch within {EDGE_SEGMENT_MM:g} mm of the edges of stent"
    return [f"{before} {stent}: {', '.join(ends)}" for stent, ends in by_stent.items()]


def edge_warnings(edges):
    """Hints of dissection at the edges where the wall is stretched beyond the limit, as sentences."""
    return [
        f"stent {row['stent']}, {row['end']} edge in {row['branch']}: next to it the wall is stretched to "
        f"{row['largest_stretch']:.2f} times its length. Strips of human artery tear at {RUPTURE_STRETCH:g} on average "
        "(Teng et al., J Biomech 2009;42:2535–2539). This hints at an edge dissection"
        for row in edges
        if row["beyond_limit"]
    ]


def flow_ranges(flow):
    """Rows {state, ffr, low, high, at}: the range of FFR over plausible flows, for the states that have one."""
    return [
        {"state": state, "ffr": row["solution"]["ffr"], **row["solution"]["ffr_range"]}
        for state, row in flow.items()
        if row["solution"].get("ffr_range")
    ]


def probe_rows(flow):
    """Rows {name, branch, s_mm, ffr: {state: FFR}} of the probes, in the order of the first state that has them."""
    rows = {}
    for state, row in flow.items():
        for probe in row["solution"].get("probes", []):
            place = {key: probe[key] for key in ("name", "branch", "s_mm")}
            rows.setdefault(probe["name"], {**place, "ffr": {}})["ffr"][state] = probe["ffr"]
    return list(rows.values())


def wire_rows(metrics):
    """Rows {state, computed, measured} of FFR at the pressure wire's sensor, for the states that have both."""
    pairs = {state: wire_pair(metrics, state) for state in metrics["states"]}
    return [{"state": state, "computed": pair[0], "measured": pair[1]} for state, pair in pairs.items() if pair]


def flow_warnings(flow):
    """Warnings of the flow solver as rows {state, message}, in the order of the states."""
    return [
        {"state": state, "message": message.rstrip(".")}
        for state, row in flow.items()
        for message in row["solution"].get("warnings", [])
    ]


def _steady(solution):
    """Whether ffr.json comes from a steady flow without artificial viscosity."""
    return not solution.get("artificial_viscosity") and solution.get("status") == "converged"


def flow_row(files, state):
    """{solution, error, reduced_ffr, reduced_model} of a state: ffr.json, its estimated error and the reduced model."""
    solution = read_json(files.flow(state) / "ffr.json", "flow solve")
    reduced = solution.get("reduced_model") or {}
    return {
        "solution": solution,
        "error": ffr_error_estimate(solution),
        "reduced_ffr": reduced.get("ffr"),
        "reduced_model": reduced.get("model"),
    }


def optional_json(path):
    """The JSON object in `path`, None if there is no such file."""
    return read_json(path, "the study") if path.exists() else None


def as_text(value):
    """A value from a JSON file as text, whatever its type."""
    return value if isinstance(value, str) else json.dumps(value)

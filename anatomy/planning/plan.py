"""Completes the devices of a case's plan and writes plan.json, which is scene.json without wall and numerics."""

import os
import sys

from common.patient.blood_pressure import mean_arterial_pressure_mmhg
from common.documents import config
from common.errors import InputError
from common.files import write_json

from ..lumen_results import branch_named, lesion_numbered, read_sections, read_summary
from . import catalogue, outer_wall, proposal, remarks

PASCAL_PER_MMHG = 133.322387415
OUTER_WALL, HEALTHY_PROFILE = "outer wall", "healthy profile"  # sources of the vessel's healthy size


def run(case_file, anatomy_folder, devices_folder, out):
    """Writes plan.json to the path `out`. Raises InputError for a plan that the catalogue or the lumen does not allow.

    anatomy_folder: output of `lumen process`. devices_folder: folder of the device families (config/devices).
    """
    case = config.load_case(case_file)
    families = config.load_devices(devices_folder)
    summary = read_summary(anatomy_folder)
    steps, request, reference = case["plan"], proposal.requested_treatment(case["plan"]), {}
    if request:
        sections = read_sections(anatomy_folder)
        if outer_wall.has_traced_wall(case):
            sections = outer_wall.with_lumen_and_plaque_reference(sections, anatomy_folder / "lumen.vtp")
        proposed = proposal.propose(summary, sections, families, str(case_file), *request)
        steps = proposed.steps
        sentences = list(remarks.of_proposal(summary, proposed))
        reference = {
            "reference": reference_document(proposed, outer_wall.has_traced_wall(case)) | {"remarks": sentences}
        }
        for sentence in sentences:
            print(f"warning: {case_file}: plan: {sentence}", file=sys.stderr)
        for other in remarks.of_reference(reference["reference"]):
            print(f"{case_file}: plan: {other}", file=sys.stderr)
    listed = procedure(steps, families, summary, str(case_file))
    if not request:
        for sentence in remarks.of_device_sizes(listed, read_sections(anatomy_folder)):
            print(f"warning: {case_file}: plan: {sentence}", file=sys.stderr)
    relative = os.path.relpath(anatomy_folder.resolve(), out.resolve().parent)
    document = {
        "schema": "vci-scene-1",
        "case": case_file.stem,
        "lumen": f"{relative}/lumen.vtp",
        "centreline": f"{relative}/centreline.vtp",
        "patient": {"map_pa": mean_arterial_pressure_pa(case["patient"])},
        **reference,
        **listed,
    }
    write_json(out, document)


def reference_document(proposed, by_outer_wall):
    """The plan's `reference` as a dict: the source of the vessel's healthy size, and the lesions measured by it.

    anatomy_percent is the stenosis of the same lesion in anatomy.json, where the healthy profile through the lumen is
    the reference. proposed: the Proposal. by_outer_wall: whether the size comes from the traced outer wall.
    """
    lesions = [
        {
            "name": lesion["name"],
            "branch": lesion["branch"],
            "diameter_stenosis_percent": float(one.target.profile.stenosis_at(lesion["s_mla_mm"])),
            "anatomy_percent": lesion["diameter_stenosis_percent"],
        }
        for one in proposed.treatments
        for lesion in one.target.lesions
    ]
    return {"by": OUTER_WALL if by_outer_wall else HEALTHY_PROFILE, "lesions": lesions}


def mean_arterial_pressure_pa(patient):
    """Mean arterial pressure in Pa, to 0.001. patient: dict with sbp_mmhg, dbp_mmhg.

    Raises InputError if the diastolic pressure is not below the systolic one.
    """
    return round(mean_arterial_pressure_mmhg(patient["sbp_mmhg"], patient["dbp_mmhg"]) * PASCAL_PER_MMHG, 3)


def procedure(steps, families, summary, where):
    """{segment, devices, procedure} of plan.json for a plan's steps in a measured lumen.

    steps: the steps as a case file lists them. families: {name: document} of config/devices. summary: document of
    anatomy.json. where: the case file, for messages. Raises InputError if a device or pressure does not fit.
    """
    devices, resolved, stents, action_counts = {}, [], [], {}
    for i, step in enumerate(steps):
        placed = []
        for j, request in enumerate(step["devices"]):
            at = f"{where}: plan[{i + 1}].devices[{j + 1}]"
            sized = catalogue.device_entries(
                families, request["device"], request["diameter_mm"], request["length_mm"], at
            )
            _check_device_kind(step["action"], families[request["device"]]["kind"], at)
            device = _placed_device(request, summary, at)
            _check_pressure(request, sized, families, at)
            _check_overexpansion(device, request, sized, families, stents, at)
            devices.update(sized)
            placed.append(device)
            if families[request["device"]]["kind"] == "stent":
                stents.append((device, sized[device["device"]]))
        action_counts[step["action"]] = action_counts.get(step["action"], 0) + 1
        number = f"_{action_counts[step['action']]}" if action_counts[step["action"]] > 1 else ""
        resolved.append({"name": step["action"] + number, "action": step["action"], "devices": placed})
    return {"segment": _treated_segment(resolved, devices, stents), "devices": devices, "procedure": resolved}


def _check_device_kind(action, kind, where):
    if (action == "stent") != (kind == "stent"):
        raise InputError(
            "device of the wrong kind for the step",
            where,
            f"{kind} in {action}",
            "stents in the action stent, balloons in any other",
        )


def _placed_device(request, summary, where):
    """Entry of plan.json for a requested device, placed by lesion or by branch and centre_s_mm. Raises InputError."""
    lesion = lesion_numbered(summary, request["lesion"], where) if "lesion" in request else None
    name = request.get("branch", lesion["branch"] if lesion else "main")
    if lesion and lesion["branch"] != name:
        raise InputError(
            "the lesion lies in another branch",
            where,
            f"lesion {request['lesion']} in {lesion['branch']}, branch: {name}",
            "leave branch out, or place the device by centre_s_mm",
        )
    branch = branch_named(summary, name, where)
    centre = round(0.5 * (lesion["s_start_mm"] + lesion["s_end_mm"]), 3) if lesion else request["centre_s_mm"]
    half = request["length_mm"] / 2
    # A side branch's axis continues through its parent to the inlet, at negative arc lengths. A device may start there
    # (culotte, kissing balloons).
    before = branch.get("s_on_parent_mm") or 0
    if centre - half < -before or centre + half > branch["length_mm"]:
        raise InputError(
            "the device reaches beyond its branch",
            where,
            f"{centre - half:.1f} to {centre + half:.1f} mm on {name}, which has {-before:.1f} to"
            f" {branch['length_mm']:.1f} mm",
            "move it (centre_s_mm) or choose a shorter one (length_mm)",
        )
    return {
        "device": catalogue.device_key(request["device"], request["diameter_mm"], request["length_mm"]),
        "branch": name,
        "centre_s_mm": centre,
        "pressure_bar": request["pressure_bar"],
    }


def _inflating_balloon(request, sized, families):
    family = config.balloon_family(families, request["device"])
    return sized[catalogue.device_key(family, request["diameter_mm"], request["length_mm"])]


def _check_pressure(request, sized, families, where):
    rated = _inflating_balloon(request, sized, families)["rated_burst_pressure_bar"]
    if request["pressure_bar"] > rated:
        raise InputError(
            "pressure above the balloon's rated burst pressure",
            where,
            f"{request['pressure_bar']} bar",
            f"pressure_bar of at most {rated}, or a larger balloon",
        )


def _check_overexpansion(device, request, sized, families, stents, where):
    """Raises InputError if a stent would be opened beyond its design.

    The balloon of a step opens the stent that it carries, or otherwise the earlier stents that it overlaps. stents:
    [(placed device, entry)] of the stents so far.
    """
    diameter = catalogue.diameter_at(_inflating_balloon(request, sized, families), request["pressure_bar"])
    if families[request["device"]]["kind"] == "stent":
        targets = [sized[device["device"]]]
    else:
        targets = [
            stent for placed, stent in stents if _overlap(device, request["length_mm"], placed, stent["length_mm"])
        ]
    for stent in targets:
        if diameter > stent["maximal_diameter_mm"]:
            raise InputError(
                "the balloon would over-expand the stent",
                where,
                f"{diameter:.2f} mm at {request['pressure_bar']} bar; the stent of {stent['nominal_diameter_mm']} mm"
                f" opens to {stent['maximal_diameter_mm']} mm",
                "lower pressure_bar, or choose a smaller balloon or a stent of a larger design",
            )


def _overlap(a, length_a, b, length_b):
    return a["branch"] == b["branch"] and abs(a["centre_s_mm"] - b["centre_s_mm"]) < (length_a + length_b) / 2


def _treated_segment(steps, devices, stents):
    """The treated segment: the branch of the first stent, and the extent (mm) of all stents on this branch.

    In a plan without stents the balloons count instead. A part that protrudes into the parent is left out, since the
    branch has no sections there.
    """
    placed = [device for device, _ in stents] or [device for step in steps for device in step["devices"]]
    branch = placed[0]["branch"]
    spans = [
        (
            d["centre_s_mm"] - devices[d["device"]]["length_mm"] / 2,
            d["centre_s_mm"] + devices[d["device"]]["length_mm"] / 2,
        )
        for d in placed
        if d["branch"] == branch
    ]
    return {
        "branch": branch,
        "s_start_mm": round(max(0.0, min(start for start, _ in spans)), 3),
        "s_end_mm": round(max(end for _, end in spans), 3),
    }

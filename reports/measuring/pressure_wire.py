"""FFR measured in the patient by a pressure wire, and the computed FFR at the wire's sensor."""

from common.errors import InputError
from common.patient.states import MEASURED
from reports.inputs.reading import read_json

FFR_THRESHOLD = 0.80  # at or below it a lesion is treated (ESC/EACTS guidelines on myocardial revascularisation)


def wire_summary(files, case):
    """{ffr_pre, ffr_post, branch, s_mm} of the wire, from boundary.json and `case` (content of its file).

    An FFR that was not measured is None. The result is None without a wire. Raises InputError if boundary.json lacks
    the wire's probe.
    """
    given = case.get("measured") if case else None
    if given is None:
        return None
    probes = {probe["name"]: probe for probe in read_json(files.boundary, "flow boundary").get("probes", [])}
    if MEASURED not in probes:
        raise InputError("no probe at the wire's sensor", files.boundary, sorted(probes), "repeat: flow boundary")
    place = {key: probes[MEASURED][key] for key in ("branch", "s_mm")}
    return {"ffr_pre": given.get("ffr_pre"), "ffr_post": given.get("ffr_post"), **place}


def ffr_at_wire(solution):
    """FFR of a solution (content of ffr.json) at the wire's sensor. None if it has no probe there."""
    return next((float(probe["ffr"]) for probe in solution.get("probes", []) if probe["name"] == MEASURED), None)


def wire_pair(document, state):
    """(computed, measured) FFR of a state at the wire's sensor; None if either is missing. document: metrics.json.

    The wire's FFR after the procedure is compared with every state after it.
    """
    measured, entry = document.get("measured"), document["states"].get(state)
    if measured is None or entry is None or entry["ffr"] is None:
        return None
    computed, reading = entry["ffr"]["at_wire"], measured["ffr_pre" if state == "pre" else "ffr_post"]
    return None if computed is None or reading is None else (computed, reading)


def same_decision_share(first, second):
    """Share (0 to 1) of cases in which both FFRs (n,) lead to the same decision: treat (<= FFR_THRESHOLD) or not."""
    same = [(a <= FFR_THRESHOLD) == (b <= FFR_THRESHOLD) for a, b in zip(first, second)]
    return sum(same) / len(same)

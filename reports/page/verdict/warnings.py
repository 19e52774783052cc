"""Warnings that put a patient's result in doubt."""

from common.patient.states import TRUE_STATES
from reports.figures.style import SHORT_LABELS
from reports.measuring.device_readouts import LARGEST_MALAPPOSITION_MM, LEAST_EXPANSION
from reports.measuring.stent_edges import RUPTURE_STRETCH
from reports.page.verdict.words import ffr_computed, significant
from reports.selection.patients import LOW_FFR_AFTER

FOLDED_WALL = "the wall is folded: "  # how this warning of the engine begins (vci/results/readouts.cpp)
MOST_NAMED = 5  # cases that a warning names; the others are counted
MOST_STATES = 2  # states of a case that a warning names; if there are more, all are counted


def warning_groups(contexts):
    """[{what, cases, more}]: what puts a result in doubt, in which cases. Empty if nothing does.

    cases: {name, id, detail} of the first MOST_NAMED; more: number of the others.
    """
    kinds = {
        "FFR not known to be within the flow's tolerance": tolerance_detail,
        "flow with artificial viscosity": viscosity_detail,
        "wall folded by the deployment": folded_detail,
        f"expansion index below {LEAST_EXPANSION:g}": expansion_detail,
        f"malapposition beyond {LARGEST_MALAPPOSITION_MM:g} mm": malapposition_detail,
        f"wall stretched beyond {RUPTURE_STRETCH:g} at a stent's edge": edge_detail,
        f"FFR after PCI below {LOW_FFR_AFTER:.2f}": low_ffr_detail,
    }
    groups = []
    for what, detail in kinds.items():
        cases = [{"name": one["name"], "id": one["id"], "detail": detail(one)} for one in contexts]
        cases = [case for case in cases if case["detail"]]
        if cases:
            groups.append({"what": what, "cases": cases[:MOST_NAMED], "more": len(cases[MOST_NAMED:])})
    return groups


def no_warning_text():
    """A sentence that lists what was looked for, for a study without any warning of `warning_groups`."""
    return (
        "None: each FFR is within the flow's tolerance, no wall is folded, no expansion index is below"
        f" {LEAST_EXPANSION:g}, no malapposition beyond {LARGEST_MALAPPOSITION_MM:g} mm, no wall stretched beyond"
        f" {RUPTURE_STRETCH:g} at a stent's edge, no FFR after PCI below {LOW_FFR_AFTER:.2f}."
    )


def tolerance_detail(context):
    """The states of a case whose FFR is not known to be within the tolerance, with its error; empty if none is.

    More than MOST_STATES are counted, with the largest error that is known.
    """
    errors = {state: row["error"] for state, row in context["flow"].items() if not row["solution"].get("tolerance_met")}
    if len(errors) > MOST_STATES:
        known = [error for error in errors.values() if error is not None]
        largest = f"at most ± {significant(max(known))}" if known else "error unknown"
        return f"{len(errors)} states, {largest}{' where known' if known and len(known) < len(errors) else ''}"
    texts = {state: "unknown" if error is None else significant(error) for state, error in errors.items()}
    return ", ".join(f"{SHORT_LABELS[state]} ± {text}" for state, text in texts.items())


def viscosity_detail(context):
    """The states of a case whose flow keeps artificial viscosity; more than MOST_STATES are counted."""
    states = context["modified"]
    return f"{len(states)} states" if len(states) > MOST_STATES else ", ".join(SHORT_LABELS[one] for one in states)


def folded_detail(context):
    """What the engine says of a wall whose triangles cross: "7 pairs of its triangles cross"; empty if none do."""
    warnings = (context["deployment"] or {}).get("warnings", [])
    found = next((text for text in warnings if text.startswith(FOLDED_WALL)), "")
    return found.removeprefix(FOLDED_WALL).partition(",")[0]


def expansion_detail(context):
    """The smallest expansion index of a case's stents as text; empty if it is large enough or not known."""
    found = [one["expansion_index"] for one in (context["deployment"] or {}).get("stents", [])]
    least = min([index for index in found if index is not None], default=LEAST_EXPANSION)
    return f"{least:.2f}" if least < LEAST_EXPANSION else ""


def malapposition_detail(context):
    """The largest gap between stent and wall of a case as text; empty if it is small or not known."""
    gap = (context["deployment"] or {}).get("maximal_malapposition_mm") or 0.0
    return f"{gap:.2f} mm" if gap > LARGEST_MALAPPOSITION_MM else ""


def edge_detail(context):
    """The largest stretch of the wall at an edge of a case's stents, if it is beyond the limit; else empty."""
    beyond = [row["largest_stretch"] for row in context["stent_edges"] if row["beyond_limit"]]
    return f"{max(beyond):.2f}" if beyond else ""


def low_ffr_detail(context):
    """FFR after PCI of a case, predicted and known, if one of them is low; else empty. Equal values are given once."""
    found = {state: ffr_computed(context["metrics"], state) for state in ("vci", *TRUE_STATES)}
    known = {state: ffr for state, ffr in found.items() if ffr is not None}
    if min(known.values(), default=LOW_FFR_AFTER) >= LOW_FFR_AFTER:
        return ""
    texts = {state: f"{ffr:.2f}" for state, ffr in known.items()}
    if len(set(texts.values())) == 1:
        return next(iter(texts.values()))
    return ", ".join(f"{SHORT_LABELS[state]} {text}" for state, text in texts.items())

"""What a reader of a proposed plan should know: what it leaves out, and where it could not follow its own rules."""

from . import sizing

WIDE_BRANCH_MM = 2.0  # diameter from which a side branch under a stent is usually looked after
TOLERANCE_MM = 0.05


def of_proposal(summary, steps):
    """Sentences on proposed steps (sizing.propose) for the lumen of `summary`; none where nothing is to be said."""
    lesion = sizing.target(summary)
    stent = next(step["devices"][0] for step in steps if step["action"] == "stent")
    half = stent["length_mm"] / 2
    ends = (stent["centre_s_mm"] - half, stent["centre_s_mm"] + half)
    return [
        *_severity(summary, lesion),
        *_margins(lesion, ends),
        *_landing(summary, lesion, ends),
        *_covered(summary, lesion, ends),
    ]


def _severity(summary, lesion):
    percent = lesion["diameter_stenosis_percent"]
    if percent < sizing.SIGNIFICANT_PERCENT:
        yield (
            f"{lesion['name']} narrows the diameter by {percent:.0f} % only: below {sizing.SIGNIFICANT_PERCENT} % a"
            " stent is rarely indicated, look at the FFR first"
        )
    for other in summary["lesions"]:
        treated = other["name"] in lesion["name"].split(sizing.AND)
        if other["diameter_stenosis_percent"] >= sizing.SIGNIFICANT_PERCENT and not treated:
            yield (
                f"{other['name']} ({other['diameter_stenosis_percent']:.0f} % on {other['branch']} at"
                f" {other['s_mla_mm']:.1f} mm) is left as it is: the plan treats {lesion['name']} alone"
            )


def _margins(lesion, ends):
    for side, margin in (("proximal", lesion["s_start_mm"] - ends[0]), ("distal", ends[1] - lesion["s_end_mm"])):
        if margin < sizing.MARGIN_MM - TOLERANCE_MM:
            yield (
                f"the stent reaches {margin:.1f} mm past {lesion['name']} at its {side} end, {sizing.MARGIN_MM} mm are"
                " wanted"
            )


def _landing(summary, lesion, ends):
    for name, (low, high) in sizing.mouths(summary, lesion["branch"]).items():
        if any(low < end < high for end in ends):
            yield f"the stent ends in the mouth of {name} ({low:.1f} to {high:.1f} mm), which no length avoids"
    for low, high in sizing.other_lesions(summary, lesion):
        if any(low < end < high for end in ends):
            yield f"the stent ends in the narrowing from {low:.1f} to {high:.1f} mm, not in healthy wall"


def _covered(summary, lesion, ends):
    for name, (low, high) in sizing.mouths(summary, lesion["branch"]).items():
        if high - low >= WIDE_BRANCH_MM and ends[0] < (low + high) / 2 < ends[1]:
            yield f"the stent lies across {name} ({high - low:.1f} mm wide): consider opening it towards that branch"

"""The hyperaemic flow into the tree: by the published mass law, by the territory that the tree feeds, or measured.

`territory: whole` (the default, used for the study's patients): Q = 0.71 M^0.75 / 0.16 mL/min, M being the left
ventricular mass in g. All of this flow enters the tree, as the method was published. That is 190 mL/min for 150 g.

A named territory gets its share of the whole heart's flow. The shares are those of the left ventricle's 17 segments
(Cerqueira et al., Circulation 2002;105:539-42): LAD 7, LCX 5, RCA 5. The whole heart's flow is FLOW_PER_GRAM times the
mass (N-13 ammonia at dipyridamole hyperaemia, 3.69 +- 0.83 mL/min/g: Kiso et al., J Radiol Radiat Ther, nine
volunteers). For 150 g that is 228 mL/min in the LAD and 554 in all; continuous thermodilution measured 228 +- 71 in
LADs and 582 +- 138 in whole hearts with mild atherosclerosis (Fournier et al., EuroIntervention 2021;17:e309-16). The
published law gives a third of the whole heart's flow. So its flow is taken as that of one artery, and not divided among
several.

With a cardiac output instead of a mass, the heart's flow at rest is REST_SHARE of the output (225 of 5,000 mL/min,
Guyton and Hall, Textbook of Medical Physiology). Hyperaemia multiplies it by FLOW_RESERVE (2.78 by thermodilution:
Gallinoro et al., EuroIntervention 2021).
"""

import math

from common.documents import schema
from common.errors import InputError
from flow.physics.units import M3_PER_S_PER_ML_PER_MIN

WHOLE_FLOW = "whole"
TERRITORY_SEGMENTS = {
    "lad": 7,
    "lcx": 5,
    "rca": 5,
    "left": 12,
}  # segments of the left ventricle that each territory feeds
ALL_SEGMENTS = 17
FLOW_PER_GRAM, FLOW_PER_GRAM_SD = 3.69, 0.83  # mL/min per g: hyperaemic flow of the heart, mean and standard deviation
# Coronary flow at rest over cardiac output; hyperaemic flow over flow at rest.
REST_SHARE, FLOW_RESERVE = 0.045, 2.78
# mL/min: hyperaemic flow of the whole heart, mean and standard deviation (Fournier et al.). A measured inflow more than
# two standard deviations above the mean gets a warning.
HEART_ML_PER_MIN, HEART_SD_ML_PER_MIN = 582, 138
MASS_ERROR = 0.2  # relative error of a mass that was measured by another method, or assumed
MASS_EXPONENT = 0.75  # exponent of the mass in the published law


def flow_of_mass(lvm_g, hyperaemia_fraction):
    """Flow in m3/s by the published law, 0.71 M^0.75 / hyperaemia_fraction mL/min, M = lvm_g in g."""
    if not 30 <= lvm_g <= 500:
        raise InputError("implausible left ventricular mass", "patient lvm_g", lvm_g, "give grams, 30 to 500")
    return 0.71 * lvm_g**MASS_EXPONENT / hyperaemia_fraction * M3_PER_S_PER_ML_PER_MIN


def territory_share(territory):
    """Share of the whole heart's flow that a territory gets. territory: its name, or the share itself."""
    return TERRITORY_SEGMENTS[territory] / ALL_SEGMENTS if territory in TERRITORY_SEGMENTS else float(territory)


def flow_of_heart(patient):
    """The whole heart's hyperaemic flow in m3/s, by cardiac output if it is given, or else by mass."""
    output = patient.get("cardiac_output_l_per_min")
    if output is not None:
        return 1000 * output * REST_SHARE * FLOW_RESERVE * M3_PER_S_PER_ML_PER_MIN
    return FLOW_PER_GRAM * patient["lvm_g"] * M3_PER_S_PER_ML_PER_MIN


def flow_source(patient, hyperaemia_fraction):
    """{flow_m3_per_s, territory, share, by}: the flow into the tree and how it was found.

    patient: section `patient` of a case file; hyperaemia_fraction: constant of the published law. share: share of the
    whole heart's flow, None for the published law and a measured inflow; by: how the flow was found, in words. Raises
    InputError.
    """
    territory = patient.get("territory", WHOLE_FLOW)
    given = patient.get("hyperaemic_inflow_ml_per_min")
    if given is not None:
        return _source_entry(given * M3_PER_S_PER_ML_PER_MIN, territory, None, "measured inflow")
    if patient.get("lvm_g") is None and patient.get("cardiac_output_l_per_min") is None:
        raise InputError("nothing to tell the flow by", "patient", "no lvm_g", "give lvm_g, or a flow")
    if territory == WHOLE_FLOW:
        if patient.get("lvm_g") is None:
            remedy = "give patient.territory: left, lad, lcx, rca or a share of the heart's flow"
            raise InputError("a cardiac output is shared out by territory", "patient.territory", territory, remedy)
        flow = flow_of_mass(patient["lvm_g"], hyperaemia_fraction)
        law = f"0.71 M^0.75 / {hyperaemia_fraction:g} mL/min, all of it into this tree"
        return _source_entry(flow, territory, None, law)
    return _source_entry(
        territory_share(territory) * flow_of_heart(patient), territory, territory_share(territory), _flow_basis(patient)
    )


def _flow_basis(patient):
    """Words for what the whole heart's flow is computed from."""
    return "cardiac output" if patient.get("cardiac_output_l_per_min") is not None else f"{FLOW_PER_GRAM} mL/min/g"


def flow_warnings(patient, hyperaemia_fraction=None):
    """[warning] on a measured inflow above the usual range of its territory, and on values that are not used."""
    return (
        _high_inflow_warnings(patient)
        + _unused_value_warnings(patient)
        + _unused_fraction_warnings(patient, hyperaemia_fraction)
    )


def _unused_value_warnings(patient):
    """[warning] on values that are not used. The flow follows from an inflow, else a cardiac output, else a mass."""
    order = ("hyperaemic_inflow_ml_per_min", "cardiac_output_l_per_min", "lvm_g")
    used, *others = [key for key in order if patient.get(key) is not None] or [None]
    if not others:
        return []
    names = " and ".join(f"patient.{key}" for key in others)
    return [f"{names}: not used, since patient.{used}, {patient[used]:g}, tells the flow; leave one out"]


def _unused_fraction_warnings(patient, hyperaemia_fraction):
    """[warning] on a hyperaemia_fraction other than the default where the published law is not used."""
    default = schema.read("flow")["properties"]["hyperaemia_fraction"]["default"]
    inflow, territory = patient.get("hyperaemic_inflow_ml_per_min"), patient.get("territory", WHOLE_FLOW)
    if hyperaemia_fraction in (None, default) or (inflow is None and territory == WHOLE_FLOW):
        return []
    if inflow is not None:
        basis = f"patient.hyperaemic_inflow_ml_per_min, {inflow:g},"
    else:
        basis = f"patient.territory, {territory}, with {_flow_basis(patient)}"
    return [
        f"settings.flow.hyperaemia_fraction is {hyperaemia_fraction:g}: not used, since {basis} tells the flow;"
        " it acts in the published law alone (territory: whole)"
    ]


def _high_inflow_warnings(patient):
    """[warning] on a measured inflow more than two standard deviations above the mean of its territory."""
    given, territory = patient.get("hyperaemic_inflow_ml_per_min"), patient.get("territory", WHOLE_FLOW)
    most = (HEART_ML_PER_MIN + 2 * HEART_SD_ML_PER_MIN) * (
        1.0 if territory == WHOLE_FLOW else territory_share(territory)
    )
    if given is None or given <= most:
        return []
    whose = "a whole heart" if territory == WHOLE_FLOW else f"the territory {territory}"
    return [
        f"patient.hyperaemic_inflow_ml_per_min is {given:g} mL/min; of {whose} two standard deviations above the mean"
        f" are {most:.0f} mL/min (Fournier et al., EuroIntervention 2021): check value and units"
    ]


def _source_entry(flow, territory, share, by):
    """The dictionary that `flow_source` returns; flow in m3/s; share: share of the whole heart's flow."""
    return {"flow_m3_per_s": flow, "territory": territory, "share": share, "by": by}


def _shares_off_by_one(share):
    """(share with one of the 17 segments less, share with one more) for a `share` of the heart's flow.

    The smaller share is at least half a segment, or half of `share` where `share` is less than a segment.
    """
    segment = 1 / ALL_SEGMENTS
    return max(share - segment, 0.5 * min(share, segment)), share + segment


def plausible_flows(patient, hyperaemia_fraction):
    """[{what, factor}]: plausible flows over the estimated flow, with one cause varied at a time.

    The mass varies by MASS_ERROR, hyperaemia by the standard deviation between people, a named territory by one of the
    left ventricle's 17 segments. If no territory is named, each one is tried. For a measured inflow the list is empty;
    see reduced.flow_range.plausible_around_inflow.
    """
    if patient.get("hyperaemic_inflow_ml_per_min") is not None:
        return []
    base = flow_source(patient, hyperaemia_fraction)
    found = []
    if patient.get("cardiac_output_l_per_min") is None:
        power = MASS_EXPONENT if base["share"] is None else 1.0
        found += [(f"mass {sign}20 %", (1 + error) ** power) for sign, error in (("-", -MASS_ERROR), ("+", MASS_ERROR))]
    spread = FLOW_PER_GRAM_SD / FLOW_PER_GRAM
    found += [("hyperaemia -1 SD", 1 - spread), ("hyperaemia +1 SD", 1 + spread)]
    if base["share"] is None:
        heart = flow_of_heart(patient)
        found += [
            (f"territory {name}", territory_share(name) * heart / base["flow_m3_per_s"]) for name in TERRITORY_SEGMENTS
        ]
    else:
        found += [
            (f"territory {sign}1 of 17 segments", share / base["share"])
            for sign, share in zip("-+", _shares_off_by_one(base["share"]))
        ]
    return [{"what": what, "factor": factor} for what, factor in found if math.isfinite(factor)]

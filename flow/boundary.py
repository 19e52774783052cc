"""Boundary values of a patient's coronary flow at hyperaemia.

    Q_rest = 0.71 M^0.75  mL/min (M: left ventricular mass in g),   Q_hyp = Q_rest / 0.16
    Q_i / Q_hyp = D_i^2.55 / sum_j D_j^2.55
    MAP = DBP + 0.4 (SBP - DBP)
    R_i = (MAP - P_v) / Q_i

The diameters are those of the outlets before the intervention; one set of resistances serves all states of a patient.
"""

import math

from common.errors import InputError
from flow import viscosity

PA_PER_MMHG = 133.322
M3_PER_S_PER_ML_PER_MIN = 1e-6 / 60.0


def mean_arterial_pressure_mmhg(sbp_mmhg, dbp_mmhg):
    """MAP in mmHg. Raises InputError when the pressures are out of order."""
    if not 0 < dbp_mmhg < sbp_mmhg:
        raise InputError(
            "blood pressures out of order",
            "patient sbp_mmhg, dbp_mmhg",
            f"{sbp_mmhg}, {dbp_mmhg}",
            "give 0 < diastolic < systolic in mmHg",
        )
    return dbp_mmhg + 0.4 * (sbp_mmhg - dbp_mmhg)


def hyperaemic_flow_m3_per_s(lvm_g, hyperaemia_fraction):
    """Q_hyp of the whole coronary tree from the left ventricular mass in g."""
    if not 30 <= lvm_g <= 500:
        raise InputError("implausible left ventricular mass", "patient lvm_g", lvm_g, "give grams, 30 to 500")
    return 0.71 * lvm_g**0.75 / hyperaemia_fraction * M3_PER_S_PER_ML_PER_MIN


def split_by_diameter(diameters_mm, exponent):
    """Fractions of the flow, one an outlet, that sum to one: D_i^exponent / sum_j D_j^exponent."""
    for diameter in diameters_mm:
        if not 0.2 <= diameter <= 12:
            raise InputError("implausible outlet diameter", "anatomy.json ends", diameter, "give mm, 0.2 to 12")
    weights = [diameter**exponent for diameter in diameters_mm]
    total = math.fsum(weights)
    return [weight / total for weight in weights]


def _ends(anatomy):
    ends = anatomy.get("ends") if isinstance(anatomy, dict) else None
    keys = {"kind", "name", "region_id", "branch", "diameter_mm"}
    if not ends or not all(isinstance(end, dict) and keys <= set(end) for end in ends):
        remedy = f"give the anatomy step's document: ends with {', '.join(sorted(keys))}"
        raise InputError("not a document of the anatomy step", "anatomy.json ends", ends, remedy)
    return ends


def make(anatomy, centreline, patient, settings):
    """The document of boundary.json.

    anatomy: document of anatomy.json; centreline: flow.centreline.Tree; patient: lvm_g, sbp_mmhg, dbp_mmhg.
    """
    map_pa = mean_arterial_pressure_mmhg(patient["sbp_mmhg"], patient["dbp_mmhg"]) * PA_PER_MMHG
    venous_pa = settings.venous_pressure_mmhg * PA_PER_MMHG
    if venous_pa >= map_pa:
        raise InputError(
            "venous pressure is not below MAP", "venous_pressure_mmhg", settings.venous_pressure_mmhg, "usually 5 mmHg"
        )
    q_hyp = hyperaemic_flow_m3_per_s(patient["lvm_g"], settings.hyperaemia_fraction)
    ends = [end for end in _ends(anatomy) if end["kind"] == "outlet"]
    if not ends:
        raise InputError("no outlet", "anatomy.json ends", "[]", "process the lumen surface again")
    fractions = split_by_diameter([end["diameter_mm"] for end in ends], settings.split_exponent)
    outlets = [
        {
            "name": end["name"],
            "region_id": end["region_id"],
            "branch": end["branch"],
            "diameter_mm": end["diameter_mm"],
            "flow_fraction": fraction,
            "flow_m3_per_s": fraction * q_hyp,
            "resistance_pa_s_per_m3": (map_pa - venous_pa) / (fraction * q_hyp),
        }
        for end, fraction in zip(ends, fractions)
    ]
    if settings.outlet_condition == "pressure":
        for outlet in outlets:
            pressure = settings.outlet_pressure_mmhg * PA_PER_MMHG
            outlet.update(resistance_pa_s_per_m3=0.0, pressure_pa=pressure)
    given = settings.inlet_flow_ml_per_min * M3_PER_S_PER_ML_PER_MIN
    return {
        "schema": "vci-boundary-1",
        "inlet_flow_m3_per_s": given if settings.inlet_condition == "flow" else None,
        "map_pa": map_pa,
        "venous_pressure_pa": venous_pa,
        "density_kg_per_m3": settings.density_kg_per_m3,
        "viscosity_pa_s": settings.viscosity_pa_s,
        "viscosity": viscosity.from_settings(settings),
        "q_hyperaemic_m3_per_s": q_hyp,
        "outlets": outlets,
        "probes": probes(anatomy, centreline, settings.probe_distance_mm),
    }


def probes(anatomy, centreline, distance_mm):
    """Where FFR is read: `distal` past the most severe lesion, `lesion<k>` past each, `end_<branch>` at each end.

    A probe stays 1.5 diameters inside its branch's end, where the outlet condition does not reach it; without a lesion
    `distal` is at the end of the main branch.
    """

    def probe(name, branch, s_mm):
        line = centreline[branch]
        last = line.length_mm - min(3.0 * line.radius_mm[-1], 0.25 * line.length_mm)
        s_mm = min(s_mm, last)
        return {"name": name, "branch": branch, "s_mm": float(s_mm), "point_mm": line.point(s_mm).tolist()}

    lesions = anatomy.get("lesions", [])
    found = []
    if lesions:
        found.append(probe("distal", lesions[0]["branch"], lesions[0]["s_end_mm"] + distance_mm))
    else:
        found.append(probe("distal", centreline.main.name, math.inf))
    for k, lesion in enumerate(lesions[1:], start=2):
        found.append(probe(f"lesion{k}", lesion["branch"], lesion["s_end_mm"] + distance_mm))
    for line in centreline:
        found.append(probe(f"end_{line.name}", line.name, math.inf))
    return found


def check(document, where="boundary.json"):
    """Raises InputError for boundary values that cannot be solved with."""
    keys = ("map_pa", "venous_pressure_pa", "density_kg_per_m3", "viscosity_pa_s", "outlets", "probes")
    for key in keys:
        if key not in document:
            raise InputError("boundary values incomplete", where, f"no key {key}", "make it with `flow boundary`")
    for key, low, high in (("map_pa", 1e3, 4e4), ("density_kg_per_m3", 500, 2000), ("viscosity_pa_s", 1e-4, 1)):
        if not low <= document[key] <= high:
            raise InputError("implausible boundary value", f"{where}: {key}", document[key], f"{low} to {high}, in SI")
    viscosity.of(document, where)
    inflow = document.get("inlet_flow_m3_per_s")
    if inflow is not None and not inflow > 0:
        raise InputError(
            "inflow is not positive", f"{where}: inlet_flow_m3_per_s", inflow, "give m3/s, or null for MAP"
        )
    for outlet in document["outlets"]:
        if not (
            outlet["resistance_pa_s_per_m3"] > 0 or (outlet["resistance_pa_s_per_m3"] == 0 and "pressure_pa" in outlet)
        ):
            raise InputError(
                "outlet resistance is not positive",
                f"{where}: {outlet['name']}",
                outlet["resistance_pa_s_per_m3"],
                "R_i = (MAP - P_v) / Q_i in Pa s/m3, or 0 with pressure_pa",
            )

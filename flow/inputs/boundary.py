"""Boundary values of a patient's coronary flow at hyperaemia.

    Q_hyp = 0.71 M^0.75 / 0.16 mL/min, or a territory's share of the heart's flow (flow.inputs.hyperaemia)
    Q_i / Q_hyp = D_i^2.55 / sum_j D_j^2.55
    MAP = DBP + 0.4 (SBP - DBP)
    R_i = (MAP - P_v) / Q_i

M is the left ventricular mass in g. For outlet i, D_i is the diameter before the intervention, Q_i the flow and R_i the
resistance. DBP and SBP are the diastolic and systolic pressures, P_v the venous pressure. The resistances are the same
for all states of a patient. If the inflow was measured, Q_hyp is that inflow, and all R_i are scaled until the 1D
network of the vessel before the intervention passes it. The exponent 2.55 and the 0.16 are settings.
"""

import math

from common.patient.blood_pressure import mean_arterial_pressure_mmhg
from common.documents import json_reader, schema
from common.errors import InputError
from flow.inputs import hyperaemia, wire
from flow.physics import viscosity
from flow.physics.units import PA_PER_MMHG

ROUNDING_MM = 1e-6  # a probe that lies too near to its lesion by less than this gets no warning
# Largest factor between R_i Q_i and MAP - P_v, in either direction. Beyond it R_i has other units, or belongs to
# another outlet.
LARGEST_FLOW_RATIO = 10.0


def split_by_diameter(diameters_mm, exponent):
    """[fraction of the flow] for each outlet, with the sum 1: D_i^exponent / sum_j D_j^exponent, D_i in mm.

    Raises InputError for a diameter that is not between 0.2 and 12 mm.
    """
    for diameter in diameters_mm:
        if not 0.2 <= diameter <= 12:
            raise InputError("implausible outlet diameter", "anatomy.json ends", diameter, "give mm, 0.2 to 12")
    weights = [diameter**exponent for diameter in diameters_mm]
    total = math.fsum(weights)
    return [weight / total for weight in weights]


def make(anatomy, centreline, patient, settings, measured=None, with_range=False):
    """The document of boundary.json.

    anatomy: document of anatomy.json, from inputs.lumen_summary; centreline: geometry.centreline.Tree; patient: section
    `patient` of a case file; measured: section `measured` of a case file with the place of its pressure wire, or None;
    with_range: whether the document also gets the entry `plausible_flows`. Raises InputError.
    """
    map_pa = mean_arterial_pressure_mmhg(patient["sbp_mmhg"], patient["dbp_mmhg"]) * PA_PER_MMHG
    venous_pa = settings.venous_pressure_mmhg * PA_PER_MMHG
    if venous_pa >= map_pa:
        raise InputError(
            "venous pressure is not below MAP", "venous_pressure_mmhg", settings.venous_pressure_mmhg, "usually 5 mmHg"
        )
    source = hyperaemia.flow_source(patient, settings.hyperaemia_fraction)
    q_hyp = source.pop("flow_m3_per_s")
    ends = [end for end in anatomy["ends"] if end["kind"] == "outlet"]
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
    probe_places = probes(anatomy, centreline, settings.probe_distance_mm)
    warnings = patient_warnings(patient, measured, settings.hyperaemia_fraction) + probe_distance_warnings(
        probe_places, settings.probe_distance_mm
    )
    if measured:
        probe_places.append(wire.sensor_probe(measured["probe"], centreline))
        warnings += wire.upstream_warnings(probe_places[-1], anatomy)
    document = {
        "schema": "vci-boundary-1",
        "map_pa": map_pa,
        "venous_pressure_pa": venous_pa,
        "density_kg_per_m3": settings.density_kg_per_m3,
        "viscosity_pa_s": settings.viscosity_pa_s,
        "viscosity": viscosity.from_settings(settings),
        "q_hyperaemic_m3_per_s": q_hyp,
        "flow_source": source,
        "outlets": outlets,
        "probes": probe_places,
        "warnings": warnings,
    }
    if with_range:
        document["plausible_flows"] = hyperaemia.plausible_flows(patient, settings.hyperaemia_fraction)
    check(document, branches=[line.name for line in centreline])
    return document


def patient_warnings(patient, measured, hyperaemia_fraction=None):
    """[warning] on values of a patient that are unusual, but can be used. patient, measured: as in `make`."""
    return hyperaemia.flow_warnings(patient, hyperaemia_fraction) + wire.ffr_warnings(measured or {})


def probes(anatomy, centreline, distance_mm):
    """The places at which FFR is read: [{name, branch, s_mm, point_mm}].

    `distal` lies distance_mm past the end of the most severe lesion, which the anatomy lists first. `lesion<k>` lies as
    far past the end of another lesion, `end_<branch>` at the end of a branch. Without a lesion `distal` is at the end
    of the main branch. A probe keeps 1.5 diameters (at most a quarter of the branch) away from its branch's end, where
    the outlet condition would disturb it. So a probe past a lesion may be nearer to it than distance_mm. Its entry
    `distance_mm` is the true distance.
    """

    def probe(name, branch, s_mm):
        line = centreline[branch]
        last = line.length_mm - min(3.0 * line.radius_mm[-1], 0.25 * line.length_mm)
        s_mm = min(s_mm, last)
        return {"name": name, "branch": branch, "s_mm": float(s_mm), "point_mm": line.point(s_mm).tolist()}

    def past_lesion(name, lesion):
        entry = probe(name, lesion["branch"], lesion["s_end_mm"] + distance_mm)
        return entry | {"distance_mm": entry["s_mm"] - lesion["s_end_mm"]}

    lesions = anatomy.get("lesions", [])
    found = []
    if lesions:
        found.append(past_lesion("distal", lesions[0]))
    else:
        found.append(probe("distal", centreline.main.name, math.inf))
    for k, lesion in enumerate(lesions[1:], start=2):
        found.append(past_lesion(f"lesion{k}", lesion))
    for line in centreline:
        found.append(probe(f"end_{line.name}", line.name, math.inf))
    return found


def probe_distance_warnings(probe_places, distance_mm):
    """[warning] on probes (from `probes`) that lie less than `distance_mm` past their lesion, as the branch ends."""
    return [
        f"probe {probe['name']} is {probe['distance_mm']:.1f} mm past its lesion's end instead of {distance_mm:g} mm,"
        f" since branch {probe['branch']} ends"
        for probe in probe_places
        if probe.get("distance_mm", distance_mm) < distance_mm - ROUNDING_MM
    ]


def check(document, where="boundary.json", branches=None):
    """Raises InputError for boundary values `document` that no flow can be solved with.

    branches: names of the branches of the lumen, or None if they are not known.
    """
    given = json_reader.Document(where, document)
    given.check_finite()
    schema.validate(given, schema.read("boundary"))
    _check_values(document, where)
    first = document["probes"][0]["name"]
    if first != "distal":
        remedy = "let the one whose FFR is the answer be the first, named distal"
        raise InputError("the first probe is not `distal`", f"{where}: probes", first, remedy)
    for group, keys in (("outlets", ("name", "region_id", "branch")), ("probes", ("name",))):
        for key in keys:
            _check_distinct(document[group], f"{where}: {group}", key)
    for one in document["outlets"]:
        _check_flow(one, document, where)
    for one in document["outlets"] + document["probes"] if branches is not None else ():
        if one["branch"] not in branches:
            remedy = f"known: {', '.join(branches)}; make both from the same anatomy"
            raise InputError("no such branch", f"{where}: {one['name']}", one["branch"], remedy)


def _check_values(document, where):
    """Raises InputError unless P_v is below MAP, and the viscosity at high shear rates at most that at rest."""
    map_pa, venous_pa = document["map_pa"], document["venous_pressure_pa"]
    if venous_pa >= map_pa:
        remedy = f"below map_pa, which is {map_pa:g}, in Pa"
        raise InputError("venous pressure is not below MAP", f"{where}: venous_pressure_pa", venous_pa, remedy)
    fluid = document.get("viscosity")
    if fluid and fluid["infinite_shear_pa_s"] > fluid["zero_shear_pa_s"]:
        value = f"{fluid['infinite_shear_pa_s']}, {fluid['zero_shear_pa_s']}"
        remedy = "give infinite_shear_pa_s <= zero_shear_pa_s"
        raise InputError("viscosities out of order", f"{where}: viscosity", value, remedy)


def _check_flow(outlet, document, where):
    """Raises InputError unless an outlet's resistance times its planned flow is MAP - P_v within LARGEST_FLOW_RATIO."""
    pressure, given = document["map_pa"] - document["venous_pressure_pa"], outlet["resistance_pa_s_per_m3"]
    if not 1 / LARGEST_FLOW_RATIO <= given * outlet["flow_m3_per_s"] / pressure <= LARGEST_FLOW_RATIO:
        value = f"{given:.4g} Pa s/m3, with the planned flow of {outlet['flow_m3_per_s']:.4g} m3/s it should be about"
        value += f" {pressure / outlet['flow_m3_per_s']:.4g}"
        remedy = "R_i = (MAP - P_v) / Q_i in Pa s/m3 (1 mmHg s/mL is 1.33322e8 Pa s/m3)"
        raise InputError("resistance does not belong to the outlet's flow", f"{where}: {outlet['name']}", value, remedy)


def _check_distinct(entries, where, key):
    """Raises InputError if two entries have the same value of `key`."""
    values = [entry[key] for entry in entries]
    twice = sorted({value for value in values if values.count(value) > 1})
    if twice:
        raise InputError(f"two have the same {key}", where, twice[0], f"give each a {key} of its own")

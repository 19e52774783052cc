"""Makes the entries of scene.json for a device of the catalogue at one size (docs/design.md)."""

import math

import numpy as np

from common.errors import InputError

_BALLOON_KEYS = ("shoulder_mm", "crimped_diameter_mm", "nominal_pressure_bar", "rated_burst_pressure_bar")
_STENT_KEYS = (
    "crimped_diameter_mm",
    "strut_thickness_mm",
    "hoop_stiffness_n_per_mm",
    "axial_stiffness_n_per_mm",
    "bending_stiffness_n_mm2",
    "radial_strength_mpa",
    "recoil_percent",
)


def device_key(family, diameter_mm, length_mm):
    """Name of a sized device, e.g. des_3.50x18."""
    return f"{family}_{diameter_mm:.2f}x{length_mm:g}"


def device_entries(families, family, diameter_mm, length_mm, where):
    """{key: entry} of a sized device and, for a stent, of its delivery balloon.

    families: {name: document} of config/devices. where: the place in the plan, for messages. Raises InputError if the
    catalogue lacks the size.
    """
    if family not in families:
        raise InputError(
            "no such device family", where, family, f"known: {', '.join(families)}; others by a file in config/devices"
        )
    family_document = families[family]
    for name, size in (("diameters_mm", diameter_mm), ("lengths_mm", length_mm)):
        if size not in family_document[name]:
            remedy = (
                f"one of {family_document[name]}, or add it to {name} in config/devices/{family}.yaml if it is made"
            )
            raise InputError(f"size not in the catalogue of {family}", where, f"{size:g} mm", remedy)
    if family_document["kind"] == "balloon":
        return {device_key(family, diameter_mm, length_mm): _balloon_entry(family_document, diameter_mm, length_mm)}
    delivery = family_document["delivery_balloon"]
    return {
        device_key(delivery, diameter_mm, length_mm): _balloon_entry(families[delivery], diameter_mm, length_mm),
        device_key(family, diameter_mm, length_mm): _stent_entry(family_document, diameter_mm, length_mm),
    }


def diameter_at(balloon, pressure_bar):
    """Diameter in mm of a freely inflated sized balloon at a pressure, by its chart (linear between the points)."""
    chart = balloon["chart"]
    return float(np.interp(pressure_bar, chart["pressure_bar"], chart["diameter_mm"]))


def pressure_for(balloon, diameter_mm, largest_mm=math.inf):
    """Pressure in whole bars that opens a sized balloon nearest to diameter_mm, and not beyond largest_mm.

    It is limited to the range from the balloon's nominal to its rated burst pressure.
    """
    chart = balloon["chart"]
    wanted_bar, largest_bar = np.interp([diameter_mm, largest_mm], chart["diameter_mm"], chart["pressure_bar"])
    pressure = min(round(wanted_bar), math.floor(largest_bar + 1e-9))
    return float(np.clip(pressure, balloon["nominal_pressure_bar"], balloon["rated_burst_pressure_bar"]))


def _balloon_entry(family_document, diameter_mm, length_mm):
    chart = family_document["chart"]
    return {
        "kind": "balloon",
        "nominal_diameter_mm": diameter_mm,
        "length_mm": length_mm,
        **{name: family_document[name] for name in _BALLOON_KEYS},
        **{name: family_document[name] for name in ("folding",) if name in family_document},
        "chart": {
            "pressure_bar": chart["pressure_bar"],
            "diameter_mm": [round(diameter_mm * percent / 100, 6) for percent in chart["diameter_percent"]],
        },
    }


def _stent_entry(family_document, diameter_mm, length_mm):
    design = next(d for d in family_document["designs"] if diameter_mm <= d["up_to_diameter_mm"])
    return {
        "kind": "stent",
        "balloon": device_key(family_document["delivery_balloon"], diameter_mm, length_mm),
        "nominal_diameter_mm": diameter_mm,
        "length_mm": length_mm,
        **{name: family_document[name] for name in _STENT_KEYS},
        **{name: design[name] for name in ("maximal_diameter_mm", "crowns", "links")},
    }

"""The devices of a scene as the slices need them: radius along the axis, stiffness, largest pressure on the wall."""

from dataclasses import dataclass

import numpy as np

from common.errors import InputError

MPA_PER_BAR = 0.1
# Ratio of two hoop tensions: the one that opens the crimped stent over the one at the nominal diameter. Struts open by
# plastic bending at their ends. The tension is 2 M / (l cos a), with the plastic moment M, a strut's length l and its
# angle a to the axis. For 16 struts of 1 mm cos a falls from 0.98 to 0.81. M grows with the flow stress of L605, from
# its yield stress of 476 MPa to about 890 MPa at a strain of 0.17. The latter is on the line to its true strength of
# 1449 MPa at 0.4. These figures are usual in finite-element studies of stents; no paper is at hand.
CRIMPED_TENSION_SHARE = 0.44
# A balloon that cannot open the stent round it still presses on the wall with this share of its inflation pressure.
LEAST_BALLOON_SHARE = 0.2


@dataclass(frozen=True)
class Balloon:
    """An inflated balloon.

    radius_mm: free radius at the inflation pressure. cap_mpa: inflation pressure, its largest pressure on the wall.
    stiffness_mpa_per_mm: pressure on the wall per mm by which the wall holds the balloon below its free radius.
    """

    name: str
    centre_s_mm: float
    length_mm: float
    shoulder_mm: float
    radius_mm: float
    stiffness_mpa_per_mm: float
    cap_mpa: float

    def radius_at(self, s_mm):
        """Free radius (mm) at arc length s: full over its length, linear to 0 over the shoulders."""
        beyond = np.abs(s_mm - self.centre_s_mm) - 0.5 * self.length_mm
        return self.radius_mm * np.clip(1 - np.maximum(beyond, 0) / self.shoulder_mm, 0, 1)

    def reach(self):
        """Arc lengths (mm) between which the balloon can touch the wall."""
        half = 0.5 * self.length_mm + self.shoulder_mm
        return self.centre_s_mm - half, self.centre_s_mm + half


@dataclass(frozen=True)
class Stent:
    """A stent, which opens from the crimped to the nominal radius.

    recoil_share: share of the radius reached that it holds after deflation of its balloon. cap_mpa: radial strength,
    its largest pressure on the wall.
    """

    name: str
    start_s_mm: float
    end_s_mm: float
    recoil_share: float
    cap_mpa: float
    bending_n_mm2: float
    nominal_radius_mm: float
    crimped_radius_mm: float

    def opening_pressure_mpa(self, radius_mm):
        """Pressure inside the stent at which its rings yield and open further, by Laplace's law.

        The rings' tension grows with the logarithm of the radius. At the nominal radius the pressure is the radial
        strength.
        """
        radius = max(radius_mm, self.crimped_radius_mm)
        opened = np.log(radius / self.crimped_radius_mm) / np.log(self.nominal_radius_mm / self.crimped_radius_mm)
        tension = CRIMPED_TENSION_SHARE + (1 - CRIMPED_TENSION_SHARE) * opened
        return self.cap_mpa * tension * self.nominal_radius_mm / radius

    def covers(self, s_mm):
        """Whether the stent covers arc length s_mm, a number or an array."""
        return (self.start_s_mm - 1e-9 <= s_mm) & (s_mm <= self.end_s_mm + 1e-9)

    def ends(self):
        """Arc lengths (mm) of the stent's ends."""
        return self.start_s_mm, self.end_s_mm


@dataclass(frozen=True)
class Step:
    """One step of the procedure on one branch: a balloon, and the stent that it carries or None."""

    name: str
    action: str
    balloon: Balloon
    stent: Stent

    def free_radius(self, radius_mm, opened):
        """Radius (mm) that the balloon reaches in air, inside the Stent `opened` or without one (None).

        radius_mm: radius by the balloon's chart. The chart of a delivery balloon was measured with its stent, so it
        holds as it is. Any other balloon loses pressure to the stent.
        """
        if opened is None or opened is self.stent:
            return radius_mm
        return radius_mm - opened.opening_pressure_mpa(radius_mm) / self.balloon.stiffness_mpa_per_mm

    def cap_mpa(self, radius_mm, opened):
        """Largest pressure (MPa) of the balloon on the wall, at a radius in mm of the lumen.

        It is the inflation pressure without the part that opens the Stent `opened`.
        """
        cap = self.balloon.cap_mpa
        return cap if opened is None else max(cap - opened.opening_pressure_mpa(radius_mm), LEAST_BALLOON_SHARE * cap)


def _required(entry, key, where):
    if key not in entry:
        raise InputError("missing key", f"{where}.{key}", "nothing", "write the scene with the planning command")
    return entry[key]


def inflated_balloon(entry, name, centre_s_mm, pressure_bar, where):
    """The Balloon of a scene's device `entry` at a pressure. where: place of the entry, for messages.

    Raises InputError if the pressure is off the balloon's chart.
    """
    chart = _required(entry, "chart", where)
    pressures, diameters = np.array(chart["pressure_bar"], float), np.array(chart["diameter_mm"], float)
    if len(pressures) != len(diameters) or np.any(np.diff(pressures) <= 0) or np.any(np.diff(diameters) <= 0):
        remedy = "as many diameters as pressures, both rising"
        raise InputError("not a balloon's chart", f"{where}.chart", diameters.tolist(), remedy)
    if not pressures[0] <= pressure_bar <= pressures[-1]:
        raise InputError(
            "pressure off the balloon's chart",
            f"{where}: {name}",
            f"{pressure_bar} bar",
            f"between {pressures[0]} and {pressures[-1]} bar",
        )
    # A wall that holds the balloon below its free diameter carries a part of the inflation pressure. This part is the
    # excess over the chart's pressure at the diameter reached. So the stiffness is the slope of the chart over the last
    # 2 bar.
    low = max(pressure_bar - 2.0, pressures[0])
    high = low + 2.0
    growth = np.interp(high, pressures, diameters) - np.interp(low, pressures, diameters)
    return Balloon(
        name,
        centre_s_mm,
        _required(entry, "length_mm", where),
        _required(entry, "shoulder_mm", where),
        0.5 * float(np.interp(pressure_bar, pressures, diameters)),
        (high - low) * MPA_PER_BAR / max(0.5 * growth, 1e-6),
        pressure_bar * MPA_PER_BAR,
    )


def procedure_steps(scene, where):
    """(branch name, [Step]) of a scene.

    Raises InputError for several devices at a time, or several branches: slices of one branch cannot compute these.
    """
    found, branches = [], []
    for number, step in enumerate(scene["procedure"], start=1):
        here = f"{where}: procedure[{number}]"
        if len(step["devices"]) != 1:
            raise InputError(
                "the slice-wise reference takes one device at a time",
                here,
                f"{len(step['devices'])} devices",
                "leave the reference out for this plan",
            )
        use = step["devices"][0]
        if use["device"] not in scene["devices"]:
            raise InputError("no such device", f"{here}.devices[1].device", use["device"], "list it under devices")
        entry = scene["devices"][use["device"]]
        key = f"{where}: devices.{use['device']}"
        branches.append(use["branch"])
        stent = None
        name = use["device"]
        if entry["kind"] == "stent":
            half = 0.5 * _required(entry, "length_mm", key)
            stent = Stent(
                name,
                use["centre_s_mm"] - half,
                use["centre_s_mm"] + half,
                1 - 0.01 * _required(entry, "recoil_percent", key),
                _required(entry, "radial_strength_mpa", key),
                _required(entry, "bending_stiffness_n_mm2", key),
                0.5 * _required(entry, "nominal_diameter_mm", key),
                0.5 * _required(entry, "crimped_diameter_mm", key),
            )
            if not stent.nominal_radius_mm > stent.crimped_radius_mm:
                raise InputError(
                    "the stent is no wider than crimped",
                    f"{key}.nominal_diameter_mm",
                    f"{entry['nominal_diameter_mm']} mm",
                    f"more than the {entry['crimped_diameter_mm']} mm of the crimped stent",
                )
            name = _required(entry, "balloon", key)
            if scene["devices"].get(name, {}).get("kind") != "balloon":
                raise InputError("no such balloon", f"{key}.balloon", name, "list it under devices")
            entry, key = scene["devices"][name], f"{where}: devices.{name}"
        used = inflated_balloon(entry, name, use["centre_s_mm"], use["pressure_bar"], key)
        found.append(Step(step["name"], step["action"], used, stent))
    if len(set(branches)) != 1:
        raise InputError(
            "the slice-wise reference treats one branch",
            f"{where}: procedure",
            ", ".join(sorted(set(branches))),
            "leave the reference out for this plan",
        )
    return branches[0], found

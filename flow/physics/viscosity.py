"""Viscosity of blood as a function of the shear rate.

    Newtonian:        mu
    Carreau-Yasuda:   mu_inf + (mu_0 - mu_inf) (1 + (lambda rate)^a)^((n - 1) / a)

rate = sqrt(2 D:D). Default values of Carreau-Yasuda: Cho and Kensey, Biorheology 28 (1991) 241.
"""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Newtonian:
    """A constant viscosity `value` in Pa s."""

    value: float

    def __call__(self, rate):
        """Viscosity in Pa s at rates in 1/s: number, array or UFL expression."""
        return self.value + 0.0 * rate


@dataclasses.dataclass(frozen=True)
class CarreauYasuda:
    """Viscosities mu_0 at rest and mu_inf at infinite rate in Pa s, `time` lambda in s, exponents a (`yasuda`) and n
    (`power`)."""

    zero_shear: float
    infinite_shear: float
    time: float
    yasuda: float
    power: float

    def __call__(self, rate):
        """Viscosity in Pa s at rates in 1/s: number, array or UFL expression."""
        thinning = (1.0 + (self.time * rate) ** self.yasuda) ** ((self.power - 1.0) / self.yasuda)
        return self.infinite_shear + (self.zero_shear - self.infinite_shear) * thinning


def from_document(document):
    """Newtonian or CarreauYasuda by the document of boundary.json (inputs.boundary checks it).

    The entry `viscosity` counts, or the constant `viscosity_pa_s` if that entry is missing.
    """
    given = document.get("viscosity")
    if given is None:
        return Newtonian(document["viscosity_pa_s"])
    names = {
        "zero_shear": "zero_shear_pa_s",
        "infinite_shear": "infinite_shear_pa_s",
        "time": "time_s",
        "yasuda": "yasuda_exponent",
        "power": "power_index",
    }
    return CarreauYasuda(**{name: float(given[key]) for name, key in names.items()})


def from_settings(settings):
    """Entry `viscosity` of boundary.json by the flow settings, None for a Newtonian fluid."""
    if settings.viscosity_model == "newtonian":
        return None
    return {
        "model": settings.viscosity_model,
        "zero_shear_pa_s": settings.viscosity_zero_shear_pa_s,
        "infinite_shear_pa_s": settings.viscosity_infinite_shear_pa_s,
        "time_s": settings.viscosity_time_s,
        "yasuda_exponent": settings.viscosity_yasuda_exponent,
        "power_index": settings.viscosity_power_index,
    }

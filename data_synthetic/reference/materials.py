"""Constants of the reference's tissues, with where they come from. Fixed before any comparison with another model.

MPa throughout. Plaque: neo-Hookean, multiplicative J2 plasticity with linear isotropic hardening. Wall: Yeoh.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Plaque:
    """shear_mpa: shear modulus; yield_mpa: initial uniaxial yield stress; hardening_mpa: slope of yield over strain."""

    shear_mpa: float
    yield_mpa: float
    hardening_mpa: float
    source: str


FIBROUS = Plaque(
    0.2,
    0.1,
    0.2,
    "choice: secant stiffness of the order of carotid plaque in Maher et al., J Biomech 42 (2009); "
    "inelastic behaviour as in Maher et al., J Biomech 44 (2011); values set for 5-9 % recoil",
)
LIPID = Plaque(0.02, 0.01, 0.005, "choice: a tenth of fibrous, as soft pools in Loree et al., J Biomech 27 (1994)")
CALCIFIED = Plaque(
    2.0, 0.5, 0.1, "choice: ten times fibrous; an effective value for calcified tissue that yields by cracking"
)
OF_TYPE = {1: FIBROUS, 2: LIPID, 3: CALCIFIED}

WALL_SOURCE = (
    "choice: strain-stiffening Yeoh constants of the order of healthy coronary media and adventitia in "
    "Holzapfel et al., Am J Physiol Heart 289 (2005)"
)


def blended(base, calcium_share):
    """(shear, yield, hardening) arrays between a base plaque and calcium, geometric in each constant.

    calcium_share: (...) 0 ... 1. A sharp edge of a hundredfold stiffness would not converge.
    """
    share = np.asarray(calcium_share, float)

    def mix(a, b):
        return a ** (1 - share) * b**share

    return (
        mix(base.shear_mpa, CALCIFIED.shear_mpa),
        mix(base.yield_mpa, CALCIFIED.yield_mpa),
        mix(base.hardening_mpa, CALCIFIED.hardening_mpa),
    )

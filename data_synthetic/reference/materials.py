"""Constants of the reference's tissues, with where they come from. Fixed before any comparison with another model.

No value is taken over from a paper as it stands; each is a choice, and the papers named give its order or its limits.

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


TENG = "Teng et al., J Biomech 48 (2015) 3859"
FIBROUS = Plaque(
    0.2,
    0.1,
    0.2,
    "choice, for the recoil of stents in patients: 5.0 +- 2.2 % and 5.7 +- 4.1 % (Borghi et al., Rev Bras Cardiol "
    "Invasiva 21 (2013) 326), 8.6 +- 4.9 % (van Bommel et al., Catheter Cardiovasc Interv 2017). Permanent deformation "
    "that grows with the peak strain: Maher et al., Ann Biomed Eng 39 (2011) 2445. Yield stress within the tensile "
    f"strength of carotid fibrous caps, 0.16 (0.07 ... 0.26) MPa ({TENG}). Shear modulus above that of indented "
    "carotid caps, 0.007 ... 0.1 MPa (Barrett et al., J Biomech 42 (2009) 1650)",
)
LIPID = Plaque(
    0.02,
    0.01,
    0.005,
    "choice: a tenth of fibrous; yields below the tensile strength of carotid lipid, 0.07 (0.05 ... 0.09) MPa "
    f"({TENG})",
)
CALCIFIED = Plaque(
    2.0, 0.5, 0.1, "choice: ten times fibrous; an effective value for calcified tissue that yields by cracking"
)
OF_TYPE = {1: FIBROUS, 2: LIPID, 3: CALCIFIED}

WALL_SOURCE = (
    "choice: soft, then stiffening, as the layers of human coronary arteries do in Holzapfel et al., Am J Physiol "
    "Heart 289 (2005) H2048; isotropic, and the constants are not theirs"
)
SETTINGS_SOURCE = (
    "choices: support_mpa_per_mm, bulk_modulus_mpa (nearly incompressible), stent_stiffness_mpa_per_mm, "
    "vessel_bending_n_mm2, edge_decay_mm; recoil, radial strength and bending stiffness of the stent: its device"
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

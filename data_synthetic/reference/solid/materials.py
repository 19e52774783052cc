"""Constants of the reference's tissues, with their sources and published ranges. None was fitted to the engine.

No value is copied from a paper. The strength of calcified plaque (CALCIFIED) was identified: with it a stent's
expansion falls with the calcium's arc as measured in patients. The engine's strength was identified by the same
measurement, so an agreement of both in calcium tests neither. Every other value is a choice. It lies within the range
of the papers named, or its distance from that range is stated. Only abstracts of the papers were read, and the measured
quantities are not always a model's constants. All stresses are in MPa. Plaque: neo-Hookean, multiplicative J2
plasticity with linear isotropic hardening. Wall: Yeoh.

The constants were checked against whole coronary lesions, stretched by 1.15 both along the vessel and round it.
Ghorbannia and LaDisa measured circumferential stresses of 0.067, 0.13 and 0.30 MPa, in lesions that a balloon opened
well, less well, and hardly. At this stretch the fibrous plaque here carries 0.12 MPa (it yields), the wall 0.21, the
lipid-rich plaque 0.01 and the calcified 1.6 MPa (`biaxial_stress`).
"""

from dataclasses import dataclass

import numpy as np

from common.patient import plaque_types


@dataclass(frozen=True)
class Plaque:
    """Constants of a plaque, with their source in words.

    shear_mpa: shear modulus. yield_mpa: initial uniaxial yield stress. hardening_mpa: slope of the yield stress over
    the plastic strain.
    """

    shear_mpa: float
    yield_mpa: float
    hardening_mpa: float
    source: str


TENG = "Teng et al., J Biomech 48 (2015) 3859, doi 10.1016/j.jbiomech.2015.09.037"
BARRETT = "Barrett et al., J Biomech 42 (2009) 1650, doi 10.1016/j.jbiomech.2009.04.025"
MAHER = "Maher et al., Ann Biomed Eng 39 (2011) 2445, doi 10.1007/s10439-011-0331-4"
GHORBANNIA = "Ghorbannia and LaDisa, Front Bioeng Biotechnol 11 (2023) 1192797, doi 10.3389/fbioe.2023.1192797"
FUJINO = "Fujino et al., EuroIntervention 13 (2018), doi 10.4244/EIJ-D-17-00962"
FIBROUS = Plaque(
    0.2,
    0.1,
    0.2,
    "shear 0.2: choice, twice the upper end of indented carotid caps, 0.007 ... 0.1 MPa, median 0.011 "
    f"({BARRETT}), for coronary lesions are stiffer: middle class of {GHORBANNIA}. yield 0.1: choice within the "
    f"tensile strength of carotid fibrous caps, 0.158 (quartiles 0.072 ... 0.259) MPa ({TENG}). hardening 0.2: choice, "
    f"that permanent deformation grows about linearly with the peak strain ({MAHER}) and recoil is that of stents in "
    "patients: 5.0 +- 2.2 % and 5.7 +- 4.1 % (Borghi et al., Rev Bras Cardiol Invasiva 21 (2013) 326), 8.6 +- 4.9 % "
    "(van Bommel et al., Catheter Cardiovasc Interv 2017)",
)
LIPID = Plaque(
    0.02,
    0.01,
    0.005,
    f"shear 0.02: choice within 0.007 ... 0.1 MPa, near the median 0.011 ({BARRETT}). yield 0.01: choice, below the "
    f"tensile strength of carotid lipid, 0.069 (quartiles 0.049 ... 0.087) MPa ({TENG}), as it flows before it tears. "
    f"hardening 0.005: choice, little; permanent deformation like that of other plaque ({MAHER})",
)
CALCIFIED = Plaque(
    6.0,
    1.5,
    0.3,
    "yield 1.5: identified. With it a stent's expansion falls by 6.5 % for 180 degrees more of calcium; measured -7.43 "
    f"% ({FUJINO}). With 0.5 it does not fall (-0.3 %), with 3.0 by 20 %. shear 6 and hardening 0.3: choices, four "
    "times and a fifth of it. An effective value of tissue with deposits that gives way by cracking; the mineral "
    f"itself is far stiffer. Five times the stiffest class of {GHORBANNIA}, which are whole lesions with calcium in a "
    "part of them",
)
BY_PLAQUE_TYPE = {plaque_types.FIBROUS: FIBROUS, plaque_types.LIPID: LIPID, plaque_types.CALCIFIED: CALCIFIED}

WALL_SOURCE = (
    "C10 0.05, C20 0.2: choices; soft, then stiffening, as the layers of human coronary arteries do in Holzapfel et "
    "al., Am J Physiol Heart 289 (2005) H2048, isotropic here, not their constants; 0.21 MPa at a biaxial stretch of "
    f"1.15, between the middle and the stiffest class of {GHORBANNIA}"
)
SETTINGS_SOURCE = {
    "stent_stiffness_mpa_per_mm": "1.5: choice near 0.02 MPa / (0.8 % of 1.5 mm) = 1.6, by the recoil that an outer "
    "0.2 bar added to the tubular stent of least recoil, 1.54 -> 2.35 % (Barragan et al., Catheter Cardiovasc Interv "
    "50 (2000) 112)",
    "stent's recoil_percent": "of its device; measured 4.1 ... 5.9 % (Schmidt et al., Eur J Med Res 22 (2017), doi "
    "10.1186/s40001-017-0300-y)",
    "stent's bending_stiffness_n_mm2": "of its device; measured 17 ... 47 N mm2, crimped (Schmidt et al., Catheter "
    "Cardiovasc Interv 73 (2009) 350, doi 10.1002/ccd.21832)",
    "support_mpa_per_mm": "0.01: 2 G / r, the support of a cylinder of radius r by an elastic medium of shear modulus "
    "G (Lame), for r 2.7 mm and G 13 kPa: myocardium in systole, 6.08 +- 1.06 kPa in diastole at 60 to 80 years "
    "(Villemain et al., JACC Cardiovasc Imaging 12 (2019) 1135) times the healthy ratio of 2.10 +- 0.47 (Jin et al., "
    "Ultrasound Med Biol 49 (2023) 1719, doi 10.1016/j.ultrasmedbio.2023.03.016). The stiffest of what surrounds the "
    "vessel: diastole would give 0.0045, fat of 0.75 kPa (Strain-dependent shear properties of human adipose tissue in "
    "vivo, J Mech Behav Biomed Mater 2023) 0.0006",
    "bulk_modulus_mpa": "20: choice, a hundred times the fibrous shear modulus (Poisson's ratio 0.495)",
    "edge_decay_mm": "0.6: choice, of the order of sqrt(r t) (3 (1 - nu^2))^(-1/4) for a shell of radius r and "
    "thickness t (Timoshenko, Theory of Plates and Shells), 0.8 mm for 1.4 and 0.7 mm",
}


def biaxial_stress(stretch, plaque=None, c10_mpa=0.0, c20_mpa=0.0):
    """In-plane Cauchy stress (MPa) of an incompressible sheet under equal biaxial stretch, of a Plaque or a Yeoh wall.

    The stress sigma of a yielding plaque follows from logarithmic strain: sigma = Y + H (2 ln stretch - sigma / (3
    mu)), with the yield stress Y, hardening H and shear modulus mu.
    """
    if plaque is None:
        first = 2 * stretch**2 + stretch**-4 - 3
        return 2 * (c10_mpa + 2 * c20_mpa * first) * (stretch**2 - stretch**-4)
    elastic = plaque.shear_mpa * (stretch**2 - stretch**-4)
    if elastic <= plaque.yield_mpa:
        return elastic
    hardening = plaque.hardening_mpa
    return (plaque.yield_mpa + 2 * hardening * np.log(stretch)) / (1 + hardening / (3 * plaque.shear_mpa))


def blend_with_calcium(base, calcium_share):
    """(shear, yield, hardening) in MPa, each (...), of a base Plaque that holds calcium.

    calcium_share (...): share of calcium, 0 to 1. Each constant is interpolated geometrically between base and
    calcified plaque. The constants change gradually, since Newton's method fails at a sharp edge where stiffness
    changes a hundredfold.
    """
    share = np.asarray(calcium_share, float)

    def mix(a, b):
        return a ** (1 - share) * b**share

    return (
        mix(base.shear_mpa, CALCIFIED.shear_mpa),
        mix(base.yield_mpa, CALCIFIED.yield_mpa),
        mix(base.hardening_mpa, CALCIFIED.hardening_mpa),
    )

"""The power law of radii at bifurcations. Its exponent is recovered from tapered vessels.

The radii are those of the vessel's profile, of the grown tree, or of plane sections of the surface. They are taken just
before an ostium, past its far rim, and in the side branch clear of the main wall. The exponent is sensitive: for the
vessels here an error of 0.1 % in the radius past the ostium changes it by 0.01.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from common.documents import schema
from common.implicit import field, surface
from data_synthetic import healthy_radius, tree
from data_synthetic.ct import evaluate

FIELD_TOLERANCE = 3e-3  # radii are interpolated between samples of 0.1 mm, and the taper begins with a kink
SURFACE_TOLERANCE = 0.05  # the polygons of sections lose 0.05 to 0.3 % of the radius, in the side branch more
SPACING_MM = 0.25


def exponent_of(before, after, side):
    """The exponent m for which before^m = after^m + side^m. The radii may be in any unit."""
    return brentq(lambda m: 1 - (after / before) ** m - (side / before) ** m, 0.5, 12)


def sampling_positions(vessel):
    """For each bifurcation three arc lengths (mm): on the main branch before and after it, and on the side branch clear
    of the main wall."""
    forks = healthy_radius.bifurcations(vessel)
    return [(fork.start_mm, fork.end_mm, fork.side_level_mm) for fork in forks]


def random_vessel(seed, exponent):
    """A vessel with two side branches, all tapered. Vessels of odd seeds have a lesion between the ostia.

    The vessel bends gently, because walls separate later if the vessel bends towards a side branch.
    """
    rng = np.random.default_rng(seed)
    sides = [
        {"s_mm": 13, "diameter_mm": rng.uniform(1.8, 2.4), "length_mm": 12, "angle_deg": rng.uniform(45, 75)},
        {"s_mm": 34, "diameter_mm": rng.uniform(1.6, 2.0), "length_mm": 10, "angle_deg": rng.uniform(45, 75)},
    ]
    for side, azimuth in zip(sides, (0, 160)):
        side.update(azimuth_deg=azimuth + 20 * seed, taper_percent_per_cm=rng.uniform(1, 5))
    lesion = {"centre_s_mm": 25, "length_mm": 7, "diameter_stenosis_percent": 60}
    main = {"length_mm": 50, "ostial_diameter_mm": rng.uniform(3.4, 4.6), "taper_percent_per_cm": rng.uniform(1, 5)}
    main.update(mean_curvature_per_mm=0.05, max_curvature_per_mm=0.12)
    data = {"seed": seed, "murray_exponent": exponent, "main": main, "side_branches": sides}
    data["lesions"] = [lesion] if seed % 2 else []
    return schema.with_defaults(data, schema.read("vessel"))


@pytest.mark.parametrize("exponent", [2.3, 2.55, 3.0])
@pytest.mark.parametrize("seed", range(6))
def test_exponent_of_the_profile(seed, exponent):
    vessel = random_vessel(seed, exponent)
    for fork, side in zip(healthy_radius.bifurcations(vessel), healthy_radius.ordered_side_branches(vessel)):
        before, after = healthy_radius.main_healthy_radius(vessel, np.array([fork.start_mm, fork.end_mm]))
        clear = float(healthy_radius.side_healthy_radius(side, fork, fork.side_level_mm))
        assert exponent_of(before, after, clear) == pytest.approx(exponent, abs=1e-8)


@pytest.mark.parametrize("exponent", [2.3, 2.55, 3.0])
@pytest.mark.parametrize("seed", range(6))
def test_exponent_from_the_field(seed, exponent):
    vessel = random_vessel(seed, exponent)
    main, *sides = tree.grow(vessel)
    assert vessel["main"]["taper_percent_per_cm"] >= 1 and len(sides) == 2
    for (before, after, clear), branch in zip(sampling_positions(vessel), sides):
        found = exponent_of(main.healthy_radius(before), main.healthy_radius(after), branch.healthy_radius(clear))
        assert found == pytest.approx(exponent, abs=FIELD_TOLERANCE)


@pytest.mark.parametrize("seed, exponent", [(0, 2.55), (1, 2.55), (2, 2.55), (3, 2.3), (4, 3.0)])
def test_exponent_from_sections_of_the_surface(seed, exponent):
    vessel = random_vessel(seed, exponent)
    branches = tree.grow(vessel)
    points, triangles, _ = surface.build(field.LumenField(branches), SPACING_MM)

    def radius(branch, s_mm):
        s = np.array(float(s_mm))
        area = evaluate.section_area(points, triangles, branch.axis.point(s), branch.axis.frame(s)[0])
        return np.sqrt(area / np.pi)

    for (before, after, clear), branch in zip(sampling_positions(vessel), branches[1:]):
        found = exponent_of(radius(branches[0], before), radius(branches[0], after), radius(branch, clear))
        assert found == pytest.approx(exponent, abs=SURFACE_TOLERANCE)

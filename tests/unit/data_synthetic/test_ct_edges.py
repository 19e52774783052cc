import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.special import erf

from anatomy.ct.rays import calcified, edges, stented
from common import volume as image
from common.implicit.curves import Curve

SIGMA = 0.31


def profiles_of(volume, spacing=0.25):
    axis = Curve(np.stack([np.full(61, 0.07), np.full(61, -0.11), np.linspace(-6, 6, 61)], axis=1))
    return edges.sample(volume.interpolator(), axis, spacing, 32)


@pytest.mark.parametrize("radius", [0.5, 0.7, 1.0, 1.6])
@pytest.mark.parametrize("voxel", [0.35, 0.5])
def test_psf_edge_is_unbiased_on_blurred_tubes(ct_tubes, radius, voxel):
    volume = ct_tubes.tube_image(radius, voxel, SIGMA)
    found, replaced = edges.find_edges(profiles_of(volume), "psf_edge", 400.0, SIGMA)
    assert found[8:-8].mean() == pytest.approx(radius, abs=0.03)
    assert found[8:-8].std() < 0.02 and not replaced.any()


def test_half_maximum_is_biased_in_the_known_direction(ct_tubes):
    """In a wide tube the level at the true edge is below one half, so the half-maximum radius is too small."""
    found, _ = edges.find_edges(profiles_of(ct_tubes.tube_image(1.6, 0.35, SIGMA)), "half_maximum", 400.0)
    assert 1.5 < found.mean() < 1.59


def test_edge_share_is_that_of_a_blurred_disc():
    n, h, radius = 401, 0.015, 0.9
    x = h * (np.arange(n) - n // 2)
    inside = np.hypot(x[:, None], x[None]) < radius
    weight = np.exp(-0.5 * (np.hypot(x[:, None] - radius, x[None]) / SIGMA) ** 2)
    assert edges.edge_share(radius, SIGMA) == pytest.approx((inside * weight).sum() / weight.sum(), abs=0.003)
    assert edges.edge_share(50.0, SIGMA) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("sigma", [0.25, 0.31, 0.42])
def test_point_spread_is_measured(ct_tubes, sigma):
    volume = ct_tubes.tube_image(1.6, 0.35, sigma)
    noise = np.random.default_rng(2).normal(0, 25, volume.values.shape)
    volume.values = volume.values + noise
    profiles = profiles_of(volume)
    radius, _ = edges.find_edges(profiles, "half_maximum", 400.0)
    assert edges.point_spread(profiles, radius, 400.0) == pytest.approx(sigma, rel=0.06)


def test_a_narrow_vessel_tells_nothing_of_the_point_spread(ct_tubes):
    profiles = profiles_of(ct_tubes.tube_image(0.8, 0.35, SIGMA))
    radius, _ = edges.find_edges(profiles, "half_maximum", 400.0)
    assert edges.point_spread(profiles, radius, 400.0) is None


def test_first_fall_is_linear_and_says_when_there_is_none():
    r = np.arange(0, 1, 0.1)
    hu = np.stack([400 - 300 * r, np.full(10, 400.0), np.full(10, 100.0), np.where(r < 0.45, 400, 0)])[None]
    found = edges.first_fall(hu, r, np.full((1, 4), 250.0))[0]
    assert found[0] == pytest.approx(0.5) and np.isnan(found[1]) and found[2] == 0
    assert found[3] == pytest.approx(0.4375)


def test_rays_into_a_side_branch_are_replaced_by_their_neighbours():
    radius = np.full((20, 32), 1.5)
    radius[8:12, 5:9] = 3.0
    radius[3, 20] = np.nan
    tidy, replaced = edges.replace_outliers(radius)
    assert np.allclose(tidy, 1.5)
    assert replaced[8:12, 5:9].all() and replaced[3, 20] and replaced.sum() == 17


def test_filter_keeps_cubics_and_few_harmonics():
    s, theta = np.arange(0, 20, 0.25), np.linspace(0, 2 * np.pi, 32, endpoint=False)
    radius = 1.5 + 0.001 * (s - 9)[:, None] ** 3 + 0.2 * np.cos(3 * theta)
    assert np.allclose(edges.smooth_radii(radius, s), radius)
    rough = radius + 0.1 * np.cos(9 * theta)
    assert np.allclose(edges.smooth_radii(rough, s), radius)
    assert np.allclose(edges.smooth_along(radius, s, derivative=2), (0.006 * (s - 9))[:, None], atol=1e-9)


def test_calcium_beside_the_lumen_does_not_count_as_lumen(ct_tubes):
    volume = ct_tubes.tube_image(1.0, 0.35, SIGMA)
    x, y = (volume.centres(k)[:, None, None] for k in (0, 1))
    y = y.reshape(1, -1, 1)
    stone = np.exp(-0.5 * (((x - 1.55) / 0.35) ** 2 + (y / 0.6) ** 2))
    volume.values = volume.values + 700 * np.broadcast_to(stone, volume.values.shape)
    profiles = profiles_of(volume)
    radius, _ = edges.find_edges(profiles, "psf_edge", 400.0, SIGMA)
    assert radius[:, 0] == pytest.approx(1.0, abs=0.15)
    assert np.sqrt((radius**2).mean()) == pytest.approx(1.0, abs=0.1)


def calcified_image(degrees, gap_mm, hu=1000.0, thick_mm=0.8, noise=20.0, voxel=0.4, radius_mm=1.6):
    """Image of a cylinder along z with an arc of calcium over |z| < 3 mm, blurred by SIGMA, and noise."""
    fine = voxel / 4
    axis = fine * (np.arange(120) - 59.5)
    x, y = np.meshgrid(axis - 0.07, axis + 0.11, indexing="ij")
    r, angle = np.hypot(x, y), np.degrees(np.abs(np.arctan2(y, x)))
    soft = np.where(r < radius_mm, 400.0, np.where(r < radius_mm + 1.0, 50.0, -80.0))
    stone = (r > radius_mm + gap_mm) & (r < radius_mm + gap_mm + thick_mm) & (angle <= degrees / 2)
    blurred = [gaussian_filter(values, SIGMA / fine) for values in (soft, np.where(stone, hu, soft))]
    coarse = [values.reshape(30, 4, 30, 4).mean(axis=(1, 3)) for values in blurred]
    z = voxel * (np.arange(60) - 29.5)
    share = 0.5 * (erf((z + 3) / SIGMA / np.sqrt(2)) - erf((z - 3) / SIGMA / np.sqrt(2)))
    values = coarse[0][..., None] + (coarse[1] - coarse[0])[..., None] * share
    values += np.random.default_rng(3).normal(0, noise, values.shape)
    return image.Image(values, np.array([-14.5 * voxel, -14.5 * voxel, z[0]]), np.full(3, voxel))


@pytest.mark.parametrize("gap_mm", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("degrees", [120, 180, 270, 360])
def test_an_arc_of_calcium_is_no_stent_and_no_lumen(degrees, gap_mm):
    profiles = profiles_of(calcified_image(degrees, gap_mm))
    calcium, _, stent = edges.find_calcium_and_stents(profiles, 400.0)
    middle = np.abs(profiles.s_mm - 6) < 2
    assert not stent.any() and calcium[middle].mean() > 0.8 * degrees / 360
    radius, _ = edges.find_edges(profiles, "psf_edge", 400.0, np.hypot(SIGMA, 0.4 / np.sqrt(12)))
    area = np.mean(radius[middle] ** 2) / 1.6**2
    assert 0.8 < area < 1.1


def test_only_a_vessel_called_stented_has_a_stent():
    profiles = profiles_of(calcified_image(360, 0.0))
    assert edges.find_calcium_and_stents(profiles, 400.0, stented=True)[2].any()
    assert not edges.find_calcium_and_stents(profiles, 400.0)[2].any()


@pytest.mark.parametrize("noise", [25, 80])
def test_noise_is_no_calcium(noise):
    profiles = profiles_of(calcified_image(0, 0.3, noise=noise))
    assert edges.find_calcium_and_stents(profiles, 400.0)[0].mean() < 0.01


def test_noise_is_measured_beside_a_slow_fall_of_the_blood():
    profiles = profiles_of(calcified_image(0, 0.3, noise=0))
    profiles.hu += 10 * np.random.default_rng(4).normal(size=profiles.hu.shape)
    slow = 5 * (profiles.s_mm - 6)
    profiles.hu += slow[:, None, None]
    profiles.axis_hu += slow
    assert edges.noise_hu(profiles.hu, profiles, 400.0) == pytest.approx(10, rel=0.1)


def test_noise_is_not_the_blur_of_a_long_narrow_lumen():
    profiles = profiles_of(calcified_image(0, 0.3, noise=0))
    depth = 0.14 * (1 - ((profiles.s_mm - 6) / 8) ** 2)  # share of the blood's HU that the axis loses
    narrow = 1 - depth[:, None] * (1 + profiles.r_mm / 0.4)[None]
    profiles.hu = 10 * np.random.default_rng(4).normal(size=profiles.hu.shape) + 400 * narrow[:, None]
    profiles.axis_hu = 400 * narrow[:, 0]
    assert edges.noise_hu(profiles.hu, profiles, 400.0) == pytest.approx(10, rel=0.25)
    assert edges.unevenness_hu(profiles.hu, profiles, 400.0) > 15


@pytest.mark.parametrize(
    "radius, gap, thick, hu", [(1.6, 0.3, 0.75, 1000), (0.8, 0.0, 1.0, 900), (1.2, 0.6, 0.5, 1300)]
)
def test_the_edge_inside_calcium_is_fitted(radius, gap, thick, hu):
    r = np.arange(0, 4, 0.05)
    stone = stented.blurred_disc(r, radius + gap + thick, SIGMA) - stented.blurred_disc(r, radius + gap, SIGMA)
    rays = 50 + 350 * stented.blurred_disc(r, radius, SIGMA) + (hu - 50) * stone
    many = np.repeat(rays[None], calcified.RAYS_PER_BATCH + 3, axis=0)
    assert calcified.fit(many, r, 400.0, 50.0, SIGMA) == pytest.approx(radius, abs=0.051)
    assert len(calcified.fit(many[:0], r, 400.0, 50.0, SIGMA)) == 0


@pytest.mark.parametrize("metal", [0.0, 150.0, 400.0])
def test_shell_fit_finds_the_wall_behind_metal(metal):
    r = np.arange(0, 4, 0.05)
    true = np.array([[1.4, 1.55, 1.83]])
    ring = [stented.blurred_ring(r, radius - stented.STRUT_CENTRE_MM, SIGMA) for radius in true[0]]
    blood = [50 + 350 * stented.blurred_disc(r, radius, SIGMA) for radius in true[0]]
    hu = np.stack(blood)[None] + metal * np.stack(ring)[None]
    found = stented.fit(hu, r, 400.0, 50.0, SIGMA, 2.4)
    assert np.allclose(found, true, atol=0.004 if metal else 0.02)  # without metal, M >= 0 leaves a kink in the error
    # Without the metal in the model the same rays would be read too wide.
    clipped = edges.first_fall(np.minimum(hu, 460), r, np.full((1, 3), 225.0))
    assert (clipped - true).min() > (0.1 if metal else -0.05)


def test_disc_and_shell_are_blurred_discs_and_rings():
    n, h, radius, at = 601, 0.01, 0.9, 1.1
    x = h * (np.arange(n) - n // 2)
    distance = np.hypot(x[:, None], x[None])
    weight = np.exp(-0.5 * (np.hypot(x[:, None] - at, x[None]) / SIGMA) ** 2) * h * h / (2 * np.pi * SIGMA**2)
    assert stented.blurred_disc(at, radius, SIGMA) == pytest.approx((weight * (distance < radius)).sum(), abs=0.003)
    ring = (np.abs(distance - radius) < 0.03) / 0.06
    expected = (weight * ring).sum() * np.sqrt(2 * np.pi) * SIGMA
    assert stented.blurred_ring(at, radius, SIGMA) == pytest.approx(expected, rel=0.02)

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt
from scipy.special import ndtr

from common import vtp
from common.documents import config, schema
from common.errors import InputError
from common.patient.plaque_types import CALCIFIED, FIBROUS, LIPID, NONE
from common.documents.yaml_reader import read
from data_synthetic.ct import phantom, vessel


@pytest.fixture(scope="module")
def wide(ct_tubes):
    """A tube of radius 3 mm, its direction, and its noise-free volume."""
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 3.0), length_mm=8.0, around=96)
    settings = ct_tubes.settings(voxel_mm=[0.35, 0.4, 0.5], margin_mm=4)["phantom"]
    found = vessel.from_surface(poly, "tube")
    return found, direction, settings, phantom.render(found, settings)


def distances(volume, direction):
    """(distance from the tube's axis, height along it) of all voxels."""
    centres = np.stack(np.meshgrid(*[volume.centres(k) for k in range(3)], indexing="ij"), axis=-1)
    height = centres @ direction
    return np.linalg.norm(centres - height[..., None] * direction, axis=-1), height


def test_mean_hu_of_blood_and_fat(wide):
    _, direction, _, volume = wide
    radius, height = distances(volume, direction)
    body = (height > 0) & (height < 8)
    assert volume.values[body & (radius < 2.0)].mean() == pytest.approx(400, abs=0.5)
    assert volume.values[body & (radius > 5.0)].mean() == pytest.approx(-80, abs=0.5)


def test_ends_run_on_without_a_seam(wide):
    _, direction, _, volume = wide
    radius, height = distances(volume, direction)
    for low, high in ((-2.5, 0.5), (7.5, 10.5)):
        core = volume.values[(radius < 1.8) & (height > low) & (height < high)]
        assert core.min() > 399


@pytest.mark.parametrize("fwhm", [0.5, 0.7, 1.1])
def test_blur_has_the_asked_width(fwhm):
    """A half space through blur_matrix: the edge is the error function of sigma^2 + voxel^2 / 12."""
    voxel, factor, count = 0.35, 4, 60
    sigma = fwhm / np.sqrt(8 * np.log(2))
    samples = (np.arange(count * factor) + 0.5) / factor * voxel
    found = phantom.blur_matrix(count, voxel, sigma, factor) @ (samples > 10.0)
    centres = (np.arange(count) + 0.5) * voxel
    inner = (centres > 4) & (centres < 16)
    # The edge of the samples lies midway between two of them, up to half a sample from 10 mm.
    edge = samples[samples > 10.0][0] - 0.5 * voxel / factor
    expected = ndtr((centres - edge) / np.sqrt(sigma**2 + voxel**2 / 12))
    assert np.abs(found - expected)[inner].max() < 0.004
    wrong = ndtr((centres - edge) / np.sqrt((1.1 * sigma) ** 2 + voxel**2 / 12))
    assert np.abs(found - wrong)[inner].max() > 0.01


def test_edge_lies_where_the_lumen_ends(wide):
    """At the tube's radius the HU are midway between blood and wall; wall, fat and curvature shift them little."""
    _, direction, settings, volume = wide
    at = volume.interpolator()
    u = np.cross(direction, [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    v = np.cross(direction, u)
    theta = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    rays = np.cos(theta)[:, None] * u + np.sin(theta)[:, None] * v
    profile = at(4.0 * direction + rays * 3.0).mean()
    assert profile == pytest.approx(225, abs=12)  # 12 HU are 0.02 mm


def test_tissue_behind_the_wall():
    settings = config.load_section(None, "ct")["phantom"]
    depth = np.array([0.1, 0.6, 0.9, 1.8, 0.1, 0.1, 0.6])
    plaque = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0])
    fibrous, lipid, calcified, none = FIBROUS, LIPID, CALCIFIED, NONE
    kind = np.array([fibrous, lipid, calcified, fibrous, calcified, none, none])
    assert phantom.tissue_hu(depth, plaque, kind, settings).tolist() == [90, 30, 900, -80, 90, 50, 50]


def test_noise_is_as_asked_and_repeats(wide):
    _, _, settings, clean = wide
    noisy = phantom.add_noise(clean, settings)
    difference = noisy.values - clean.values
    assert difference.std() == pytest.approx(25, rel=0.01) and abs(difference.mean()) < 0.3
    assert abs(np.corrcoef(difference[1:].ravel(), difference[:-1].ravel())[0, 1]) < 0.01
    assert np.array_equal(noisy.values, phantom.add_noise(clean, settings).values)
    other = phantom.add_noise(clean, dict(settings, seed=2))
    assert not np.array_equal(noisy.values, other.values)


def test_correlated_noise_keeps_its_deviation(wide):
    _, _, settings, clean = wide
    noisy = phantom.add_noise(clean, dict(settings, noise_correlation_mm=1.0))
    difference = noisy.values - clean.values
    assert difference.std() == pytest.approx(25, rel=0.01)
    # Noise filtered with a Gaussian of width sigma: neighbours h apart correlate by exp(-h^2 / (4 sigma^2)).
    sigma = phantom.SIGMA_PER_FWHM
    expected = np.exp(-(0.35**2) / (4 * sigma**2))
    assert np.corrcoef(difference[1:].ravel(), difference[:-1].ravel())[0, 1] == pytest.approx(expected, abs=0.03)


def test_metal_adds_its_mass(wide):
    found, direction, settings, clean = wide
    points = 4.0 * direction + np.linspace(-0.5, 0.5, 101)[:, None] * [1.0, 0.0, 0.0]
    volume = np.full(101, 1.0 / 101 * 0.0064)
    shiny = phantom.render(found, settings, (points, volume))
    added = (shiny.values - clean.values).sum() * np.prod(settings["voxel_mm"])
    assert added == pytest.approx(0.0064 * (25000 - 400), rel=0.01)


def test_too_many_voxels_are_refused_with_their_key(wide):
    found, _, settings, _ = wide
    with pytest.raises(InputError, match="voxel_mm"):
        phantom.voxel_grid(found, dict(settings, margin_mm=400))


@pytest.mark.parametrize(
    "text, key",
    [
        ("phantom: {voxel_mm: [0.35, 0.35, 0.05]}", "phantom.voxel_mm[3]"),
        ("phantom: {noise_hu: -1}", "phantom.noise_hu"),
        ("phantom: {seed: 1.5}", "phantom.seed"),
        ("phantom: {hu: {blood: 4000}}", "phantom.hu.blood"),
        ("segmentation: {method: magic}", "segmentation.method"),
        ("segmentation: {psf_fwhm_mm: wide}", "segmentation.psf_fwhm_mm"),
        ("segmentation: {rays: 3}", "segmentation.rays"),
    ],
)
def test_bad_settings_are_refused_with_their_key(tmp_path, text, key):
    path = tmp_path / "ct.yaml"
    path.write_text(text + "\n")
    with pytest.raises(InputError) as caught:
        config.load_section(path, "ct")
    assert caught.value.where.endswith(f", key {key}")


def test_defaults_satisfy_the_schema(tmp_path):
    rules = schema.read("ct")
    path = tmp_path / "empty.yaml"
    path.write_text("phantom: {}\n")
    document = read(path)
    document.data = schema.with_defaults({}, rules)
    schema.validate(document, rules)


def test_an_open_surface_is_refused(ct_tubes):
    poly, _ = ct_tubes.tube(lambda z: np.full(len(z), 1.5))
    points, triangles = vtp.points_and_triangles(poly)
    with pytest.raises(InputError, match="not closed"):
        vessel.from_surface(vtp.surface(points, triangles[:-1]), "tube")


def test_a_surface_inside_out_is_turned(ct_tubes):
    """If it were not turned, its ends would be extended inwards."""
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 1.5))
    points, triangles = vtp.points_and_triangles(poly)
    found = vessel.from_surface(vtp.surface(points, triangles[:, ::-1]), "tube")
    height = np.concatenate([piece @ direction for piece, _ in found.pieces])
    assert height.max() - height.min() == pytest.approx(14 + 2 * vessel.EXTENSION_MM, abs=1e-6)


def test_a_surface_with_a_point_at_no_place_is_refused(ct_tubes):
    poly, _ = ct_tubes.tube(lambda z: np.full(len(z), 1.5))
    points, triangles = vtp.points_and_triangles(poly)
    with pytest.raises(InputError, match="not finite"):
        vessel.from_surface(vtp.surface(np.where(points > 1, np.nan, points), triangles), "tube")


def test_flat_ends_are_found_and_run_on(ct_tubes):
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 1.5))
    found = vessel.from_surface(poly, "tube")
    assert len(found.pieces) == 3
    height = np.concatenate([points @ direction for points, _ in found.pieces])
    assert height.min() == pytest.approx(-vessel.EXTENSION_MM, abs=1e-6)
    assert height.max() == pytest.approx(14 + vessel.EXTENSION_MM, abs=1e-6)


def test_opened_plaque_keeps_its_area(ct_tubes):
    poly, direction = ct_tubes.tube(lambda z: np.full(len(z), 1.5))
    points, _ = vtp.points_and_triangles(poly)
    height = points @ direction
    outward = points - height[:, None] * direction
    outward /= np.maximum(np.linalg.norm(outward, axis=1), 1e-9)[:, None]
    fields = {
        "plaque_thickness_mm": np.full(len(points), 1.0),
        "plaque_type": np.full(len(points), FIBROUS, np.int32),
        "radius_mm": np.full(len(points), 0.7),
        "displacement_mm": 0.8 * outward,
    }
    for name, values in fields.items():
        vtp.add_array(poly.GetPointData(), name, values)
    found = vessel.from_surface(poly, "tube")
    middle = np.abs(found.tissue_points_mm @ direction - 7) < 4
    after = (1.5 + found.plaque_mm[middle]) ** 2 - 1.5**2
    assert np.allclose(after, 1.7**2 - 0.7**2, rtol=0.02)


def test_wall_has_its_thickness(wide):
    """The lumen has a radius of 3 mm, and fat begins one wall thickness of 0.7 mm outside it."""
    found, direction, settings, _ = wide
    sharp = phantom.render(found, dict(settings, psf_fwhm_mm=0.2, voxel_mm=[0.25] * 3))
    radius, height = distances(sharp, direction)
    body = (height > 2) & (height < 6)
    fat = body & (sharp.values < -15) & (radius < 6)
    assert radius[fat].min() == pytest.approx(3.7, abs=0.15)
    assert distance_transform_edt(sharp.values > 225, sampling=sharp.spacing_mm).max() == pytest.approx(3.0, abs=0.15)

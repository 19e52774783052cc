"""Renders the CT volume of a known lumen, with partial-volume effect (by supersampling), point spread and noise."""

import sys

import numpy as np
import vtk
from scipy.ndimage import gaussian_filter
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from scipy.special import erf
from vtk.util.numpy_support import vtk_to_numpy

from common import vtp
from common.errors import InputError
from common.patient.plaque_types import CALCIFIED, LIPID
from common.volume import SIGMA_PER_FWHM, Image

SLAB_LAYERS = 8  # number of voxel layers rendered at once, to limit the memory
TISSUE_SAMPLES = 2  # samples of wall and plaque along a voxel's edge; the bright lumen needs more (supersampling)
MOST_VOXELS = 60e6


def voxel_grid(vessel, settings):
    """(centre (3,) in mm of the first voxel, number of voxels (3,)) of a volume round all pieces of a Vessel.

    settings: the section `phantom`. Raises InputError for more than MOST_VOXELS.
    """
    voxel, margin = np.array(settings["voxel_mm"]), settings["margin_mm"]
    points = np.concatenate([p for p, _ in vessel.pieces])
    low = np.floor((points.min(axis=0) - margin) / voxel) * voxel
    shape = np.ceil((points.max(axis=0) + margin - low) / voxel).astype(int) + 1
    if np.prod(shape.astype(float)) > MOST_VOXELS:
        raise InputError(
            "the volume has too many voxels", "ct.phantom.voxel_mm", list(shape), f"at most {MOST_VOXELS:.0f} in all"
        )
    return np.round(low, 6), shape


def blur_matrix(count, voxel_mm, sigma_mm, factor):
    """Sparse matrix (count, count * factor) that turns samples along one axis into the voxels of the blurred image.

    factor: number of samples in a voxel. A sample's weight is the Gaussian point spread, averaged over the voxel, at
    the sample's distance from the voxel. The weights of a voxel sum to 1 unless the volume's edge cuts some off.
    """
    reach = int(np.ceil((4 * sigma_mm / voxel_mm + 0.5) * factor)) + 1
    offset = np.arange(-reach, reach + 1)
    # Samples sit at (j + 0.5) / factor voxels from the voxel's lower face.
    inside = np.arange(count)[:, None] * factor + factor // 2 + offset[None]
    distance = ((inside + 0.5) / factor - np.arange(count)[:, None] - 0.5) * voxel_mm
    edge = np.sqrt(2) * sigma_mm
    weight = erf((distance + 0.5 * voxel_mm) / edge) - erf((distance - 0.5 * voxel_mm) / edge)
    weight /= weight.sum(axis=1, keepdims=True)
    keep = (inside >= 0) & (inside < count * factor)
    rows = np.broadcast_to(np.arange(count)[:, None], inside.shape)
    return csr_matrix((weight[keep], (rows[keep], inside[keep])), shape=(count, count * factor))


def _inside_mask(poly, origin, spacing, shape):
    """Whether each sample of a regular grid (shape) lies inside the closed surface `poly`: array of bool."""
    cut = vtk.vtkPolyDataToImageStencil()
    cut.SetInputData(poly)
    cut.SetOutputOrigin(*origin)
    cut.SetOutputSpacing(*spacing)
    cut.SetOutputWholeExtent(0, shape[0] - 1, 0, shape[1] - 1, 0, shape[2] - 1)
    to_image = vtk.vtkImageStencilToImage()
    to_image.SetInputConnection(cut.GetOutputPort())
    to_image.SetInsideValue(1)
    to_image.SetOutsideValue(0)
    to_image.SetOutputScalarTypeToUnsignedChar()
    to_image.Update()
    return vtk_to_numpy(to_image.GetOutput().GetPointData().GetScalars()).reshape(shape, order="F").astype(bool)


def tissue_hu(depth_mm, plaque_mm, plaque_type, settings):
    """HU at `depth_mm` behind the lumen's wall. From the lumen outwards there are plaque, healthy wall and fat.

    Calcium is in the outer half of its plaque. depth_mm, plaque_mm, plaque_type: arrays of one shape.
    """
    hu = settings["hu"]
    calcified = (plaque_type == CALCIFIED) & (depth_mm > 0.5 * plaque_mm)
    plaque = np.where(calcified, hu["calcium"], np.where(plaque_type == LIPID, hu["lipid"], hu["fibrous"]))
    outside = np.where(depth_mm < plaque_mm + settings["wall_thickness_mm"], hu["wall"], hu["fat"])
    return np.where(depth_mm < plaque_mm, plaque, outside).astype(np.float32)


def render(vessel, settings, metal=None):
    """Noise-free Image (float HU) of a Vessel.

    metal: (points (n, 3) mm, volumes (n,) mm3) of pieces of stent struts, or None.
    """
    origin, shape = voxel_grid(vessel, settings)
    voxel, factor, fat = np.array(settings["voxel_mm"]), settings["supersampling"], settings["hu"]["fat"]
    sample_mm = voxel / factor
    sigma = settings["psf_fwhm_mm"] * SIGMA_PER_FWHM
    blur = [blur_matrix(n, v, sigma, factor) for n, v in zip(shape, voxel)]
    pieces = [(vtp.surface(*piece), piece[0].min(axis=0), piece[0].max(axis=0)) for piece in vessel.pieces]
    tree, reach = cKDTree(vessel.tissue_points_mm), vessel.plaque_mm.max() + settings["wall_thickness_mm"]
    planes = np.zeros((shape[0], shape[1], shape[2] * factor), np.float32)
    for first in range(0, shape[2], SLAB_LAYERS):
        layers = min(SLAB_LAYERS, shape[2] - first)
        start, counts = _slab_window(pieces, origin, voxel, shape, reach, first, layers)
        if counts is None:
            continue
        corner = origin + (start - 0.5) * voxel
        inside = np.zeros(counts * factor, bool)
        top = corner + counts * voxel
        for poly, low, high in pieces:
            if np.all(high > corner) and np.all(low < top):
                inside |= _inside_mask(poly, corner + 0.5 * sample_mm, sample_mm, counts * factor)
        slab = _tissue_values(tree, vessel, settings, reach, corner, inside)
        slab[inside] = settings["hu"]["blood"] - fat
        if metal is not None:
            _add_metal(slab, metal, settings, corner, sample_mm)
        along_x, along_y = (blur[k][:, factor * start[k] : factor * (start[k] + counts[k])] for k in (0, 1))
        flat = (along_x @ slab.reshape(len(slab), -1)).reshape(shape[0], counts[1] * factor, -1)
        flat = np.moveaxis(flat, 1, 0).reshape(counts[1] * factor, -1)
        flat = (along_y @ flat).reshape(shape[1], shape[0], -1)
        planes[:, :, first * factor : (first + layers) * factor] = np.moveaxis(flat, 0, 1)
        print(f"rendered {first + layers} of {shape[2]} layers", file=sys.stderr)
    values = (blur[2] @ planes.reshape(-1, planes.shape[2]).T).T.reshape(shape) + fat
    return Image(values.astype(np.float32), origin, voxel)


def _slab_window(pieces, origin, voxel, shape, reach, first, layers):
    """(first voxel (3,), number of voxels (3,)) of the part of a slab that the vessel and its wall can touch.

    (None, None) if they cannot touch the slab.
    """
    low_z, high_z = origin[2] + (np.array([first, first + layers]) - 0.5) * voxel[2]
    low, high = [], []
    for poly, piece_low, piece_high in pieces:
        if piece_low[2] - reach < high_z and piece_high[2] + reach > low_z:
            points = vtk_to_numpy(poly.GetPoints().GetData())
            near = (points[:, 2] > low_z - reach - 1) & (points[:, 2] < high_z + reach + 1)
            # The first piece is the lumen, whose points are dense. The prisms that extend its ends have points at their
            # two ends only. A prism may cross the slab without a point in it, so its whole box is taken.
            low.append(points[near].min(axis=0) if poly is pieces[0][0] and near.any() else piece_low)
            high.append(points[near].max(axis=0) if poly is pieces[0][0] and near.any() else piece_high)
    if not low:
        return None, None
    begin = np.floor((np.min(low, axis=0) - reach - origin) / voxel).astype(int) - 1
    end = np.ceil((np.max(high, axis=0) + reach - origin) / voxel).astype(int) + 2
    begin, end = np.maximum(begin, 0), np.minimum(end, shape)
    begin[2], end[2] = first, first + layers
    return begin, end - begin


def _tissue_values(tree, vessel, settings, reach, corner, inside):
    """HU of plaque and wall, minus that of fat, at each sample of a slab.

    Samples inside the lumen are undefined. inside: bool array of the slab's samples; the result has its shape. tree:
    cKDTree of vessel.tissue_points_mm. reach: depth in mm of plaque and wall. corner (3,): lower corner of the slab in
    mm.
    """
    counts = np.array(inside.shape) // settings["supersampling"]
    factor, voxel = settings["supersampling"], np.array(settings["voxel_mm"])
    samples = min(TISSUE_SAMPLES, factor)
    values = np.zeros(inside.shape, np.float32)
    axes = [corner[k] + (np.arange(counts[k]) + 0.5) * voxel[k] for k in range(3)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    blocks = inside.reshape(counts[0], factor, counts[1], factor, counts[2], factor)
    outside = np.flatnonzero(~blocks.all(axis=(1, 3, 5)))
    limit = reach + np.linalg.norm(voxel)
    near = outside[np.isfinite(tree.query(centres[outside], eps=0.2, distance_upper_bound=limit)[0])]
    if len(near) == 0:
        return values
    steps = (np.stack(np.meshgrid(*[np.arange(samples)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5) / samples
    offsets = (steps - 0.5) * voxel
    distance, index = tree.query((centres[near][:, None] + offsets[None]).reshape(-1, 3))
    hu = tissue_hu(distance, vessel.plaque_mm[index], vessel.plaque_type[index], settings) - settings["hu"]["fat"]
    hu = hu.reshape((len(near),) + (samples,) * 3)
    # Tissue is sampled more coarsely than the lumen. Each fine sample takes the value of the tissue sample that it lies
    # in.
    tissue_sample = np.minimum(np.arange(factor) * samples // factor, samples - 1)
    blocks = values.reshape(counts[0], factor, counts[1], factor, counts[2], factor)
    i, j, k = np.unravel_index(near, counts)
    blocks.transpose(0, 2, 4, 1, 3, 5)[i, j, k] = hu[:, tissue_sample][:, :, tissue_sample][:, :, :, tissue_sample]
    return values


def _add_metal(slab, metal, settings, corner, sample_mm):
    """Mixes the CT number of metal into each sample of `slab`, by the share of its volume that struts fill.

    metal: as for `render`. corner (3,), sample_mm (3,): lower corner of the slab and edges of a sample, in mm.
    """
    points, volumes = metal
    indices = np.floor((points - corner) / sample_mm).astype(int)
    keep = np.all((indices >= 0) & (indices < slab.shape), axis=1)
    cells, inverse = np.unique(indices[keep], axis=0, return_inverse=True)
    share = np.bincount(inverse.ravel(), volumes[keep]) / np.prod(sample_mm)
    i, j, k = cells.T
    slab[i, j, k] += share * (settings["hu"]["metal"] - settings["hu"]["fat"] - slab[i, j, k])


def add_noise(image, settings):
    """The image with Gaussian noise, white or correlated.

    settings: the section `phantom`, with the noise's standard deviation and seed.
    """
    noise = np.random.default_rng(settings["seed"]).standard_normal(image.values.shape, dtype=np.float32)
    if settings["noise_correlation_mm"] > 0:
        noise = gaussian_filter(noise, settings["noise_correlation_mm"] * SIGMA_PER_FWHM / image.spacing_mm)
        noise /= noise.std()
    return Image(image.values + np.float32(settings["noise_hu"]) * noise, image.origin_mm, image.spacing_mm)

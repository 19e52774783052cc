"""Images of a straight vessel along z, computed by the formula of a blurred disc."""

import numpy as np

from anatomy.ct.rays.stented import blurred_disc
from common.documents import config
from common.volume import Image

LENGTH_MM, RADIUS_MM, SIGMA_MM = 40.0, 1.6, 0.315


def image(blood=400.0, falls=0.0, wall=50.0, fat=-80.0, noise=20.0, voxel=0.4, narrow_mm=None):
    """Image of a vessel with a wall of 0.7 mm in fat. The CT number of its blood falls by `falls` HU over the 40 mm.

    narrow_mm: radius between 6 and 34 mm along the vessel; None: the same as elsewhere.
    """
    rng, side = np.random.default_rng(4), 0.5 * voxel * 31
    x = np.arange(32) * voxel - side
    z = np.arange(-4, LENGTH_MM + 4, voxel)
    r = np.hypot(*np.meshgrid(x, x, indexing="ij"))
    lumen, outer = (blurred_disc(r, radius, SIGMA_MM)[..., None] for radius in (RADIUS_MM, RADIUS_MM + 0.7))
    if narrow_mm is not None:
        lumen = np.where((z > 6) & (z < 34), blurred_disc(r, narrow_mm, SIGMA_MM)[..., None], lumen)
    level = blood - falls * np.clip(z, 0, LENGTH_MM) / LENGTH_MM
    values = fat + (wall - fat) * outer + (level - wall) * lumen
    values = values + rng.normal(0, noise, values.shape)
    return Image(np.rint(values).astype(np.float32), np.array([-side, -side, z[0]]), np.full(3, voxel))


def ends(reverse=False):
    """The two end points, the inlet first."""
    points = [np.array([0.0, 0.0, z]) for z in (0.5, LENGTH_MM - 0.5)]
    return list(zip(("inlet", "outlet1"), points[::-1] if reverse else points))


def settings(**changes):
    """The settings of the segmentation: the defaults, with `changes`."""
    return config.load_section(None, "ct")["segmentation"] | changes

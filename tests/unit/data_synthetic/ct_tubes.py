"""A straight tube as phantom and as image, for the CT tests."""

import numpy as np

from common import vtp
from common.documents import config
from common import volume as image


def settings(**changes):
    """Section `ct` with the phantom's keys replaced."""
    found = config.load_section(None, "ct")
    found["phantom"].update(changes)
    return found


def tube(radius_of_z, length_mm=14.0, around=48, step_mm=0.2, tilt=(0.31, 0.17)):
    """vtkPolyData: closed tube along a tilted z with radius_of_z(z (n,)) and flat, finely meshed ends.

    Returns (poly, axis point of z, unit direction).
    """
    direction = np.array([tilt[0], tilt[1], 1.0])
    direction /= np.linalg.norm(direction)
    u = np.cross(direction, [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    v = np.cross(direction, u)
    rows = int(round(length_mm / step_mm)) + 1
    z = np.linspace(0, length_mm, rows)
    r = radius_of_z(z)
    theta = np.linspace(0, 2 * np.pi, around, endpoint=False)
    ring = np.cos(theta)[:, None] * u + np.sin(theta)[:, None] * v
    points = (z[:, None] * direction)[:, None] + r[:, None, None] * ring[None]
    index = np.arange(rows * around).reshape(rows, around)
    a, b = index[:-1], np.roll(index[:-1], -1, axis=1)
    c, d = index[1:], np.roll(index[1:], -1, axis=1)
    wall = np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    points = np.concatenate([points.reshape(-1, 3), [0 * direction, length_mm * direction]])
    first, last = len(points) - 2, len(points) - 1
    start = np.stack([np.full(around, first), np.roll(index[0], -1), index[0]], -1)
    stop = np.stack([np.full(around, last), index[-1], np.roll(index[-1], -1)], -1)
    return vtp.surface(points, np.concatenate([wall, start, stop])), direction


def tube_image(radius_mm, voxel_mm, sigma_mm, blood=400.0, tissue=50.0, shape=(40, 40, 60)):
    """Noise-free Image of a straight cylinder along z, blurred exactly in the plane (no wall, endless)."""
    from scipy.special import chndtr

    spacing = np.full(3, voxel_mm)
    origin = -0.5 * voxel_mm * (np.array(shape) - 1)
    x, y = (origin[k] + voxel_mm * np.arange(shape[k]) for k in (0, 1))
    r = np.hypot(x[:, None] - 0.07, y[None] + 0.11)
    share = chndtr((radius_mm / sigma_mm) ** 2, 2, (r / sigma_mm) ** 2)
    values = np.repeat((tissue + (blood - tissue) * share)[..., None], shape[2], axis=2)
    return image.Image(values, origin, spacing)

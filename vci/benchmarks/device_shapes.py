"""Rings of the devices that `vci deploy` writes, and diameters along a balloon or stent."""

import numpy as np

from common import vtp


def ring_vertices(path):
    """Vertices (rings, vertices round a ring, 3) in mm of a device's .vtp file.

    An open tube of r rings with n vertices each has r n vertices and 2 (r - 1) n triangles, which gives n.
    """
    poly = vtp.read(path, "run vci deploy again")
    points = vtp.points(poly)
    return points.reshape(-1, len(points) - len(vtp.triangles(poly)) // 2, 3)


def ring_diameters(path):
    """(places (n,), diameters (n,)) in mm of the n rings of a device's .vtp file.

    Places are measured along the device from its middle. A diameter is that of the circumscribed circle of a regular
    polygon with the ring's perimeter.
    """
    rings = ring_vertices(path)
    centres = rings.mean(axis=1)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(centres, axis=0), axis=1))])
    chords = np.linalg.norm(rings - np.roll(rings, -1, axis=1), axis=2).sum(axis=1)
    half_angle = np.pi / rings.shape[1]
    return along - 0.5 * along[-1], chords / np.pi * half_angle / np.sin(half_angle)

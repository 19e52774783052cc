"""Rings of the devices that `vci deploy` writes: diameters along a balloon or stent."""

import numpy as np

from common import vtp


def rings(path):
    """Vertices (rings, around, 3) in mm of a device's open tube, from its numbers of vertices and triangles."""
    poly = vtp.read(path, "run vci deploy again")
    points = vtp.points(poly)
    return points.reshape(-1, len(points) - len(vtp.triangles(poly)) // 2, 3)


def diameters(path):
    """(places (n,) along the device from its middle, diameters (n,) by the rings' perimeters), in mm."""
    rows = rings(path)
    centres = rows.mean(axis=1)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(centres, axis=0), axis=1))])
    chords = np.linalg.norm(rows - np.roll(rows, -1, axis=1), axis=2).sum(axis=1)
    half_angle = np.pi / rows.shape[1]
    return along - 0.5 * along[-1], chords / np.pi * half_angle / np.sin(half_angle)

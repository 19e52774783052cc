"""Drawn outlines and the text of their tables."""

import numpy as np


def circle(radius, count=60, centre=(4.0, 5.0), start=0.3, turn=1):
    angle = start + turn * 2 * np.pi * np.arange(count) / count
    return np.column_stack([centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)])


def text(frames, separator=",", closed=True):
    """frames: {frame: (z, outline)}."""
    lines = []
    for name, (z, outline) in frames.items():
        points = np.vstack([outline, outline[:1]]) if closed else outline
        lines += [separator.join(map(str, (name, x, y, z))) for x, y in points]
    return "\n".join(lines) + "\n"


def tube(radii, spacing=1.0, **kwargs):
    return {10 * k + 3: (k * spacing, circle(radius, **kwargs)) for k, radius in enumerate(radii)}


def sector(inner, outer, first_deg, last_deg, centre=(4.0, 5.0)):
    angle = np.radians(np.linspace(first_deg, last_deg, 60))
    arc = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([inner * arc, outer * arc[::-1]]) + centre

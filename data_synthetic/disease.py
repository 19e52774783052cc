"""Lesions: by how much the plaque narrows the healthy lumen, and the plaque's type."""

import numpy as np

from common.patient.plaque_types import FIBROUS, LIPID

PLAQUE_TYPES = {"fibrous": FIBROUS, "lipid": LIPID}


def lesion_extent(lesion):
    """(start, end) of a lesion as arc lengths in mm."""
    half = 0.5 * lesion["length_mm"]
    return lesion["centre_s_mm"] - half, lesion["centre_s_mm"] + half


def _cosine_bump(x):
    return np.where(np.abs(x) < 1, 0.5 * (1 + np.cos(np.pi * np.clip(x, -1, 1))), 0.0)


def stenosis_profile(lesion, s_mm, phase_rad=0.0):
    """Share of the lesion's stenosis at arc lengths s_mm: about 1 where the lesion is tightest, 0 outside it.

    It is continuously differentiable. phase_rad: phase (rad) of the waves along a diffuse lesion.
    """
    x = (np.asarray(s_mm, float) - lesion["centre_s_mm"]) / (0.5 * lesion["length_mm"])
    if lesion["shape"] == "focal":
        return _cosine_bump(x)
    if lesion["shape"] == "tandem":
        return _cosine_bump((x + 0.55) / 0.45) + 0.9 * _cosine_bump((x - 0.55) / 0.45)
    edge = np.clip((1 - np.abs(x)) / 0.35, 0, 1)
    plateau = edge * edge * (3 - 2 * edge)
    waves = max(2, int(round(lesion["length_mm"] / 7)))
    return plateau * (0.86 + 0.14 * np.sin(np.pi * waves * x + phase_rad))


def calcium_share(lesion, s_mm, theta_rad):
    """Share (0 ... 1) of calcium in the outer half of the plaque at (s, theta), smooth over 0.5 mm and 10 degrees."""
    calcium = lesion.get("calcium")
    if calcium is None:
        return np.zeros(np.broadcast(s_mm, theta_rad).shape)
    along = 0.5 * calcium["length_mm"] - np.abs(np.asarray(s_mm, float) - lesion["centre_s_mm"])
    turn = np.angle(np.exp(1j * (np.asarray(theta_rad, float) - np.radians(calcium["direction_deg"]))))
    around = np.radians(0.5 * calcium["arc_deg"]) - np.abs(turn)
    return 0.25 * (1 + np.tanh(along / 0.5)) * (1 + np.tanh(around / np.radians(10)))

"""The figure of the stations: no label covers another one."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from reports.figures.stations import draw_sections

SIZE_MM = np.array([1.5, 0.8])


def _marks(spacing_mm):
    x = spacing_mm * np.arange(6.0)
    points = np.stack([x, 0 * x, 0 * x], 1)
    return {
        "points": points,
        "tangents": np.tile([1.0, 0.0, 0.0], (6, 1)),
        "area_mm2": np.full(6, 3.0),
        "distance_mm": x,
    }


@pytest.mark.parametrize("spacing_mm, moved", [(2.0, False), (0.7, True), (0.3, True)])
def test_labels_stand_apart_and_move_only_if_they_must(spacing_mm, moved):
    _, axes = plt.subplots()
    draw_sections(axes, _marks(spacing_mm), np.eye(3), "black", SIZE_MM)
    places = np.array([text.get_position() for text in axes.texts])
    apart = np.abs(places[:, None] - places[None, :])[~np.eye(6, dtype=bool)]
    assert np.all((apart >= SIZE_MM - 1e-12).any(axis=1))
    assert (np.ptp(places[:, 1]) > 0) == moved
    assert places[:, 0] == pytest.approx(spacing_mm * np.arange(6)), "labels move along their section's line"
    plt.close()

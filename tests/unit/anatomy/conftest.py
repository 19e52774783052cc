"""Fixtures: the device families, vessels with chosen narrowings as the anatomy measures them, and contour tables."""

import csv
import json

import pytest
from contour_tables import text
from narrowed_vessels import measured_vessel

from common.documents import config


@pytest.fixture(scope="module")
def families(repo_root):
    return config.load_devices(repo_root / "config" / "devices")


@pytest.fixture
def summary():
    return measured_vessel()[0]


@pytest.fixture
def vessel():
    """The function narrowed_vessels.measured_vessel."""
    return measured_vessel


@pytest.fixture
def written(tmp_path):
    """Function written(summary, sections) that makes a folder with anatomy.json and sections.csv, as `lumen process`
    does."""

    def write(summary, sections):
        folder = tmp_path / "anatomy"
        folder.mkdir()
        (folder / "anatomy.json").write_text(json.dumps(summary))
        numbers = dict.fromkeys("x_mm y_mm z_mm area_mm2 inscribed_radius_mm curvature_per_mm".split(), 0.0)
        table = [row | numbers for branch in sections.values() for row in branch]
        with (folder / "sections.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, list(table[0]))
            writer.writeheader()
            writer.writerows(table)
        return folder

    return write


@pytest.fixture
def table(tmp_path):
    """table(frames) writes a contour table of {frame: (z, outline)} and returns its path."""

    def write(frames, name="lumen.csv", **kwargs):
        path = tmp_path / name
        path.write_text(text(frames, **kwargs))
        return path

    return write

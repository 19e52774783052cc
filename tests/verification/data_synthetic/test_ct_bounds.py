"""Lumens segmented from the synthetic CT of virtual patients: bounds on their bias for two voxel sizes, with and
without a stent."""

import csv
import pathlib

import pytest

from data_synthetic.ct import study

pytestmark = pytest.mark.long

ROOT = pathlib.Path(__file__).resolve().parents[3]
CASES = [ROOT / f"tests/verification/data_synthetic/cases/{name}.yaml" for name in ("severe_focal", "severe_branch")]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    out = tmp_path_factory.mktemp("ct") / "ct_study.csv"
    study.run(CASES, [0.35, 0.5], 1, out, methods=("psf_edge", "threshold"))
    with open(out, newline="") as handle:
        return list(csv.DictReader(handle))


def matching_rows(rows, **wanted):
    found = [row for row in rows if all(row[key] == value for key, value in wanted.items())]
    assert len(found) == 2  # one per case
    return found


def test_every_lumen_is_found_whole(rows):
    assert len(rows) == 2 * 2 * 2 * 2  # cases, states, voxels, methods
    for row in rows:
        if row["method"] == "psf_edge":
            assert row["status"] == "ok" and row["lost_sections"] == "0"


def test_limits_of_agreement_without_a_stent(rows):
    for voxel, limit in (("0.35", 0.35), ("0.5", 0.6)):
        for row in matching_rows(rows, state="unstented", voxel_mm=voxel, method="psf_edge"):
            assert -limit < float(row["lower_limit_mm2"]) < float(row["upper_limit_mm2"]) < limit
            assert abs(float(row["mean_difference_mm2"])) < 0.12


def test_resistance_without_a_stent(rows):
    for voxel, low, high in (("0.35", 0.85, 1.15), ("0.5", 0.75, 1.25)):
        ratios = [
            float(r["resistance_ratio"])
            for r in matching_rows(rows, state="unstented", voxel_mm=voxel, method="psf_edge")
        ]
        assert low < min(ratios) and max(ratios) < high


def test_fixed_threshold_overstates_the_resistance(rows):
    """A fixed threshold is known to overstate the resistance. A realistic phantom must show this too."""
    ok = [r for r in matching_rows(rows, state="unstented", voxel_mm="0.35", method="threshold") if r["status"] == "ok"]
    assert ok and all(float(row["resistance_ratio"]) > 1.2 for row in ok)


def test_bloom_of_a_stent(rows):
    for row in matching_rows(rows, state="stented", voxel_mm="0.35", method="psf_edge"):
        assert abs(float(row["mean_difference_mm2"])) < 0.6
        assert "calcium_or_metal" in row["warnings"]
    for row in matching_rows(rows, state="stented", voxel_mm="0.35", method="threshold"):
        assert float(row["mean_difference_mm2"]) > 2

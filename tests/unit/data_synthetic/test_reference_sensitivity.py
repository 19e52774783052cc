"""The table of sensitivities, with slices whose area is a known function of the constants."""

import csv
import types

import numpy as np
import pytest

from common.errors import InputError
from data_synthetic.reference import run
from data_synthetic.reference.checks import sensitivity
from data_synthetic.reference.slices import slices
from data_synthetic.reference.straightening import stent_in_vessel
from data_synthetic.reference.treatment import devices


@pytest.fixture
def table(branches, monkeypatch, tmp_path):
    balloon = devices.Balloon("b", 13.0, 10.0, 1.5, 1.6, 20.0, 1.2)
    steps = [devices.Step("stent", "stent", balloon, devices.Stent("s", 8.0, 18.0, 0.955, 0.2, 20.0, 1.5, 0.5))]
    patient = types.SimpleNamespace(branch=branches[0], branches=branches, wall_mm=0.7)

    def solve(model, patient, steps, s_mm, settings, stented):
        return None, {"area_mm2": 8 * settings["stent_stiffness_mpa_per_mm"] ** 0.1 + s_mm}

    monkeypatch.setattr(run, "load_scene", lambda path: {})
    monkeypatch.setattr(run, "read_patient_and_steps", lambda *_: (patient, steps))
    monkeypatch.setattr(slices, "slice_model", lambda settings: None)
    monkeypatch.setattr(slices, "solve_slice", solve)
    law = stent_in_vessel.SidewaysLaw(*np.array([[0.0, 0.1], [0.0, 0.05], [0.0, 0.08]]), -0.1, 0.1)
    axis = branches[0].axis
    ends = np.array([0.0, axis.length_mm])
    sections = stent_in_vessel.VesselSections(ends, np.full(2, 8.0), np.full(2, 2.0), [(s, law) for s in ends])

    def solve_all(model, patient, steps, settings):
        bent = stent_in_vessel.straighten(axis, [steps[0].stent], sections, 0.08)
        return types.SimpleNamespace(straightening=bent, sections=sections, foundation_n_per_mm2=0.08)

    monkeypatch.setattr(sensitivity, "solve_lumen", solve_all)

    def made():
        sensitivity.write_sensitivity("scene", "truth", tmp_path)
        with open(tmp_path / "sensitivity.csv", newline="") as handle:
            return list(csv.DictReader(handle))

    made.steps = steps
    return made


def change(rows, quantity, constant, factor):
    (row,) = [r for r in rows if (r["quantity"], r["constant"], r["factor"]) == (quantity, constant, factor)]
    return float(row["change_percent"])


def test_each_constant_is_varied_alone(table):
    rows = table()
    base = 8 * 1.5**0.1 + 13
    for factor in ("0.5", "2"):
        expected = 100 * ((8 * (1.5 * float(factor)) ** 0.1 + 13) / base - 1)
        assert change(rows, "area_mm2", "stent_stiffness_mpa_per_mm", factor) == pytest.approx(expected, abs=1e-3)
        assert change(rows, "area_mm2", "wall_c10_mpa", factor) == 0
    assert {r["constant"] for r in rows if r["quantity"] == "area_mm2"} == {"none", *sensitivity.SLICE_CONSTANTS}


def test_what_resists_keeps_the_curvature_and_what_is_stiff_takes_it(table):
    rows = table()
    signs = {sensitivity.VESSEL: 1, sensitivity.CONTACT: -1, sensitivity.STENT_BENDING: -1}
    for constant, sign in signs.items():
        found = [change(rows, "curvature_per_mm", constant, f"{f:g}") for f in sensitivity.BEAM_FACTORS]
        assert np.all(np.diff(np.multiply(sign, found)) > 0), constant
        assert sign * found[0] < 0 < sign * found[-1]
    support = [change(rows, "curvature_per_mm", sensitivity.SUPPORT, factor) for factor in ("2", "4")]
    assert 0 < support[0] < support[1], "a very soft support lets the vessel swing, which is no straightening"
    assert change(rows, "curvature_per_mm", "no stent", "1") > 0


def test_a_plan_without_a_stent_is_refused(table):
    table.steps[0] = devices.Step("balloon", "predilatation", table.steps[0].balloon, None)
    with pytest.raises(InputError, match="no stent"):
        table()

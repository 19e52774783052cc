"""The error estimate: Richardson's on two meshes, the straight line to c = 0 on what a jet viscosity does."""

import types

import numpy as np
import pytest

from flow import error_estimate


def _solved(cells, mixing=0.0, passed=()):
    space = types.SimpleNamespace(nodes=lambda: (np.zeros((1, 3)), np.zeros((cells, 10), int)))
    problem = types.SimpleNamespace(mixing=mixing, passed=list(passed))
    return types.SimpleNamespace(space=space, problem=problem, sampler="coarse")


def test_second_order_error_is_found_exactly():
    exact, factor = 0.75, 0.04  # FFR = exact + factor h^2 with h = 1 and 1/2
    estimate = error_estimate.of(_solved(8000), _solved(1000), exact + factor / 4, lambda sampler: exact + factor)
    assert estimate["ffr"] == pytest.approx(factor / 4)


def test_meshes_of_the_same_size_say_nothing():
    assert error_estimate.of(_solved(1050), _solved(1000), 0.75, lambda sampler: 0.7) is None


def test_one_mesh_without_jet_viscosity_says_nothing():
    assert error_estimate.of(_solved(1000), None, 0.75, None) is None


def test_remaining_jet_viscosity_is_counted(monkeypatch):
    monkeypatch.setattr(error_estimate.locate, "FieldSampler", lambda space, values: values)
    fine = _solved(1000, 0.18, [(0.27, 0.76, 1e-6), (0.18, 0.75, 1e-6)])
    estimate = error_estimate.of(fine, None, 0.75, lambda sampler: sampler)
    assert estimate["ffr"] == pytest.approx(0.02)

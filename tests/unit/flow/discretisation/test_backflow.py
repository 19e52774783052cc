"""Backflow through an outlet brings no energy in. With the coefficient 1/2 the backflow term takes all the kinetic
energy that the flow carries in."""

import numpy as np
import pytest
import ufl
from dolfinx import fem

import tubes
from flow import settings
from flow.discretisation import compat, spaces
from flow.geometry import centreline
from flow.meshing import mesh
from flow.physics import viscosity
from flow.discretisation.forms import NavierStokes

LENGTH, RADIUS, DENSITY = 4.0, 1.2, 1060.0


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    """A short tube along x."""
    path = tmp_path_factory.mktemp("backflow") / "mesh.msh"
    tree = centreline.Tree([tubes.centre_branch(LENGTH, lambda s: RADIUS)])
    built, _ = mesh.build(tubes.tube(LENGTH, lambda s: RADIUS, 0.6), tree, 1.5, settings.make(), 2, 2.0)
    mesh.write(built, path)
    return spaces.read(path)


def _powers(space, speed, coefficient):
    """(kinetic power that leaves by the outlet, power of the backflow term) in W; speed(y in m): m/s along x."""
    state = fem.Function(space.W)
    state.sub(0).interpolate(lambda x: np.stack([speed(x[1]), 0 * x[0], 0 * x[0]]))
    forms = NavierStokes(space, state, DENSITY, viscosity.Newtonian(0.004), 0.2, coefficient)
    leaves = fem.assemble_scalar(compat.form(forms.kinetic_energy_flow(tuple(space.outlet_tags))))
    return leaves, fem.assemble_scalar(compat.form(ufl.action(forms.losses["backflow"], state)))


def test_inflow_brings_nothing(space):
    leaves, taken = _powers(space, lambda y: -0.3 + 50 * y, 0.5)  # inward everywhere: y is within 1.2e-3
    assert leaves < -1e-5
    assert leaves + taken == pytest.approx(0, abs=1e-9 * abs(leaves))


def test_outflow_is_not_touched(space):
    leaves, taken = _powers(space, lambda y: 0.3 + 50 * y, 0.5)
    assert leaves > 1e-5
    assert taken == 0


def test_with_less_of_the_term_energy_comes_in(space):
    leaves, taken = _powers(space, lambda y: -0.3 + 50 * y, 0.2)
    assert leaves + taken < -1e-5

"""The reference's solid in three dimensions: its mesh, and a uniform tube, which must move as the slice model does."""

import numpy as np
import pytest

from common.implicit.curves import Curve
from data_synthetic.reference.slices.model import SliceModel
from data_synthetic.reference.tube.mesh import Tube
from data_synthetic.reference.tube.model import TubeModel
from data_synthetic.reference.tube.procedure import enclosed_area

AROUND, THROUGH = 8, 3
SETTINGS = {"wall_c10_mpa": 0.05, "wall_c20_mpa": 0.2, "bulk_modulus_mpa": 20.0, "support_mpa_per_mm": 0.01}
INNER = 0.6


def straight(length_mm):
    s = np.linspace(0, length_mm, int(10 * length_mm) + 1)
    direction = np.array([0.6, 0.0, 0.8])
    return Curve(s[:, None] * direction)


def plaque(angle, radius):
    """Plaque up to the radius 1.4, three times as stiff on one side as on the other."""
    share = 0.5 * (1 - np.tanh((radius - 1.4) / 0.1))
    shear = 0.1 * (2 + np.cos(angle))
    return share, shear, np.full_like(radius, 0.1), np.full_like(radius, 0.2)


def outer_mm(theta):
    return 2.0 + 0.2 * np.cos(theta)


@pytest.fixture(scope="module")
def solid():
    axis = straight(2.0)
    theta = np.pi * np.arange(2 * AROUND) / AROUND
    stations = np.linspace(0, 2.0, 5)
    shape = (5, 1)
    tube = Tube(axis, stations, np.full((5, 2 * AROUND), INNER), np.tile(outer_mm(theta), shape), THROUGH)
    return TubeModel(tube, axis, lambda s, angle, radius: plaque(angle, radius), SETTINGS)


def steps(model):
    """Inflates a balloon to a radius of 1.3 mm, then replaces it by a stent of radius 1.25 mm."""
    model.set_loads({"balloon_stiffness": 3.0, "balloon_cap": 1.2, "balloon_radius": 0.55, "balloon_share": 1.0})
    for value in np.linspace(0.55, 1.3, 8)[1:]:
        model.advance({"balloon_radius": float(value)})
    if isinstance(model, TubeModel):
        model.set_stent_radius(np.full(5, 1.25))
    else:
        model.set_loads({"stent_radius": 1.25})
    model.set_loads({"stent_stiffness": 1.5, "stent_cap": 0.2})
    for share in (0.3, 0.6, 1.0):
        model.advance({"balloon_share": 1 - share, "stent_share": share})


@pytest.mark.slow
def test_a_uniform_tube_between_rollers_is_the_slice(solid):
    ring = SliceModel(AROUND, THROUGH, *(SETTINGS[f"wall_{c}_mpa"] for c in ("c10", "c20")), 20.0, 0.01)
    theta = ring.annulus.theta_rad
    ring.place(np.full(len(theta), INNER), outer_mm(theta), plaque)
    steps(ring)
    solid.set_loads({"balloon_centre": 1.0, "balloon_half_length": 5.0, "stent_start": -1.0, "stent_end": 3.0})
    steps(solid)
    nodes = solid.tube.lumen_nodes()
    moved = solid.displacement()[nodes]
    tangent, normal, binormal = straight(2.0).frame(0.0)
    in_plane = np.stack([moved @ normal, moved @ binormal], axis=-1)
    assert np.abs(moved @ tangent).max() < 1e-6
    # The lumen is quadratic between its nodes in the slice and at each station of the solid, so the nodes can agree.
    assert np.abs(in_plane - ring.lumen_displacement()[None]).max() < 1e-5
    assert np.linalg.norm(ring.lumen_displacement(), axis=1).min() > 0.5


def test_mesh_is_right_handed_and_fills_the_tube(solid):
    import ufl
    from dolfinx import fem

    mesh, tags = solid.tube.mesh, solid.tube.facet_tags
    volume = fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * ufl.dx(domain=mesh)))
    outer = np.pi * (2.0**2 + 0.5 * 0.2**2)
    # The eight quadratic arcs of the circumference miss 0.08 % of the area.
    assert volume == pytest.approx(2.0 * (outer - np.pi * INNER**2), rel=1.2e-3)
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)
    area = [fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * ds(tag))) for tag in (1, 3)]
    # The tube is 2 mm long, so the area of both ends together in mm2 equals its volume in mm3.
    assert area == pytest.approx([2 * np.pi * INNER * 2.0, volume], rel=2e-3)


def test_area_of_an_ellipse():
    theta = 2 * np.pi * np.arange(16) / 16
    assert enclosed_area(2 * np.cos(theta)[None], 0.5 + 1.5 * np.sin(theta)[None]) == pytest.approx(3 * np.pi)

"""Reduced models: 1D network, axisymmetric Navier-Stokes, the two coupled, and plans ranked by them."""

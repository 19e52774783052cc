"""Physics: weak form, viscosity, outlets, and quantities read from a flow (FFR, wall shear stress, energy).

A new outlet model goes into outlets.py; docs/extending.md lists the other places.

May import: common.*, flow.geometry.
"""

"""Reduced models: 1D network, axisymmetric Navier-Stokes, the two coupled, and plans ranked by them.

A new outlet model in flow/physics/outlets.py must be added to network.py too, since 3D answers are compared with those
of the network.

May import: common.*, flow.geometry, flow.physics, flow.inputs, flow.meshing.*, flow.discretisation, flow.solvers.
"""

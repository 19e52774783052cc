"""Reduced models: 1D network, axisymmetric Navier-Stokes, the two coupled, and plans ranked by them.

A new outlet model of flow/physics/outlets.py goes into network.py too, since 3D answers are compared with it.
"""

"""Discretisation: function spaces, forms, matrices, and what depends on the FEniCSx version.

May import: common.*, flow.geometry, flow.physics.
"""

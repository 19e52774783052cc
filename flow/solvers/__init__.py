"""Solvers: linear systems, Newton's method and its starting flows, steps in time.

May import: common.*, flow.geometry, flow.physics, flow.discretisation.
"""

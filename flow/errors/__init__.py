"""Errors: the discretisation error of FFR, estimated by the dual-weighted residual and by two meshes.

May import: common.*, flow.geometry, flow.physics, flow.discretisation.
"""

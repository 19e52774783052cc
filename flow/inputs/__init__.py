"""Inputs: boundary values of a patient, the anatomy summary that they follow from, and the flow of another state.

May import: common.*, flow.geometry, flow.physics.
"""

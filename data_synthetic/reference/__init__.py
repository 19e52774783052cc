"""Finite-element reference of the deployed lumen: slices in plane strain, and beams of stent and vessel.

May import: common.*, data_synthetic, data_synthetic.reference.solid, data_synthetic.reference.treatment,
data_synthetic.reference.surface, data_synthetic.reference.straightening, data_synthetic.reference.slices.
"""

"""Finite-element reference of the deployed lumen: slices in plane strain, and a beam that straightens the axis.

May import: common.*, data_synthetic, data_synthetic.reference.solid, data_synthetic.reference.treatment,
data_synthetic.reference.surface, data_synthetic.reference.slices.
"""

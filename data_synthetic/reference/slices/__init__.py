"""Cross-sections in plane strain: mesh, model, positions, solution, sideways pressure, lumen, and error estimate.

May import: common.*, data_synthetic.reference.solid, data_synthetic.reference.treatment,
data_synthetic.reference.straightening, data_synthetic.reference.surface.
"""

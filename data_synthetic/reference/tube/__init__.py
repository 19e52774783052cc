"""The branch as one solid in three dimensions: mesh, model, procedure.

Only the folder `checks` imports this one.

May import: common.*, data_synthetic.reference.solid, data_synthetic.reference.treatment,
data_synthetic.reference.straightening, data_synthetic.reference.slices.
"""

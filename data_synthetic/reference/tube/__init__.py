"""The branch as one solid in three dimensions: mesh, model, procedure.

It imports the folders `solid` and `treatment`, and `slices.slice_positions()`. Only the folder `checks` imports it.
"""

"""The branch as one solid in three dimensions: mesh, model, procedure.

It uses the packages `solid` and `treatment`, and `slices.slice_positions()`. Only the package `checks` imports it.
"""

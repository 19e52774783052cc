"""The branch as one solid in three dimensions: mesh, model, procedure.

It builds on solid, treatment and the slices' positions. Only the checks use it.
"""

"""Rigid registration of the lumen after a real procedure to the lumen before it, by their axes.

May import: common.*, anatomy.
"""

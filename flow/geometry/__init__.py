"""Geometry: the tagged surface, its centrelines, curved quadratic tetrahedra, and field values at points.

May import: common.*.
"""

"""Geometry: the tagged surface, its centrelines, quadratic tetrahedra and their curving, values at points."""

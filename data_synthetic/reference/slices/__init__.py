"""Cross-sections in plane strain: mesh, model, positions, solution, and error estimate.

The modules build on solid, treatment and surface.
"""

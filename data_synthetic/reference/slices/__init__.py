"""Cross-sections in plane strain: mesh, model, positions, solution, and error estimate.

The modules import from the folders solid, treatment and surface.
"""

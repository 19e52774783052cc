"""Cross-sections in plane strain: mesh, model, where they lie and how they are solved, and their own error.

They build on solid, treatment and surface.
"""

"""Meshing: volume meshes of a lumen, swept where its tree allows, filled by gmsh elsewhere."""

"""Meshing: volume meshes of a lumen, swept along single vessels, filled by gmsh at junctions.

May import: common.*, flow.geometry, flow.meshing.sweep.
"""

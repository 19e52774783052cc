"""Swept meshes of tubes: a triangulated disc, carried along the axis from section to section, gives prisms.

They are split into tetrahedra.

May import: common.*, flow.geometry.
"""

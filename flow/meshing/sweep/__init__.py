"""Swept meshes of tubes: a triangulated disc, carried along the axis from section to section, gives prisms, which are
split into tetrahedra."""

"""Swept meshes of tubes: a lattice of discs carried along the axis, split into tetrahedra."""

"""Errors: what the mesh has done to FFR, by the dual-weighted residual and by two meshes."""

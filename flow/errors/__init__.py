"""Errors: the discretisation error of FFR, estimated by the dual-weighted residual and by two meshes."""

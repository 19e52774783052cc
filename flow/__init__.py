"""Steady coronary flow: boundary values, curved tetrahedral mesh, Navier-Stokes, FFR, and its reduced models."""

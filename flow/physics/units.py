"""Factors between SI units and the units of files, settings and messages."""

M_PER_MM, MM_PER_M = 1e-3, 1e3
PA_PER_MMHG = 133.322
M3_PER_S_PER_ML_PER_MIN = 1e-6 / 60.0

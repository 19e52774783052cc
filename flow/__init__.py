"""Steady coronary flow: boundary values, curved tetrahedral mesh, Navier-Stokes, FFR, and its reduced models.

May import: common.*, flow.*.
"""

import common  # noqa: F401  chooses functions that round alike on every processor, before numpy is loaded

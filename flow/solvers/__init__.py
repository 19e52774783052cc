"""Solvers: linear systems, Newton's method and its starting flows, steps in time. They import no reduced model."""

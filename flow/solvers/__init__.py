"""Solvers: linear systems, Newton's method and the ways to its start. They import no reduced model."""

"""Discretisation: function spaces, forms, matrices, and what depends on the FEniCSx version."""

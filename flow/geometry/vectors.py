"""Vector operations with the same result to the last bit on every processor; mesh coordinates are computed by them.

numpy hands products of matrices (`@`, dot, the norm of one vector, det, inv) to OpenBLAS. For sines, cosines and powers
of arrays it has special routines for processors with AVX-512. Both round differently on different kinds of processor.
"""

import math

import numpy as np


def dot(a, b):
    """Scalar products along the last axis of two arrays (..., 3) or (..., 2) that broadcast."""
    return np.multiply(a, b).sum(axis=-1)


def length(vectors):
    """Lengths (...,) of vectors (..., 3) or (..., 2)."""
    return np.sqrt(dot(vectors, vectors))


def unit(vectors):
    """Unit vectors: vectors (..., 3) over their lengths."""
    return vectors / length(vectors)[..., None]


def cosines_and_sines(angles):
    """(cosines, sines) (n,) of angles (n,) in rad."""
    return np.array([math.cos(angle) for angle in angles]), np.array([math.sin(angle) for angle in angles])


def determinant(matrices):
    """Determinants (...,) of matrices (..., 3, 3)."""
    first, second, third = (matrices[..., k] for k in range(3))
    return dot(first, np.cross(second, third))

"""Flexible GMRES on arrays (Saad 1993, SIAM J Sci Comput 14:461): the preconditioner may differ from step to step."""

import dataclasses

import numpy as np


@dataclasses.dataclass
class Solution:
    """values (n,); iterations; residual: norm over that of the right side, as the method knows it."""

    values: np.ndarray
    iterations: int
    residual: float


def fgmres(apply, precondition, right, tolerance, most):
    """Solution of apply(x) = right (n,), from x = 0, once the residual is `tolerance` of the right side's norm.

    apply, precondition: (n,) -> (n,). Ends after `most` iterations, without a restart.
    """
    size = float(np.linalg.norm(right))
    if size == 0.0:
        return Solution(np.zeros_like(right), 0, 0.0)
    basis, directions, left, share = [right / size], [], 1.0, np.zeros(0)
    hessenberg = np.zeros((most + 1, most))
    for j in range(most):
        directions.append(precondition(basis[j]).astype(np.float32))  # half the memory; what was rounded is applied
        image = apply(directions[j].astype(float))
        for i, vector in enumerate(basis):
            hessenberg[i, j] = vector @ image
            image = image - hessenberg[i, j] * vector
        hessenberg[j + 1, j] = np.linalg.norm(image)
        first = np.zeros(j + 2)
        first[0] = 1.0
        part = hessenberg[: j + 2, : j + 1]
        if not np.isfinite(part).all():
            break
        share = np.linalg.lstsq(part, first, rcond=None)[0]
        left = float(np.linalg.norm(part @ share - first))
        if left <= tolerance or hessenberg[j + 1, j] == 0.0:
            break
        basis.append(image / hessenberg[j + 1, j])
    values = np.zeros_like(right)
    for weight, direction in zip(size * share, directions):
        values += weight * direction
    return Solution(values, len(share), left)

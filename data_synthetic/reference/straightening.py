"""Straightening of the vessel by its stent: a beam on an elastic foundation along the branch's axis."""

import numpy as np
from scipy.sparse import coo_matrix, vstack
from scipy.sparse.linalg import spsolve

STEP_MM = 0.25


def offset(axis, stents, vessel_bending_n_mm2, foundation_n_per_mm2):
    """Displacement of the axis: (s mm (n,), w mm (n, 3)), zero with zero slope at both ends.

    Minimises  sum over s of  E_s |c'' + w''|^2 + E_v |w''|^2 + k |w|^2,  c the natural axis, E_s the bending stiffness
    of the stents that cover s (straight when free), E_v that of the vessel (at rest as it is), k the tissue's support
    per length. Small displacements; axial stretch is left free.
    """
    count = int(np.ceil(axis.length_mm / STEP_MM)) + 1
    s = np.linspace(0, axis.length_mm, count)
    h = s[1] - s[0]
    bend = np.zeros(count)
    for stent in stents:
        covered = (s >= stent.start_s_mm) & (s <= stent.end_s_mm)
        bend = np.where(covered, np.maximum(bend, stent.bending_n_mm2), bend)
    if not bend.any():
        return s, np.zeros((count, 3))
    natural = np.gradient(axis.frame(s)[0], s, axis=0)
    rows = np.arange(1, count - 1)
    second = coo_matrix(
        (
            np.repeat([1.0, -2.0, 1.0], count - 2) / h**2,
            (np.tile(rows - 1, 3), np.concatenate([rows - 1, rows, rows + 1])),
        ),
        shape=(count - 2, count),
    ).tocsr()
    inner = slice(1, -1)
    system = vstack(
        [
            second.multiply(np.sqrt(bend[inner])[:, None]),
            second * np.sqrt(vessel_bending_n_mm2),
            np.sqrt(foundation_n_per_mm2) * coo_matrix(np.eye(count)),
        ]
    ).tocsr()
    free = slice(2, -2)  # two end points held on either side: displacement and slope
    target = np.concatenate([-np.sqrt(bend[inner])[:, None] * natural[inner], np.zeros((2 * count - 2, 3))])
    a = system[:, free]
    w = np.zeros((count, 3))
    w[free] = spsolve((a.T @ a).tocsc(), a.T @ target)
    return s, w

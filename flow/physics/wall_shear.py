"""Wall shear stress at the wall's nodes: mu times the tangential part of the wall-normal derivative of velocity."""

import numpy as np

from flow.geometry import tet10

# Barycentric coordinates of the ten nodes of a tetrahedron.
_NODES = np.concatenate([np.eye(4), 0.5 * (np.eye(4)[tet10.EDGES[:, 0]] + np.eye(4)[tet10.EDGES[:, 1]])])
_FACES = [(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)]  # corners of the face opposite each corner


def wall_shear_stress(points, cells, velocity, wall_nodes, viscosity):
    """Wall shear stress vectors (n, 3) in Pa at the nodes: zero off the wall, else the mean over the wall faces there.

    points (n, 3) in m, cells (t, 10), velocity (n, 3) in m/s, wall_nodes (n,) bool: nodes on the wall; viscosity: law
    of physics.viscosity.
    """
    total, count = np.zeros_like(points), np.zeros(len(points))
    for opposite, face in enumerate(_FACES):
        middles = [4 + k for k, edge in enumerate(tet10.EDGES) if opposite not in edge]
        local = list(face) + middles
        chosen = cells[wall_nodes[cells[:, local]].all(axis=1)]
        if len(chosen) == 0:
            continue
        nodes = points[chosen]
        for k in local:
            derivative = tet10.gradients(_NODES[k])
            jacobian = np.einsum("tnx,nr->txr", nodes, derivative)
            gradient = np.einsum("tnu,nr,trx->tux", velocity[chosen], derivative, np.linalg.inv(jacobian))
            normal = _outward(jacobian, opposite)
            shear = 0.5 * (gradient + np.swapaxes(gradient, 1, 2))
            rate = np.sqrt(2 * np.einsum("tux,tux->t", shear, shear))
            traction = viscosity(rate)[:, None] * np.einsum("tux,tx->tu", gradient, normal)
            traction -= np.einsum("tu,tu->t", traction, normal)[:, None] * normal
            # the stress that the fluid exerts on the wall is opposite to the traction on the fluid
            np.add.at(total, chosen[:, k], -traction)
            np.add.at(count, chosen[:, k], 1)
    return total / np.maximum(count, 1)[:, None]


def _outward(jacobian, opposite):
    """Outward unit normals (t, 3) of the faces opposite to corner number `opposite`.

    They point against the gradient of that corner's barycentric coordinate. jacobian (t, 3, 3): d x / d (l1, l2, l3).
    """
    inverse = np.linalg.inv(jacobian)
    gradients = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
    normal = -gradients[:, opposite]
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)

"""Halves edges where the lumen is stretched.

A throat with few edges round it would open into a polygon instead of a circle.
"""

import numpy as np


def split_edges(points, triangles, needs_split):
    """Splits edges at their middle, without cracks.

    points (n, 3), triangles (m, 3). needs_split: function that tells which edges, given as vertex pairs (k, 2), to
    split. Returns (new triangles (q, 3), parents (p, 2), cell (q,)). New point n + i is the middle of the edge between
    the points parents[i]. cell: index of the old triangle in which each new triangle lies.
    """
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    marked = needs_split(unique)
    number = np.full(len(unique), -1)
    number[marked] = len(points) + np.arange(marked.sum())
    middle = number[inverse.reshape(-1)].reshape(-1, 3)  # middle points of the edges 01, 12, 20; -1 if not split
    count = np.sum(middle >= 0, axis=1)
    out, cell = [triangles[count == 0]], [np.flatnonzero(count == 0)]

    def add(rows, *corners):
        out.extend(np.stack(c, axis=1) for c in corners)
        cell.extend([rows] * len(corners))

    for k in range(3):
        a, b, c = (triangles[:, (k + i) % 3] for i in range(3))
        ab, bc, ca = (middle[:, (k + i) % 3] for i in range(3))
        rows = np.flatnonzero((count == 1) & (ab >= 0))
        add(rows, (a[rows], ab[rows], c[rows]), (ab[rows], b[rows], c[rows]))
        rows = np.flatnonzero((count == 2) & (ca < 0))
        add(rows, (ab[rows], b[rows], bc[rows]), (a[rows], ab[rows], bc[rows]), (a[rows], bc[rows], c[rows]))
    rows = np.flatnonzero(count == 3)
    a, b, c = triangles[rows].T
    ab, bc, ca = middle[rows].T
    add(rows, (a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate(out), unique[marked], np.concatenate(cell)


def refine_stretched(points, triangles, move, project_to_lumen, edge_mm, passes=4):
    """Halves edges that are longer than edge_mm after the move, if an end moves by more than 0.02 mm.

    move: function that takes points (n, 3) and returns them moved. project_to_lumen(points (p, 3), parents (p, 2)):
    function that moves new points of the wall onto the true lumen. passes: largest number of rounds in which edges are
    halved. Returns (points, triangles, parents of all new points, old triangle of each new triangle).
    """
    old_triangle = np.arange(len(triangles))
    all_parents = np.zeros((0, 2), int)
    for _ in range(passes):
        moved = move(points)
        shift = np.linalg.norm(moved - points, axis=1)

        def needs_split(pairs):
            length = np.linalg.norm(moved[pairs[:, 0]] - moved[pairs[:, 1]], axis=1)
            return (length > edge_mm) & (shift[pairs].max(axis=1) > 0.02)

        triangles, parents, cell = split_edges(points, triangles, needs_split)
        if not len(parents):
            break
        points = np.concatenate([points, project_to_lumen(points[parents].mean(axis=1), parents)])
        all_parents = np.concatenate([all_parents, parents])
        old_triangle = old_triangle[cell]
    return points, triangles, all_parents, old_triangle

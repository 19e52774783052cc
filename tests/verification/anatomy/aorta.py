"""A patient's aorta with both coronary trees: the surface of the balls along the centrelines of a CT angiogram.

`lca_cl.vtp` and `rca_cl.vtp` of multimoda-rs (MIT) begin in the same aorta and carry the inscribed radius.
"""

import numpy as np
import surfaces
import vtk
from vtk.util.numpy_support import vtk_to_numpy

FILES = {"left": "lca_cl.vtp", "right": "rca_cl.vtp"}
AORTA_MM = 20.0  # length of both centrelines in the ascending aorta; behind it they run towards the aorta's wall
ROOT_MM = 20.0  # the aorta is continued straight over this length
CUT_REACH_RADII = 2.0  # radii round a coronary's end within which it is cut flat
AORTA_CUT_REACH = 1.06  # the same for the aorta's end; it is small, since the coronaries run past this end


def lines(folder, tree):
    """[(points (n, 3), radii (n,))] from the aorta to each outlet, mm."""
    data = surfaces.read(folder / FILES[tree])
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    radii = vtk_to_numpy(data.GetPointData().GetArray("MaximumInscribedSphereRadius")).astype(float)
    cells = [vtk.vtkIdList() for _ in range(data.GetNumberOfCells())]
    for number, cell in enumerate(cells):
        data.GetCellPoints(number, cell)
    places = [[cell.GetId(k) for k in range(cell.GetNumberOfIds())] for cell in cells]
    return [(points[p], radii[p]) for p in places]


def arc_lengths(points):
    """Arc length (n,) from the first point."""
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def smoothed(values, window=9):
    """Moving mean (odd window) that leaves both ends."""
    half = window // 2
    padded = np.concatenate([2 * values[:1] - values[half:0:-1], values, 2 * values[-1:] - values[-2 : -half - 2 : -1]])
    return np.stack([np.convolve(column, np.ones(window) / window, "valid") for column in padded.T], axis=1)


class Model:
    """Balls (centre, radius, mm), and ends (centre, outward normal, radius, reach) where their union is cut flat."""

    def __init__(self):
        self.balls, self.ends, self.outlets, self.ostia = [], [], {}, {}

    def add_tree(self, folder, tree, start_mm=0.0, change=None, most_radius=np.inf):
        """One tree from `start_mm` of arc length on; `change(s, r)` gives other radii, larger balls are left out."""
        self.outlets[tree] = []
        for points, radii in lines(folder, tree):
            points, s = smoothed(points), arc_lengths(points)
            radii = radii if change is None else change(s, radii)
            chosen = (s >= start_mm) & (radii <= most_radius)
            self.balls += list(zip(points[chosen], radii[chosen]))
            end, normal = points[-1], points[-1] - points[-4]
            normal /= np.linalg.norm(normal)
            self.balls.append((end + 0.5 * radii[-1] * normal, radii[-1]))
            self.ends.append((end, normal, radii[-1], CUT_REACH_RADII))
            self.outlets[tree].append(end)

    def add_aorta(self, folder, scale=1.0):
        """The ascending aorta and, straight on, its root; scale: factor of its radii."""
        points, radii = lines(folder, "left")[0]
        s = arc_lengths(points)
        points, radii = points[s < AORTA_MM], scale * radii[s < AORTA_MM]
        down = points[-1] - points[0]
        down /= np.linalg.norm(down)
        root = points[-1] + np.arange(0, ROOT_MM, 0.5)[:, None] * down
        end = root[-1]
        self.balls += list(zip(points, radii)) + [(p, radii[-1]) for p in root]
        for centre, normal, radius in ((points[0], -down, radii[0]), (end, down, radii[-1])):
            self.ends.append((centre, normal, radius, AORTA_CUT_REACH))
            self.balls.append((centre + 0.02 * radius * normal, radius))
        self.arch, self.root = points[0], end

    def surface(self, spacing=0.35, capped=True):
        """(points, triangles) of the union by flying edges, cut flat at its ends, which are closed if `capped`."""
        centres, radii = np.array([b[0] for b in self.balls]), np.array([b[1] for b in self.balls])
        low = (centres - radii[:, None]).min(axis=0) - 4 * spacing
        counts = np.ceil(((centres + radii[:, None]).max(axis=0) + 4 * spacing - low) / spacing).astype(int) + 1
        field = np.full(counts, 10.0, dtype=np.float32)
        for c, r in zip(centres, radii):
            first = np.maximum(np.floor((c - r - 3 * spacing - low) / spacing).astype(int), 0)
            last = np.minimum(np.ceil((c + r + 3 * spacing - low) / spacing).astype(int) + 1, counts)
            x, y, z = (low[k] + spacing * np.arange(first[k], last[k]) - c[k] for k in range(3))
            distance = np.sqrt(x[:, None, None] ** 2 + y[None, :, None] ** 2 + z[None, None, :] ** 2) - r
            part = field[first[0] : last[0], first[1] : last[1], first[2] : last[2]]
            np.minimum(part, distance, out=part)
        surface = surfaces.level_surface(low, field, spacing)
        for centre, normal, radius, reach in self.ends:
            plane, ball, both = vtk.vtkPlane(), vtk.vtkSphere(), vtk.vtkImplicitBoolean()
            plane.SetOrigin(*centre)
            plane.SetNormal(*(-normal))
            ball.SetCenter(*centre)
            ball.SetRadius(reach * radius)
            both.SetOperationTypeToIntersection()
            both.AddFunction(plane)
            both.AddFunction(ball)
            clip = vtk.vtkClipPolyData()
            clip.SetInputConnection(surface.GetOutputPort())
            clip.SetClipFunction(both)
            surface = clip
        largest = vtk.vtkPolyDataConnectivityFilter()
        largest.SetInputConnection(surface.GetOutputPort())
        largest.SetExtractionModeToLargestRegion()
        clean = vtk.vtkCleanPolyData()
        clean.SetInputConnection(largest.GetOutputPort())
        clean.SetTolerance(1e-7)
        triangulate = vtk.vtkTriangleFilter()
        triangulate.SetInputConnection(clean.GetOutputPort())
        triangulate.PassVertsOff()
        triangulate.PassLinesOff()
        triangulate.Update()
        points, triangles = surfaces.arrays(triangulate.GetOutput())
        return with_caps(points, triangles) if capped else (points, triangles)


def with_caps(points, triangles):
    """The surface with a fan of triangles over each of its openings."""
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    known = {tuple(e) for e in edges}
    after = {int(b): int(a) for a, b in known if (b, a) not in known}
    points, caps = list(points), []
    while after:
        loop = [next(iter(after))]
        while loop[-1] in after:
            loop.append(after.pop(loop[-1]))
        points.append(np.mean([points[v] for v in loop[1:]], axis=0))
        caps += [(a, b, len(points) - 1) for a, b in zip(loop, loop[1:])]
    return np.array(points), np.vstack([triangles, np.array(caps)])

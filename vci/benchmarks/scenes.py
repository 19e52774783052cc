"""Generated scenes for benchmarks and tests: narrowed tubes, straight or curved, with devices of a fitting size."""

import dataclasses
import json

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from common import vtp
from common.patient import plaque_types

# Compliance of all balloons: the chart's pressures (bar), increase of the diameter (% per bar), nominal pressure (bar).
COMPLIANCE = (np.array([2, 4, 6, 8, 10, 12, 14, 16, 18, 22, 26]), 1.1, 8.0)
PLAQUE, CALCIUM = plaque_types.FIBROUS, plaque_types.CALCIFIED


@dataclasses.dataclass(frozen=True)
class Tube:
    """A tube with a stenosis at half its length. Lengths are in mm, the curvature of its axis in 1/mm."""

    length: float = 30.0
    radius: float = 1.5  # radius of the healthy lumen
    stenosis: float = 0.5  # share of the diameter that is lost at the narrowest place
    lesion_length: float = 9.0
    eccentricity: float = 0.0  # 0: plaque all round; 1: all plaque on one side
    calcium_deg: float = 0.0  # arc of calcified plaque, centred on the thickest plaque
    curvature: float = 0.0
    edge: float = 0.5  # length of the triangles' edges
    jitter: float = 0.0  # largest random displacement of vertices along the surface, over the edge length
    sliver: float = 0.0  # 0: rows of triangles are equally high; towards 1: every other row is thin
    seed: int = 1  # seed of the random numbers of the jitter

    def lumen_radius(self, s):
        """Lumen radius (mm) at arc lengths s (mm)."""
        d = np.clip((s - self.length / 2) / (self.lesion_length / 2), -1, 1)
        return self.radius * (1 - self.stenosis * 0.5 * (1 + np.cos(np.pi * d)))

    def frames(self, s):
        """(points, first normals, second normals) of the vessel's axis at arc lengths s (n,), each (n, 3).

        Points are in mm, normals are unit vectors. The axis is a line, an arc or a helix.
        """
        if self.curvature == 0:
            ones, zeros = np.ones_like(s), np.zeros_like(s)
            axes = [np.stack(c, 1) for c in ((zeros, zeros, s), (ones, zeros, zeros), (zeros, ones, zeros))]
            return tuple(axes)
        # A helix of radius a that climbs by 2 pi b per turn has the curvature a / (a^2 + b^2). Tubes of less than three
        # quarters of a turn are flat arcs (b = 0); longer ones climb by three lumen radii per turn.
        b = 0.0 if self.curvature * self.length < 1.5 * np.pi else 3 * self.radius / (2 * np.pi)
        a = (1 + np.sqrt(1 - 4 * (self.curvature * b) ** 2)) / (2 * self.curvature)
        c = np.hypot(a, b)
        cos, sin, flat = np.cos(s / c), np.sin(s / c), np.zeros_like(s)
        points = np.stack([a * cos, a * sin, b * s / c], 1)
        normals = np.stack([-cos, -sin, flat], 1)
        tangents = np.stack([-a * sin, a * cos, np.full_like(s, b)], 1) / c
        return points, normals, np.cross(tangents, normals)

    def centre(self, s):
        """Points (n, 3) in mm of the lumen's axis at arc lengths s (n,) of the vessel's axis."""
        points, first, _ = self.frames(s)
        return points + (self.eccentricity * (self.radius - self.lumen_radius(s)))[:, None] * first

    def mesh(self):
        """(points (n, 3), triangles (m, 3), lumen radius (n,), plaque thickness (n,), plaque type (n,)).

        Lengths are in mm. Triangles are indices of points.
        """
        rows, around = self._ring_arc_lengths(), round(2 * np.pi * self.radius / self.edge)
        r, k = np.divmod(np.arange(len(rows) * around), around)
        s, angle = rows[r], 2 * np.pi * (k + 0.5 * (r % 2)) / around
        if self.jitter:
            shift = self.jitter * np.random.default_rng(self.seed).uniform(-1, 1, (2, len(s)))
            inside = (r > 0) & (r < len(rows) - 1)
            s = s + inside * shift[0] * np.gradient(rows)[r]
            angle = angle + inside * shift[1] * 2 * np.pi / around
        radius = self.lumen_radius(s)
        _, first, second = self.frames(s)
        radial = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
        points = self.centre(s) + radius[:, None] * radial
        # The lumen is shifted along the first normal, so the thickest plaque is on the opposite side.
        axis_shift = self.eccentricity * (self.radius - radius)
        distance = np.hypot(axis_shift + radius * np.cos(angle), radius * np.sin(angle))
        plaque = np.maximum(self.radius - distance, 0.0)
        degrees_from_thickest = np.abs(np.degrees(np.arctan2(np.sin(angle), -np.cos(angle))))
        kind = np.where(plaque > 0.05, np.where(degrees_from_thickest < self.calcium_deg / 2, CALCIUM, PLAQUE), 0)
        return points, self._triangles(len(rows), around), radius, plaque, kind

    def _ring_arc_lengths(self):
        """Arc lengths (mm) of the rings of vertices. The rings are closer to each other where the lumen is narrow."""
        rows = [0.0]
        while rows[-1] < self.length:
            share = max(0.3, float(self.lumen_radius(np.array(rows[-1]))) / self.radius)
            thin = 1 - self.sliver * (-1) ** len(rows)
            rows.append(rows[-1] + 0.87 * self.edge * share * thin)
        return np.array(rows) * self.length / rows[-1]

    @staticmethod
    def _triangles(rows, around):
        r, k = np.divmod(np.arange((rows - 1) * around), around)
        a, b = r * around + k, r * around + (k + 1) % around
        c, e = a + around, b + around
        odd = (r % 2 == 1)[:, None]
        first = np.where(odd, np.stack([a, b, e], 1), np.stack([a, b, c], 1))
        second = np.where(odd, np.stack([a, e, c], 1), np.stack([b, e, c], 1))
        return np.concatenate([first, second])


def polydata(points, cells, lines=False):
    """vtkPolyData of points (n, 3). `cells` are lists of their indices: triangles, or polylines if `lines` is true."""
    data, vtk_points, vtk_cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    for cell in cells:
        vtk_cells.InsertNextCell(len(cell), [int(i) for i in cell])
    data.SetPoints(vtk_points)
    (data.SetLines if lines else data.SetPolys)(vtk_cells)
    return data


def write_geometry(folder, tube):
    """Writes the tube's lumen.vtp and centreline.vtp to `folder`, as the anatomy step would."""
    points, triangles, radius, plaque, kind = tube.mesh()
    lumen = polydata(points, triangles)
    vtp.add_array(lumen.GetCellData(), "region_id", np.zeros(len(triangles), dtype=np.int32))
    vtp.add_array(lumen.GetPointData(), "radius_mm", radius)
    vtp.add_array(lumen.GetPointData(), "plaque_thickness_mm", plaque)
    vtp.add_array(lumen.GetPointData(), "plaque_type", kind.astype(np.int32))
    vtp.write(folder / "lumen.vtp", lumen)
    axis = tube.centre(np.linspace(0, tube.length, int(4 * tube.length) + 1))
    centreline = polydata(axis, [range(len(axis))], lines=True)
    names = vtk.vtkStringArray()
    names.SetName("branch_name")
    names.InsertNextValue("main")
    centreline.GetCellData().AddArray(names)
    vtp.write(folder / "centreline.vtp", centreline)


def balloon(diameter, length):
    """A balloon's entry in a scene, for a nominal diameter and length in mm.

    Its diameter is the nominal one at 8 bar, and 1.1 % larger for each bar above.
    """
    pressure, percent, nominal = COMPLIANCE
    chart = diameter * (1 + percent / 100 * (pressure - nominal))
    return {
        "kind": "balloon",
        "nominal_diameter_mm": diameter,
        "length_mm": length,
        "shoulder_mm": 1.5,
        "crimped_diameter_mm": 0.85,
        "rated_burst_pressure_bar": 20,
        "chart": {"pressure_bar": pressure.tolist(), "diameter_mm": chart.tolist()},
    }


def stent(diameter, length, delivery):
    """A stent's entry in a scene, for a nominal diameter and length in mm, on the balloon named `delivery`."""
    return {
        "kind": "stent",
        "balloon": delivery,
        "nominal_diameter_mm": diameter,
        "length_mm": length,
        "crimped_diameter_mm": 1.0,
        "maximal_diameter_mm": 1.45 * diameter,
        "strut_thickness_mm": 0.08,
        "crowns": 8,
        "links": 2,
        "bending_stiffness_n_mm2": 20,
    }


def write_scene(
    folder,
    tube,
    size=1.0,
    pressures=(10, 11, 16),
    shifts=(0.0,),
    length=12.0,
    wall=None,
    numerics=None,
    kissing=0.0,
    folding=None,
):
    """Writes the tube and a scene.json with predilatation, stents and postdilatation. Returns the path of scene.json.

    size: nominal diameter of the stents over the healthy vessel's diameter. pressures: pressures of predilatation,
    stents and last step, bar. shifts: distance (mm) of each stent's middle from the lesion's. length: length of the
    stents, mm. wall, numerics: settings of the scene. kissing: 0 for a postdilatation as last step. Otherwise the last
    step inflates two balloons side by side, each with this share of the stents' diameter. folding: the entry `folding`
    of predilatation and delivery balloons; None: they are not folded.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_geometry(folder, tube)
    diameter, middle = 2 * tube.radius * size, tube.length / 2
    devices = {
        "pre": balloon(0.85 * diameter, length - 2),
        "delivery": balloon(diameter, length),
        "stent": stent(diameter, length, "delivery"),
        "post": balloon(diameter, length - 2),
    }

    if folding is not None:
        for name in ("pre", "delivery"):
            devices[name]["folding"] = folding

    def step(name, action, device, centre, pressure):
        place = {"device": device, "centre_s_mm": centre, "pressure_bar": pressure}
        return {"name": name, "action": action, "devices": [place]}

    procedure = [step("predilatation", "predilatation", "pre", middle, pressures[0])]
    for k, shift in enumerate(shifts):
        procedure.append(step(f"stent {k + 1}", "stent", "stent", middle + shift, pressures[1]))
    last = step("postdilatation", "postdilatation", "post", middle, pressures[2])
    if kissing:
        devices["kissing"] = balloon(kissing * diameter, length - 2)
        last = step("kissing", "kissing", "kissing", middle, pressures[2])
        last["devices"] *= 2
    procedure.append(last)
    document = {
        "schema": "vci-scene-1",
        "case": folder.name,
        "lumen": "lumen.vtp",
        "centreline": "centreline.vtp",
        "patient": {"map_pa": 12000},
        "wall": wall or {},
        "devices": devices,
        "procedure": procedure,
        "numerics": numerics or {},
    }
    (folder / "scene.json").write_text(json.dumps(document, indent=1))
    return folder / "scene.json"

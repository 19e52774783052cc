"""Analytic tubes as lumen surfaces: the geometry of the flow tests."""

import json

import numpy as np
import pandas as pd
import vtk
from scipy.spatial import Delaunay
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

from flow import __main__ as command_line
from flow.geometry import centreline
from flow.geometry.surface import Surface


def tube(length_mm, radius, edge_mm=0.5, axis=None, outlet_region=2):
    """A closed, tagged tube along +x; radius: function of s, both in mm.

    axis: bends the tube; it maps (s, e1, e2), the arc length and two coordinates across the axis, to points.
    """
    around = max(8, round(2 * np.pi * float(radius(0.0)) / edge_mm))
    s = np.linspace(0, length_mm, max(2, round(length_mm / edge_mm)) + 1)
    return revolved(s, [radius(along) for along in s], around, axis, outlet_region)


def revolved(s, radius, around, axis=None, outlet_region=2):
    """A tube like `tube`, with `around` points at each (s, radius) of a meridian (sequences of floats in mm). Where two
    points have the same s, the wall between them is a ring across the axis, as at a sudden expansion."""
    rings = len(s)
    axis = axis or (lambda along, e1, e2: np.stack([along, e1, e2], axis=-1))
    points, triangles, region = [], [], []
    angle = 2 * np.pi * np.arange(around) / around
    for k, along in enumerate(s):
        theta = angle + (k % 2) * np.pi / around
        points.append(axis(np.full(around, along), radius[k] * np.cos(theta), radius[k] * np.sin(theta)))
    for k in range(rings - 1):
        here, there = k * around + np.arange(around), (k + 1) * around + np.arange(around)
        nxt, there_next = np.roll(here, -1), np.roll(there, -1)
        if k % 2 == 0:
            quads = [(here, nxt, there), (nxt, there_next, there)]
        else:
            quads = [(here, there_next, there), (here, nxt, there_next)]
        for a, b, c in quads:
            triangles.append(np.stack([a, b, c], axis=1)[:, ::-1][:, [0, 2, 1]])
            region.append(np.zeros(around, int))
    count = rings * around
    for k, tag in ((0, 1), (rings - 1, outlet_region)):
        cap_points, cap_triangles = _disc(around, angle + (k % 2) * np.pi / around)
        inner = cap_points[around:] * radius[k]
        index = np.concatenate([k * around + np.arange(around), count + np.arange(len(inner))])
        points.append(axis(np.full(len(inner), s[k]), inner[:, 0], inner[:, 1]))
        count += len(inner)
        faces = index[cap_triangles]
        triangles.append(faces[:, ::-1] if k == 0 else faces)
        region.append(np.full(len(faces), tag))
    return Surface(np.concatenate(points), np.concatenate(triangles), np.concatenate(region))


def _disc(around, angle):
    """(points, triangles) of a unit disc. Points of the rim come first, then those of rings inwards.

    The triangles are Delaunay's, counter-clockwise.
    """
    points = [np.stack([np.cos(angle), np.sin(angle)], axis=1)]
    rings = max(1, round(around / 6.3))
    for k in range(rings - 1, 0, -1):
        number = max(5, round(around * k / rings))
        phase = angle[0] + 2 * np.pi * (np.arange(number) + 0.5 * (k % 2)) / number
        points.append(k / rings * np.stack([np.cos(phase), np.sin(phase)], axis=1))
    points = np.concatenate(points + [np.zeros((1, 2))])
    faces = Delaunay(points).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = faces[np.abs(area) > 1e-9]
    area = area[np.abs(area) > 1e-9]
    faces[area < 0] = faces[area < 0][:, ::-1]
    return points, faces


def centre_branch(length_mm, radius, axis=None, name="main", branch_id=0, spacing_mm=0.25):
    """The tube's centreline as a geometry.centreline.Branch."""
    s = np.linspace(0, length_mm, max(2, round(length_mm / spacing_mm)) + 1)
    zero = np.zeros_like(s)
    axis = axis or (lambda along, e1, e2: np.stack([along, e1, e2], axis=-1))
    return centreline.Branch(name, branch_id, axis(s, zero, zero), s, np.array([radius(x) for x in s], float))


def fork(radius=1.5, side_radius=0.9, length=24.0, at=10.0, side_length=10.0, angle_deg=60.0, edge_mm=0.4):
    """(Surface, [Branch, Branch]): a straight tube with one side tube, meshed by gmsh."""
    return branched(radius, length, [(at, side_radius, side_length, angle_deg, 0.0)], edge_mm)


def branched(radius, length, sides, edge_mm):
    """(Surface, [Branch]): a straight tube along +x with side tubes, meshed by gmsh.

    sides: [(place along the main tube in mm, radius and length in mm, angle to the main tube and turn about its axis in
    degrees)].
    """
    import gmsh

    angles = np.radians([side[3:] for side in sides])
    ways = [np.array([np.cos(a), np.sin(a) * np.cos(turn), np.sin(a) * np.sin(turn)]) for a, turn in angles]
    gmsh.initialize(["gmsh"], False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        for name in ("Min", "Max"):
            gmsh.option.setNumber(f"Mesh.CharacteristicLength{name}", edge_mm)
        gmsh.model.add("branched")
        main = gmsh.model.occ.addCylinder(0, 0, 0, length, 0, 0, radius)
        tubes = [
            gmsh.model.occ.addCylinder(at, 0, 0, *(reach * way), side_radius)
            for (at, side_radius, reach, *_), way in zip(sides, ways)
        ]
        gmsh.model.occ.fuse([(3, main)], [(3, tube) for tube in tubes])
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        tags, points, _ = gmsh.model.mesh.getNodes()
        points = points.reshape(-1, 3)[np.argsort(tags)]
        _, nodes = gmsh.model.mesh.getElementsByType(2)
    finally:
        gmsh.finalize()
    used, triangles = np.unique(nodes.astype(int) - 1, return_inverse=True)
    points, triangles = points[used], triangles.reshape(-1, 3)
    region, starts = np.zeros(len(triangles), int), [np.array([side[0], 0.0, 0.0]) for side in sides]
    heights = [points[:, 0], length - points[:, 0]]
    heights += [side[2] - (points - start) @ way for side, start, way in zip(sides, starts, ways)]
    for tag, height in enumerate(heights, 1):
        region[(np.abs(height[triangles]) < 1e-6).all(axis=1)] = tag
    surface = Surface(points, triangles, region)
    if surface.volume_mm3() < 0:
        surface = Surface(points, triangles[:, ::-1], region)
    branches = [centre_branch(length, lambda s: radius)]
    for k, ((_, side_radius, reach, *_), start, way) in enumerate(zip(sides, starts, ways), 1):
        s = np.linspace(0, reach, 41)
        branches.append(centreline.Branch(f"side{k}", k, start + s[:, None] * way, s, np.full(41, side_radius)))
    return surface, branches


def lesion(radius_mm, reduction, centre_mm, length_mm):
    """Radius profile with a cosine lesion that takes `reduction` of the diameter at its centre."""

    def profile(s):
        x = np.clip((np.asarray(s, float) - centre_mm) / length_mm, -0.5, 0.5)
        return radius_mm * (1 - reduction * 0.5 * (1 + np.cos(2 * np.pi * x)))

    return profile


def arc(curvature_per_mm):
    """The argument `axis` of `tube` for a circular arc in the x-y plane."""
    bend = 1.0 / curvature_per_mm

    def axis(along, e1, e2):
        phi = along / bend
        return np.stack([(bend - e1) * np.sin(phi), bend - (bend - e1) * np.cos(phi), e2], axis=-1)

    return axis


def write_case(folder, surface, branches, parents=None, lesions=(), areas=None):
    """Writes lumen.vtp, centreline.vtp, sections.csv and anatomy.json as the anatomy step does.

    branches: [geometry.centreline.Branch], main first. parents: {name: (parent, s_on_parent_mm)}. areas: {name: mm2
    (n,)}, for branches whose sections are not circles of the branch's radius.
    """
    parents, areas = parents or {}, areas or {}
    folder.mkdir(parents=True, exist_ok=True)
    write_lumen(folder / "lumen.vtp", surface)
    write_centreline(folder / "centreline.vtp", branches)
    tables = []
    for branch in branches:
        s = branch.s_mm
        area = areas.get(branch.name, np.pi * branch.radius_mm**2)
        tables.append(pd.DataFrame({"branch": branch.name, "branch_id": branch.branch_id, "s_mm": s, "area_mm2": area}))
    pd.concat(tables).to_csv(folder / "sections.csv", index=False)
    ends = [_end_entry("inlet", "inlet", 1, branches[0], 0, 1)]
    ends += [_end_entry(f"outlet{k + 1}", "outlet", k + 2, branch, -1, -2) for k, branch in enumerate(branches)]
    tree = []
    for branch in branches:
        parent, where = parents.get(branch.name, (None, None))
        tree.append(
            {
                "name": branch.name,
                "branch_id": branch.branch_id,
                "parent": parent,
                "s_on_parent_mm": where,
                "length_mm": branch.length_mm,
            }
        )
    document = {"schema": "vci-anatomy-1", "ends": ends, "branches": tree, "lesions": list(lesions)}
    (folder / "anatomy.json").write_text(json.dumps(document))


def _end_entry(name, kind, region_id, branch, at, inside):
    """Entry of anatomy.json for the end at the index `at` of a branch's points; `inside`: index of the next point."""
    outwards = branch.points[at] - branch.points[inside]
    return {
        "name": name,
        "region_id": region_id,
        "kind": kind,
        "branch": branch.name,
        "centre_mm": branch.points[at].tolist(),
        "normal": (outwards / np.linalg.norm(outwards)).tolist(),
        "diameter_mm": 2 * float(branch.radius_mm[at]),
    }


NO_EXTENSIONS = {"outlet_clearance_diameters": 0, "inlet_clearance_diameters": 0}  # settings: ends are not extended


def mesh_narrowed(folder, reduction, length_mm=8.0, radius_mm=1.2):
    """Writes the files of a tube narrowed in its middle. The commands make a mesh of 3 rings and boundary.json."""
    radius = lesion(radius_mm, reduction, length_mm / 2, 4.0)
    write_case(folder, tube(length_mm, radius, 0.4), [centre_branch(length_mm, radius)])
    along, rings = ["--centreline", str(folder / "centreline.vtp")], ["--rings", "3", "--coarse-rings", "2"]
    rings += [text for name in NO_EXTENSIONS for text in ("--" + name.replace("_", "-"), "0")]
    command_line.main(["mesh", str(folder / "lumen.vtp"), *along, *rings, "--out", str(folder / "mesh.msh")])
    patient = ["--lvm-g", "60", "--sbp-mmhg", "120", "--dbp-mmhg", "80"]
    anatomy = ["--anatomy", str(folder / "anatomy.json")]
    command_line.main(["boundary", *anatomy, *patient, "--out", str(folder / "boundary.json")])


def boundary_document(branches, flows, resistances, probe_mm, viscosity, pressures=(12000.0, 600.0), density=1060.0):
    """boundary.json's content: outlets of the branches with flows (m3/s) and resistances (Pa s/m3), probe on the first.

    pressures: mean arterial, venous, Pa; density, kg/m3; viscosity, Pa s.
    """
    outlets = [
        {
            "name": f"outlet{k + 1}",
            "region_id": k + 2,
            "branch": branch.name,
            "flow_m3_per_s": flow,
            "resistance_pa_s_per_m3": resistance,
        }
        for k, (branch, flow, resistance) in enumerate(zip(branches, flows, resistances))
    ]
    point = np.asarray(branches[0].point(probe_mm)).tolist()
    return {
        "map_pa": pressures[0],
        "venous_pressure_pa": pressures[1],
        "density_kg_per_m3": density,
        "viscosity_pa_s": viscosity,
        "outlets": outlets,
        "probes": [{"name": "distal", "branch": "main", "s_mm": probe_mm, "point_mm": point}],
    }


def write_lumen(path, surface):
    """Writes a Surface as lumen.vtp."""
    data = vtk.vtkPolyData()
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    points.SetData(numpy_to_vtk(surface.points, deep=True))
    data.SetPoints(points)
    cells = vtk.vtkCellArray()
    offsets = np.arange(0, surface.triangles.size + 1, 3, dtype=np.int64)
    connectivity = np.ascontiguousarray(surface.triangles.ravel(), np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connectivity, deep=True))
    data.SetPolys(cells)
    region = numpy_to_vtk(surface.region.astype(np.int32), deep=True)
    region.SetName("region_id")
    data.GetCellData().AddArray(region)
    _write(path, data)


def write_centreline(path, branches):
    """Writes Branches as centreline.vtp."""
    data, points, lines = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetDataTypeToDouble()
    names, ids = vtk.vtkStringArray(), vtk.vtkIntArray()
    names.SetName("branch_name")
    ids.SetName("branch_id")
    for branch in branches:
        lines.InsertNextCell(len(branch.points))
        for point in branch.points:
            lines.InsertCellPoint(points.InsertNextPoint(point))
        names.InsertNextValue(branch.name)
        ids.InsertNextValue(branch.branch_id)
    data.SetPoints(points)
    data.SetLines(lines)
    for name in ("s_mm", "radius_mm"):
        values = np.concatenate([getattr(branch, name) for branch in branches])
        array = numpy_to_vtk(values, deep=True)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    data.GetCellData().AddArray(names)
    data.GetCellData().AddArray(ids)
    _write(path, data)


def _write(path, data):
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.Write()

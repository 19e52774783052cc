"""Folders of results in the formats of docs/design.md, made from bent tubes of known area, curvature and pressure.

All numbers are test data, none is a result of the study.
"""

import json
import pathlib
import shutil

import numpy as np
import pandas as pd
import pytest
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from common import vtp
from reports.inputs.polyline import read_centreline

LENGTH_MM, CURVATURE_PER_MM, SPACING_MM = 40.0, 0.1, 0.25
SEGMENT = (12.0, 30.0)
STAGES = ("deployment-to-contact", "balloon-extraction")
Q_M3_PER_S, VISCOSITY, MAP_PA, VENOUS_PA = 5.0e-6, 0.004, 12444.0, 667.0
NARROWING = {
    "pre": 0.7,
    "vci": 0.05,
    "rc": 0.0,
    "reference": 0.09,
    "ct": 0.12,
    "ct_vci": 0.06,
    "ct_rc": 0.01,
    "post": 0.08,
}  # share of the radius by which the lesion narrows the lumen
ARM_FFR = {"ct": 0.97, "ct_vci": 0.93, "ct_rc": 0.94}  # FFR in the lumens at half maximum


class Tube:
    """A tube along a circular arc, with a cosine lesion near mid-length. move: rigid motion (4, 4) of the tube."""

    def __init__(self, narrowing, curvature=CURVATURE_PER_MM, radius=1.6, move=None):
        self.narrowing, self.curvature, self.radius = narrowing, curvature, radius
        self.move = np.eye(4) if move is None else move

    def s(self):
        return np.linspace(0.0, LENGTH_MM, round(LENGTH_MM / SPACING_MM) + 1)

    def frame(self, s):
        """Points, tangents and normals of the axis, each (n, 3), at arc lengths s (n,)."""
        angle, big = np.asarray(s) * self.curvature, 1.0 / self.curvature
        points = np.stack([big * np.sin(angle), big * (1 - np.cos(angle)), 0 * angle], -1)
        tangents = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
        normals = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], -1)
        rotation, shift = self.move[:3, :3], self.move[:3, 3]
        return points @ rotation.T + shift, tangents @ rotation.T, normals @ rotation.T

    def radii(self, s):
        z = (np.asarray(s) - 21.0) / 6.0
        return self.radius * (1.0 - self.narrowing * np.where(np.abs(z) < 1, 0.5 * (1 + np.cos(np.pi * z)), 0.0))

    def pressure(self, s):
        """Pressure in Pa at arc lengths s, by Poiseuille: dp/ds = 8 mu Q / (pi r^4), integrated on a fine grid."""
        fine = np.linspace(0.0, LENGTH_MM, 4001)
        slope = 8.0 * VISCOSITY * Q_M3_PER_S / (np.pi * (self.radii(fine) * 1e-3) ** 4) * 1e-3
        drop = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(fine))])
        return MAP_PA - np.interp(s, fine, drop)


def add_array(attributes, name, values):
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    attributes.AddArray(array)


def polydata_from(points, triangles=None, lines=None):
    polydata = vtk.vtkPolyData()
    vtk_points = vtk.vtkPoints()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    polydata.SetPoints(vtk_points)
    for cells, setter in ((triangles, polydata.SetPolys), (lines, polydata.SetLines)):
        if cells is not None:
            array = vtk.vtkCellArray()
            for cell in cells:
                array.InsertNextCell(len(cell), [int(k) for k in cell])
            setter(array)
    return polydata


def write_vtp(path, polydata):
    path.parent.mkdir(parents=True, exist_ok=True)
    vtp.write(path, polydata)


def write_json(path, document):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(document, indent=1))


def tube_surface(tube, around=20, along=64):
    s = np.linspace(0.0, LENGTH_MM, along + 1)
    points, tangents, normals = tube.frame(s)
    theta = 2 * np.pi * np.arange(around) / around
    binormals = np.cross(tangents, normals)
    ring = normals[:, None] * np.cos(theta)[None, :, None] + binormals[:, None] * np.sin(theta)[None, :, None]
    vertices = (points[:, None] + tube.radii(s)[:, None, None] * ring).reshape(-1, 3)
    triangles, regions = [], []
    for i in range(along):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            triangles += [(a, b, a + around), (b, b + around, a + around)]
            regions += [0, 0]
    vertices = np.vstack([vertices, points[[0, -1]]])
    last = along * around
    for j in range(around):
        k = (j + 1) % around
        triangles += [(len(vertices) - 2, k, j), (len(vertices) - 1, last + j, last + k)]
        regions += [1, 2]
    polydata = polydata_from(vertices, triangles)
    add_array(polydata.GetCellData(), "region_id", np.array(regions, np.int32))
    add_array(polydata.GetCellData(), "branch_id", np.zeros(len(regions), np.int32))
    radii = np.concatenate([np.repeat(tube.radii(s), around), tube.radii(s)[[0, -1]]])
    add_array(polydata.GetPointData(), "radius_mm", radii)
    return polydata


def write_anatomy(folder, tube):
    s = tube.s()
    points, tangents, _ = tube.frame(s)
    line = polydata_from(points, lines=[range(len(s))])
    for name, values in (("s_mm", s), ("radius_mm", tube.radii(s)), ("torsion_per_mm", 0 * s)):
        add_array(line.GetPointData(), name, values)
    add_array(line.GetPointData(), "curvature_per_mm", np.full(len(s), tube.curvature))
    add_array(line.GetCellData(), "branch_id", np.zeros(1, np.int32))
    names = vtk.vtkStringArray()
    names.SetName("branch_name")
    names.InsertNextValue("main")
    line.GetCellData().AddArray(names)
    write_vtp(folder / "centreline.vtp", line)
    write_vtp(folder / "lumen.vtp", tube_surface(tube))
    header = "branch,branch_id,s_mm,x_mm,y_mm,z_mm,tx,ty,tz,area_mm2,equivalent_diameter_mm,min_diameter_mm,"
    rows = [header + "max_diameter_mm,inscribed_radius_mm,curvature_per_mm,torsion_per_mm,flag"]
    for k in range(len(s)):
        r, end = tube.radii(s[k]), s[k] < 2.4 or s[k] > LENGTH_MM - 2.4
        numbers = [s[k], *points[k], *tangents[k], np.pi * r * r, 2 * r, 2 * r, 2 * r, r, tube.curvature, 0.0]
        rows.append(",".join(["main", "0", *(repr(float(v)) for v in numbers), "end" if end else "ok"]))
    (folder / "sections.csv").write_text("\n".join(rows) + "\n")
    lesion = {"name": "lesion1", "branch": "main", "s_start_mm": 15.0, "s_mla_mm": 21.0, "s_end_mm": 27.0}
    lesion.update(
        mla_mm2=1.6, mla_error_percent=0.0, mld_mm=1.4, reference_diameter_mm=3.2, proximal_reference_diameter_mm=3.2
    )
    lesion.update(distal_reference_diameter_mm=3.2, diameter_stenosis_percent=55.0, area_stenosis_percent=80.0)
    write_json(
        folder / "anatomy.json",
        {
            "schema": "vci-anatomy-1",
            "lesions": [lesion],
            "repairs": [
                {"what": "stub left closed", "count": 1, "detail": "at (1, 2, 3)", "warning": True},
                {"what": "points welded", "count": 7, "detail": "within 1e-6 mm", "warning": False},
            ],
            "timings_s": {"centreline": 0.5, "remesh": 1.25},
        },
    )


def write_flow(folder, tube, wire=None):
    s = tube.s()
    points, _, _ = tube.frame(s)
    rows = ["branch,branch_id,s_mm,x_mm,y_mm,z_mm,pressure_pa,ffr,flow_m3_per_s,ffr_error_estimate"]
    for k, pressure in enumerate(tube.pressure(s)):
        numbers = [s[k], *points[k], pressure, pressure / MAP_PA, Q_M3_PER_S]
        rows.append(",".join(["main", "0", *(repr(float(v)) for v in numbers), ""]))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pullback.csv").write_text("\n".join(rows) + "\n")
    ffr = float(tube.pressure(37.0) / MAP_PA)
    document = {"schema": "vci-ffr-1", "status": "converged", "model": "navier-stokes-3d", "ffr": ffr, "iterations": 9}
    document.update(residual_absolute=3e-9, residual_relative=2e-6, mass_imbalance=1e-12)
    document["error_estimate"] = {"ffr": 0.002, "method": "two meshes"}
    document.update(reduced_model={"ffr": ffr + 0.004}, seconds=12.5, peak_memory_mib=900.0)
    document["inlet_flow_m3_per_s"] = Q_M3_PER_S
    document["outlets"] = [{"name": "outlet1", "flow_m3_per_s": Q_M3_PER_S, "pressure_pa": 1e4, "ffr": ffr}]
    document["probes"] = [{"name": "distal", "branch": "main", "s_mm": 37.0, "ffr": ffr}]
    if wire is not None:
        measured = {"name": "measured", "branch": "main", "s_mm": wire, "ffr": float(tube.pressure(wire) / MAP_PA)}
        document["probes"].append(measured)
    write_json(folder / "ffr.json", document)
    write_json(folder / "mesh.json", {"schema": "vci-mesh-1", "cells": 20000, "dofs": 98000, "element_order": 2})


def write_stent(path, tube, crowns=8, rings=9):
    """Writes struts as `vci deploy` does: zig-zag rings and links, their axes as lines, their surfaces as triangles."""
    points, lines = [], []
    for ring in range(rings):
        start, count = len(points), 2 * crowns
        for k in range(count + 1):
            s = SEGMENT[0] + 1.0 + ring * 2.0 + (0.5 if k % 2 else -0.5)
            centre, tangent, normal = (v[0] for v in tube.frame([s]))
            theta = 2 * np.pi * k / count
            spoke = normal * np.cos(theta) + np.cross(tangent, normal) * np.sin(theta)
            points.append(centre + 0.97 * tube.radii(s) * spoke)
        lines.append(range(start, start + count + 1))
        if ring:
            lines.append([start - count, start])
    write_vtp(path, wrap_in_tubes(polydata_from(np.array(points), lines=lines)))


def write_deployed(folder, before, after, gap_mm=0.5):
    """Writes the deployed lumen with its arrays, and the stent over SEGMENT; the stent is off the wall at one ring."""
    surface, s = tube_surface(after), np.linspace(0.0, LENGTH_MM, 65)
    over_rings = [after.radii(s) / before.radii(s), np.where(s == 20.0, gap_mm, 0.0), after.radii(s) - before.radii(s)]
    stretch, gap, outward = (np.concatenate([np.repeat(v, 20), v[[0, -1]]]) for v in over_rings)
    add_array(surface.GetPointData(), "wall_stretch", stretch)
    add_array(surface.GetPointData(), "malapposition_mm", gap)
    add_array(surface.GetPointData(), "displacement_mm", np.column_stack([outward, 0 * outward, 0 * outward]))
    write_vtp(folder / "lumen.vtp", surface)
    points, triangles = vtp.points_and_triangles(surface)
    ring = np.arange(len(points) - 2) // 20
    within = np.append((s[ring] >= SEGMENT[0]) & (s[ring] <= SEGMENT[1]), [False, False])
    kept = triangles[within[triangles].all(axis=1)]
    write_vtp(folder / "devices" / "stent1.vtp", polydata_from(points[within], (np.cumsum(within) - 1)[kept]))


def wrap_in_tubes(axes, thickness=0.08):
    tubes, both = vtk.vtkTubeFilter(), vtk.vtkAppendPolyData()
    tubes.SetInputData(axes)
    tubes.SetRadius(0.5 * thickness)
    tubes.SetNumberOfSides(5)
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputConnection(tubes.GetOutputPort())
    both.AddInputData(axes)
    both.AddInputConnection(triangles.GetOutputPort())
    both.Update()
    return both.GetOutput()


def write_procedure(folder):
    balloon = {"kind": "balloon", "nominal_diameter_mm": 3.0, "length_mm": 15.0}
    stent = {"kind": "stent", "nominal_diameter_mm": 3.5, "length_mm": 18.0, "strut_thickness_mm": 0.081}
    place = {"branch": "main", "centre_s_mm": 21.0}
    scene = {"schema": "vci-scene-1", "segment": {"branch": "main", "s_start_mm": SEGMENT[0], "s_end_mm": SEGMENT[1]}}
    scene["devices"] = {"sc_3.00x15": balloon, "des_3.50x18": stent}
    remarks = ["lesion1 narrows the diameter by 49.8 % only"]
    scene["reference"] = {"by": "healthy profile", "lesions": [], "remarks": remarks}
    scene["procedure"] = [
        {
            "name": "pre",
            "action": "predilatation",
            "devices": [{"device": "sc_3.00x15", "pressure_bar": 12.0, **place}],
        },
        {"name": "stent", "action": "stent", "devices": [{"device": "des_3.50x18", "pressure_bar": 11.0, **place}]},
    ]
    write_json(folder / "scene.json", scene)
    stage = {"seconds": 0.2, "steps": 40, "cg_iterations": 300, "residual": 2e-3, "contacts": 900}
    stage.update(max_penetration_mm=0.01, mean_penetration_mm=0.0005)
    steps = [{"step": step, "stage": name, **stage} for step in ("pre", "stent") for name in STAGES]
    document = {"schema": "vci-deployment-1", "status": "converged", "stages": steps, "seconds": 0.8}
    document.update(settings={"edge_mm": 0.4}, switched_off=["folding"], minimal_stent_area_mm2=7.3)
    document.update(minimal_lumen_area_in_stent_mm2=7.05, warnings=["stent: opened beyond its maximal diameter"])
    document.update(expansion_index=0.9, recoil_percent=4.0, foreshortening_percent=1.5, straightening_deg=3.0)
    document["stents"] = [{"device": "des_3.50x18", "branch": "main", "expansion_index": 0.9}]
    write_json(folder / "deployment.json", document)


def write_registration(folder, compare):
    document = {"schema": "vci-registration-1", "method": "axes", "compare": compare, "rotation_deg": 40.0}
    document["residual_mm"] = {"trimmed_rms": 0.12, "rms": 0.2, "largest": 0.9}
    document.update(usual_radius_mm=1.5, share_of_both=0.9, missing=["side1"], new=[])
    write_json(folder / "registration.json", document)


def build_case(
    root, name, moves=None, states=("pre", "vci", "rc", "reference"), change=0.0, warnings=(), compare="flow", wire=None
):
    """Writes one case below `root`/cases and returns its folder. moves: {state: rigid motion}.

    change: added to the narrowing of all states but rc. warnings: those of both segmentations, for the state ct.
    compare: flow or areas, for the state post. wire: place of a pressure wire's sensor in mm along main; if given,
    case.yaml and the probes are written too.
    """
    folder = pathlib.Path(root) / "cases" / name
    tubes = {
        state: Tube(NARROWING[state] + (change if state != "rc" else 0.0), move=(moves or {}).get(state))
        for state in states
    }
    for state, tube in tubes.items():
        write_anatomy(folder / "anatomy" if state == "pre" else folder / state / "anatomy", tube)
        if state != "post" or compare == "flow":
            write_flow(folder / "flow" / state, tube, wire)
    write_procedure(folder / "vci")
    write_deployed(folder / "vci", tubes["pre"], tubes["vci"])
    write_stent(folder / "vci" / "devices" / "stent1_struts.vtp", tubes["vci"])
    boundary = {"map_pa": MAP_PA, "venous_pressure_pa": VENOUS_PA, "q_hyperaemic_m3_per_s": Q_M3_PER_S}
    boundary["probes"] = [] if wire is None else [{"name": "measured", "branch": "main", "s_mm": wire}]
    write_json(folder / "flow" / "boundary.json", {"schema": "vci-boundary-1", **boundary})
    if wire is not None:
        (folder / "case.yaml").write_text(
            "kind: surface\ndescription: with a wire\npatient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}\n"
            "lumen: {path: a.stl, units: mm}\n"
            f"measured: {{ffr_pre: 0.62, ffr_post: 0.91, probe: {{branch: main, s_mm: {wire}}}}}\n"
        )
    if "post" in states:
        write_registration(folder / "post", compare)
    if "reference" in states:
        write_json(folder / "source" / "truth.json", {"schema": "vci-truth-1"})
        write_json(
            folder / "reference" / "reference.json",
            {
                "schema": "vci-reference-1",
                "model": "slices",
                "seconds": 60,
                "coarser_than_default": {"slice_spacing_mm": [1.0, 0.75]},
                "error_estimate": {"slices": [{}], "mesh_area_percent": 0.31, "step_area_percent": 0.07},
            },
        )
    for state in ("pre", "reference") if "ct" in states else ():
        found = {"method": "psf_edge", "point_spread_fwhm_mm": 0.73, "warnings": list(warnings)}
        write_json(folder / "ct" / state / "segmentation.json", {"schema": "vci-segmentation-1", **found})
    (folder / "benchmarks").mkdir()
    columns = "s\th:m:s\tmax_rss\tmax_vms\tmax_uss\tmax_pss\tio_in\tio_out\tmean_load\tcpu_time"
    row = "1.5000\t0:00:01\t120.50\t300.00\t100.00\t110.00\t0.00\t0.00\t90.00\t1.40"
    (folder / "benchmarks" / "deploy.tsv").write_text(f"{columns}\n{row}\n")
    return folder


def write_arm(folder):
    """Writes the lumens at half maximum of a case with CT: copies of other states. `ct` is a copy of the wide `rc`."""
    for state, like in (("ct", "rc"), ("ct_vci", "reference"), ("ct_rc", "ct")):
        shutil.copytree(folder / like / "anatomy", folder / "half_maximum" / state / "anatomy")
    for path in (folder / "ct").glob("*/segmentation.json"):
        found = json.loads(path.read_text()) | {"method": "half_maximum"}
        write_json(folder / "half_maximum" / path.relative_to(folder), found)
    document = {"model": "1D network, calibrated", "error": 0.003}
    document["lumens"] = {state: {"ffr": ffr} for state, ffr in ARM_FFR.items()}
    write_json(folder / "half_maximum" / "ffr.json", document)


def shorten_state(folder, first_mm, last_mm, state="post"):
    """Cuts a state's axis, sections and pull-back to the part between two arc lengths, which then count from 0."""
    anatomy, flow = folder / state / "anatomy", folder / "flow" / state
    line = read_centreline(anatomy / "centreline.vtp", "main")
    kept = (line.s_mm >= first_mm) & (line.s_mm <= last_mm)
    poly = polydata_from(line.points[kept], lines=[range(int(kept.sum()))])
    add_array(poly.GetPointData(), "s_mm", line.s_mm[kept] - first_mm)
    add_array(poly.GetPointData(), "curvature_per_mm", line.anatomy_curvature_per_mm[kept])
    names = vtk.vtkStringArray()
    names.SetName("branch_name")
    names.InsertNextValue("main")
    poly.GetCellData().AddArray(names)
    write_vtp(anatomy / "centreline.vtp", poly)
    for path, within in ((anatomy / "sections.csv", 2.4), (flow / "pullback.csv", 0.0)):
        if not path.exists():
            continue
        table = pd.read_csv(path)
        table = table[(table["s_mm"] >= first_mm) & (table["s_mm"] <= last_mm)]
        table["s_mm"] -= first_mm
        if within:
            rim = (table["s_mm"] < within) | (table["s_mm"] > last_mm - first_mm - within)
            table["flag"] = np.where(rim, "end", "ok")
        table.to_csv(path, index=False)


@pytest.fixture
def ended():
    """ended(folder, first_mm, last_mm, state="post"): see shorten_state."""
    return shorten_state


@pytest.fixture
def add_arm():
    """add_arm(folder): see write_arm."""
    return write_arm


@pytest.fixture
def make_case(tmp_path):
    """make_case(name, **options) -> folder of a new case (see build_case)."""
    return lambda name="tube", **options: build_case(tmp_path, name, **options)


@pytest.fixture
def tube():
    """tube(state) -> the Tube of a state, for exact values."""
    return lambda state: Tube(NARROWING[state])

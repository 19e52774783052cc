"""Makes the post-PCI lumen of a scene and a virtual patient by finite elements."""

import logging
import pathlib
import time

import numpy as np
from scipy.integrate import trapezoid

from common import vtp
from common.patient import plaque_types
from common.documents import config
from common.errors import InputError
from common.files import write_json
from common.implicit.field import LumenField, open_ends

from .. import truth
from ..scene import load as load_scene
from .slices import error_estimate, slices
from .slices.lumen import solve_lumen
from .solid import materials
from .surface import deformation, output, refine
from .treatment import devices

WALL_TOLERANCE_MM = 0.05  # a point nearer than this to the true wall counts as on the wall
LEAST_WALL_SHARE = 0.8  # least share of the lumen's points on the true wall; usually 0.94 to 0.98, the others on caps


def read_patient_and_steps(scene, scene_path, truth_path):
    """(Patient, [Step]) of a scene on the branch that it treats. Raises InputError."""
    branches, wall_mm = truth.load(truth_path)
    name, steps = devices.procedure_steps(scene, str(scene_path))
    by_name = {branch.name: branch for branch in branches}
    if name not in by_name:
        raise InputError("no such branch", f"{scene_path}: procedure", name, f"one of {', '.join(by_name)}")
    _check_devices_inside(steps, by_name[name], scene_path)
    return slices.Patient(by_name[name], branches, wall_mm), steps


def run(scene_path, anatomy, truth_path, out, settings_path=None):
    """Writes `out`/{lumen.vtp, lumen.stl, reference.json}; returns the content of reference.json.

    anatomy: folder with the lumen.vtp before PCI. Raises InputError, ComputationError.
    """
    start = time.perf_counter()
    logging.disable(logging.INFO)  # hides the form compiler's messages
    scene, settings = load_scene(scene_path), config.load_section(settings_path, "reference")
    patient, steps = read_patient_and_steps(scene, scene_path, truth_path)
    branch, branches = patient.branch, patient.branches
    lumen_path = pathlib.Path(anatomy) / "lumen.vtp"
    lumen = vtp.read_triangles(lumen_path, "run the anatomy step first")
    _check_same_vessel(lumen, branches, lumen_path)
    model = slices.slice_model(settings)
    solved = solve_lumen(model, patient, steps, settings)
    bent, stents = solved.straightening, [step.stent for step in steps if step.stent]
    fixed_ends = [(centre, radius) for _, centre, _, radius in open_ends(branches)]
    motion = deformation.AxisMotion(bent.s_mm, bent.vessel_mm, bent.turn)
    surface = _deform_surface(
        lumen,
        branches,
        lambda x: deformation.move_points(x, branch, solved.field, motion, fixed_ends),
        settings["edge_mm"],
    )

    models = {1: model}

    def slice_area(refinement, changed, s_mm, stented):
        if refinement not in models:
            models[refinement] = slices.slice_model(changed, refinement)
        pressed = bent.pressed_at(branch.axis, s_mm) if stented else None
        return slices.solve_slice(models[refinement], patient, steps, s_mm, changed, stented, pressed)[1]["area_mm2"]

    spans = slices.stented_spans(steps)
    error = error_estimate.estimate(solved.records, spans, settings, slice_area)
    document = {
        "schema": "vci-reference-1",
        "case": scene.get("case"),
        "model": "plane-strain slices, multiplicative J2 plaque and Yeoh wall; the stent and the vessel are beams",
        "branch": branch.name,
        "settings": settings,
        "coarser_than_default": _coarser_settings(settings),
        "materials": _material_document(settings),
        "steps": [{"name": s.name, "action": s.action, **vars(s.balloon)} for s in steps],
        "stents": [vars(stent) for stent in stents],
        "slices": sorted(solved.records, key=lambda r: (r["s_mm"], r["stented"])),
        "recoil_percent": _mean_recoil_percent(solved.records, spans),
        "minimal_lumen_area_in_stent_mm2": min((r["area_mm2"] for r in solved.records if r["stented"]), default=None),
        "largest_straightening_mm": float(np.linalg.norm(bent.lumen_shift(), axis=1).max()),
        "largest_stent_offset_mm": float(np.linalg.norm(bent.offset_mm[bent.stented], axis=1).max(initial=0)),
        "error_estimate": error,
    }
    out = pathlib.Path(out)
    document["seconds"] = round(time.perf_counter() - start, 2)
    for name in ("lumen.vtp", "lumen.stl"):
        vtp.write(out / name, surface)
    write_json(out / "reference.json", document)
    return document


def _deform_surface(lumen, branches, move, edge_mm):
    """The lumen (vtkPolyData), refined where it is stretched and then moved. Raises ComputationError if it folds.

    move: function that takes points (n, 3) in mm and returns them moved. edge_mm: edges that are longer than this after
    the move are halved.
    """
    field = LumenField(branches)
    before, triangles = vtp.points_and_triangles(lumen)
    is_on_wall = _is_on_wall(field, before)

    def project_to_lumen(points, parents):
        nonlocal is_on_wall
        wall = is_on_wall[parents].all(axis=1)
        points[wall] = field.project(points[wall])
        is_on_wall = np.append(is_on_wall, wall)
        return points

    points, triangles, parents, old_triangle = refine.refine_stretched(
        before, triangles, move, project_to_lumen, edge_mm
    )
    moved = move(points)
    output.check_not_folded(triangles, points, moved)
    return output.refined_surface(lumen, points, moved, triangles, parents, old_triangle)


def _is_on_wall(field, points):
    """Which points (n, 3) lie on the true wall, not on a cap's disc: (n,) bool."""
    return np.abs(field.value(points)) < WALL_TOLERANCE_MM


def _check_same_vessel(lumen, branches, where):
    """Raises InputError if too few points of the lumen (vtkPolyData) lie on the truth's wall.

    The lumen is then of another vessel, or of an earlier version of the vessel.
    """
    share = float(_is_on_wall(LumenField(branches), vtp.points(lumen)).mean())
    if share < LEAST_WALL_SHARE:
        raise InputError(
            "the lumen is not the one before the procedure of this truth",
            where,
            f"{100 * share:.0f} % of its points within {WALL_TOLERANCE_MM} mm of the true wall",
            f"{100 * LEAST_WALL_SHARE:.0f} % or more: the anatomy of the same generated vessel",
        )


def _check_devices_inside(steps, branch, scene_path):
    for number, step in enumerate(steps, start=1):
        half = 0.5 * step.balloon.length_mm
        s = step.balloon.centre_s_mm
        if s - half < 0 or s + half > branch.axis.length_mm:
            raise InputError(
                "device beyond the vessel",
                f"{scene_path}: procedure[{number}].devices[1].centre_s_mm",
                s,
                f"between {half:.1f} and {branch.axis.length_mm - half:.1f} mm",
            )


def _mean_recoil_percent(records, spans):
    """Mean loss of radius in per cent from the last inflation to the end, along the stented spans; None without one."""
    lost, length = 0.0, 0.0
    for start, end in spans:
        stented = [r for r in records if r["stented"] and start - 1e-3 <= r["s_mm"] <= end + 1e-3]
        s = np.array([r["s_mm"] for r in stented])
        last_steps = [r["history"][-1] for r in stented]
        loss = np.array([100 * (1 - h["radius_mm"] / h["inflated_radius_mm"]) for h in last_steps])
        order = np.argsort(s)
        lost, length = lost + trapezoid(loss[order], s[order]), length + np.ptp(s)
    return float(lost / length) if length else None


def _coarser_settings(settings):
    """{key: [value, default]} of the settings that make slices, elements or steps coarser than the default."""
    default = config.load_section(None, "reference")
    finer_when_less = ("slice_spacing_mm", "radius_step_mm", "edge_mm")
    found = {key: [settings[key], default[key]] for key in finer_when_less if settings[key] > default[key]}
    for key in ("elements_around", "elements_through"):
        if settings[key] < default[key]:
            found[key] = [settings[key], default[key]]
    return found


def _material_document(settings):
    """Constants of the tissues with their sources, and the stress of each tissue at a biaxial stretch of 1.15.

    Whole lesions were measured at that stretch (see `materials`).
    """
    names = {plaque_types.NAMES[kind]: material for kind, material in materials.BY_PLAQUE_TYPE.items()}
    found = {key: {**vars(p), "biaxial_stress_mpa": materials.biaxial_stress(1.15, p)} for key, p in names.items()}
    c10, c20 = settings["wall_c10_mpa"], settings["wall_c20_mpa"]
    stress = materials.biaxial_stress(1.15, c10_mpa=c10, c20_mpa=c20)
    found["wall"] = {"c10_mpa": c10, "c20_mpa": c20, "biaxial_stress_mpa": stress, "source": materials.WALL_SOURCE}
    return {**found, "other_settings": materials.SETTINGS_SOURCE}

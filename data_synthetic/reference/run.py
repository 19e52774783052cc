"""Makes the post-PCI lumen of a scene and a virtual patient by finite elements."""

import logging
import pathlib
import time

import numpy as np
from scipy.integrate import trapezoid

from common import vtp
from common.documents import config
from common.errors import InputError
from common.files import write_json
from common.implicit.field import LumenField, ends

from .. import truth
from ..scene import load as load_scene
from .slices import own_error, slices
from .solid import materials
from .surface import deformation, output, refine, straightening
from .treatment import devices

ON_WALL_MM = 0.05  # a point nearer than this to the true wall counts as on the wall
LEAST_ON_WALL = 0.8  # share of the lumen's points on the wall: usually 0.94 to 0.98, as the others lie on caps


def patient_and_steps(scene, scene_path, truth_path):
    """(Patient, [Step]) of a scene on the branch that it treats. Raises InputError."""
    branches, wall_mm = truth.load(truth_path)
    name, steps = devices.steps(scene, str(scene_path))
    by_name = {branch.name: branch for branch in branches}
    if name not in by_name:
        raise InputError("no such branch", f"{scene_path}: procedure", name, f"one of {', '.join(by_name)}")
    _check_inside(steps, by_name[name], scene_path)
    return slices.Patient(by_name[name], branches, wall_mm), steps


def run(scene_path, anatomy, truth_path, out, settings_path=None):
    """Writes `out`/{lumen.vtp, lumen.stl, reference.json}; returns the content of reference.json.

    anatomy: folder with the lumen.vtp before PCI. Raises InputError, ComputationError.
    """
    begun = time.perf_counter()
    logging.disable(logging.INFO)  # hides the form compiler's messages
    scene, settings = load_scene(scene_path), config.load_section(settings_path, "reference")
    patient, steps = patient_and_steps(scene, scene_path, truth_path)
    branch, branches = patient.branch, patient.branches
    lumen_path = pathlib.Path(anatomy) / "lumen.vtp"
    lumen = vtp.read_triangles(lumen_path, "run the anatomy step first")
    _check_same_vessel(lumen, branches, lumen_path)
    model = slices.model_of(settings)
    field, records, free_s = slices.lumen_field(model, patient, steps, settings)
    stents = [step.stent for step in steps if step.stent]
    middle = 0.5 * (free_s[0] + free_s[-1])
    straight_s, straight = straightening.of_patient(branch, patient.wall_mm, stents, middle, settings)
    resting = [(centre, radius) for _, centre, _, radius in ends(branches)]
    surface = _moved_surface(
        lumen,
        branches,
        lambda x: deformation.move(x, branch, field, straight_s, straight, resting),
        settings["edge_mm"],
    )

    models = {1: model}

    def area_with(refinement, changed, s_mm, stented):
        if refinement not in models:
            models[refinement] = slices.model_of(changed, refinement)
        return slices.solve(models[refinement], patient, steps, s_mm, changed, stented)[1]["area_mm2"]

    error = own_error.estimate(records, settings, area_with)
    document = {
        "schema": "vci-reference-1",
        "case": scene.get("case"),
        "model": "plane-strain slices, multiplicative J2 plaque and Yeoh wall; straightening by a beam on a foundation",
        "branch": branch.name,
        "settings": settings,
        "coarser_than_default": _coarser(settings),
        "materials": _materials(settings),
        "steps": [{"name": s.name, "action": s.action, **vars(s.balloon)} for s in steps],
        "stents": [vars(stent) for stent in stents],
        "slices": sorted(records, key=lambda r: (r["s_mm"], r["stented"])),
        "recoil_percent": _recoil(records, slices.spans(steps)),
        "minimal_lumen_area_in_stent_mm2": min((r["area_mm2"] for r in records if r["stented"]), default=None),
        "largest_straightening_mm": float(np.linalg.norm(straight, axis=1).max()),
        "error_estimate": error,
    }
    out = pathlib.Path(out)
    document["seconds"] = round(time.perf_counter() - begun, 2)
    for name in ("lumen.vtp", "lumen.stl"):
        vtp.write(out / name, surface)
    write_json(out / "reference.json", document)
    return document


def _moved_surface(lumen, branches, move, edge_mm):
    """The lumen (vtkPolyData), refined where it is stretched and then moved. Raises ComputationError if it folds.

    move: points (n, 3) mm -> moved points. edge_mm: edges longer than this after the move are halved.
    """
    field = LumenField(branches)
    before, triangles = vtp.arrays(lumen)
    from_wall = _on_wall(field, before)

    def on_lumen(points, parents):
        nonlocal from_wall
        wall = from_wall[parents].all(axis=1)
        points[wall] = field.project(points[wall])
        from_wall = np.append(from_wall, wall)
        return points

    points, triangles, parents, old = refine.refined(before, triangles, move, on_lumen, edge_mm)
    moved = move(points)
    output.check_not_folded(triangles, points, moved)
    return output.refined_surface(lumen, points, moved, triangles, parents, old)


def _on_wall(field, points):
    """Which points (n, 3) lie on the true wall, not on a cap's disc: (n,) bool."""
    return np.abs(field.value(points)) < ON_WALL_MM


def _check_same_vessel(lumen, branches, where):
    """Raises InputError if the lumen (vtkPolyData) is of another vessel than the truth, or of an earlier version."""
    share = float(_on_wall(LumenField(branches), vtp.points(lumen)).mean())
    if share < LEAST_ON_WALL:
        raise InputError(
            "the lumen is not the one before the procedure of this truth",
            where,
            f"{100 * share:.0f} % of its points within {ON_WALL_MM} mm of the true wall",
            f"{100 * LEAST_ON_WALL:.0f} % or more: the anatomy of the same generated vessel",
        )


def _check_inside(steps, branch, scene_path):
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


def _recoil(records, spans):
    """Mean loss of radius in per cent from the last inflation to the end, along the stented spans; None without one."""
    lost, length = 0.0, 0.0
    for start, end in spans:
        held = [r for r in records if r["stented"] and start - 1e-3 <= r["s_mm"] <= end + 1e-3]
        s = np.array([r["s_mm"] for r in held])
        last = [r["history"][-1] for r in held]
        loss = np.array([100 * (1 - h["radius_mm"] / h["inflated_radius_mm"]) for h in last])
        order = np.argsort(s)
        lost, length = lost + trapezoid(loss[order], s[order]), length + np.ptp(s)
    return float(lost / length) if length else None


def _coarser(settings):
    """{key: [value, default]} of the settings that make slices, elements or steps coarser than the default."""
    default = config.load_section(None, "reference")
    finer_when_less = ("slice_spacing_mm", "radius_step_mm", "edge_mm")
    found = {key: [settings[key], default[key]] for key in finer_when_less if settings[key] > default[key]}
    for key in ("elements_around", "elements_through"):
        if settings[key] < default[key]:
            found[key] = [settings[key], default[key]]
    return found


def _materials(settings):
    """Constants of the tissues with their sources, and the stress of each tissue at a biaxial stretch of 1.15.

    Whole lesions were measured at that stretch (see `materials`).
    """
    names = dict(zip(("fibrous", "lipid", "calcified"), materials.OF_TYPE.values()))
    found = {key: {**vars(p), "biaxial_stress_mpa": materials.biaxial_stress(1.15, p)} for key, p in names.items()}
    c10, c20 = settings["wall_c10_mpa"], settings["wall_c20_mpa"]
    stress = materials.biaxial_stress(1.15, c10_mpa=c10, c20_mpa=c20)
    found["wall"] = {"c10_mpa": c10, "c20_mpa": c20, "biaxial_stress_mpa": stress, "source": materials.WALL_SOURCE}
    return {**found, "other_settings": materials.SETTINGS_SOURCE}

"""From a scene and a virtual patient to the finite-element post-PCI lumen."""

import json
import logging
import pathlib
import sys
import time

import numpy as np

from common import config, schema, vtp
from common.errors import InputError
from common.files import write_json

from .. import truth
from ..field import LumenField, ends
from . import deformation, devices, materials, output, own_error, procedure, refine, straightening
from .slice_model import SliceModel

REST_MM = 1.0  # slices beyond the devices' reach, at rest


def load_scene(path):
    """The scene (dict) at `path`. Raises InputError if it is not one."""
    path = pathlib.Path(path)
    if not path.is_file():
        raise InputError("no such file", path, "missing", "write the scene with the planning command")
    scene = json.loads(path.read_text())
    if scene.get("schema") != "vci-scene-1":
        raise InputError("not a scene", f"{path}: schema", scene.get("schema"), "expected vci-scene-1")
    return scene


def load_settings(path):
    """Section `reference` from a YAML or JSON file, or its defaults."""
    return config.load(path, "reference") if path else schema.with_defaults({}, schema.read("reference"))


class Patient:
    """The diseased branch as slices see it: radii round the lumen's axis and the tissue behind."""

    def __init__(self, branch, wall_thickness_mm):
        self.branch, self.wall_mm = branch, wall_thickness_mm

    def place(self, model, s_mm):
        """Puts the model on the section at s_mm."""
        theta = model.annulus.theta_rad
        branch, s = self.branch, np.array(float(s_mm))
        inner = np.full(len(theta), float(branch.radius(s)))
        plaque = branch.plaque_thickness(s, theta)
        base = materials.OF_TYPE[int(branch.base_type(np.array([float(s_mm)]))[0])]

        def tissue(angle, radius):
            thickness = branch.plaque_thickness(s, angle)
            depth = radius - float(branch.radius(s))
            share = 0.5 * (1 - np.tanh((depth - thickness) / 0.04)) * np.clip(thickness / 0.04, 0, 1)
            # The sheet lies in the outer half of the plaque: calcium at the lumen round an arc is not computable.
            deep = 0.5 * (1 + np.tanh((depth - 0.5 * thickness) / 0.06))
            shear, yields, hardening = materials.blended(base, branch.calcium_share(s, angle) * deep)
            return share, shear, yields, hardening

        model.place(inner, inner + plaque + self.wall_mm, tissue)


def slice_positions(axis_length_mm, steps, spacing_mm, margin_mm):
    """Arc lengths (free slices (n,), [(start, end, held slices)]): even, with one at each end of a stented span."""
    low = min(step.balloon.reach()[0] for step in steps) - margin_mm
    high = max(step.balloon.reach()[1] for step in steps) + margin_mm
    low, high = max(low, 0.5), min(high, axis_length_mm - 0.5)
    spans = _union([(step.stent.start_s_mm, step.stent.end_s_mm) for step in steps if step.stent])

    def even(a, b):
        return np.linspace(a, b, max(int(np.ceil((b - a) / spacing_mm)), 2) + 1)

    held = [(a, b, even(a, b)) for a, b in spans]
    # Without the stent slices matter outside the spans only, and at their ends.
    free, start = [], low
    for a, b in spans:
        free += [even(start, a)] if a - start > 0.05 else [[a]]
        start = b
    free += [even(start, high)] if high - start > 0.05 else [[start]]
    return np.unique(np.concatenate(free).round(9)), held


def _union(spans):
    merged = []
    for a, b in sorted(spans):
        if merged and a <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(b, merged[-1][1]))
        else:
            merged.append((a, b))
    return merged


def _model(settings, refine=1):
    return SliceModel(
        settings["elements_around"] * refine,
        settings["elements_through"] * refine,
        settings["wall_c10_mpa"],
        settings["wall_c20_mpa"],
        settings["bulk_modulus_mpa"],
        settings["support_mpa_per_mm"],
    )


def _solve(model, patient, steps, s_mm, settings, stented):
    """(lumen displacement (m, 2), record) of one slice."""
    patient.place(model, s_mm)
    history = procedure.treat(model, steps, s_mm, settings, stented, patient.branch.name)
    record = {
        "s_mm": round(float(s_mm), 4),
        "stented": bool(stented),
        "radius_before_mm": float(patient.branch.radius(np.array(float(s_mm)))),
        "history": history,
        "area_mm2": float(model.lumen_area()),
        "iterations": model.iterations,
    }
    return model.lumen_displacement(), record


def run(scene_path, anatomy, truth_path, out, settings_path=None):
    """Writes `out`/{lumen.vtp, lumen.stl, reference.json}. Raises InputError, ComputationError."""
    begun = time.perf_counter()
    logging.disable(logging.INFO)  # the form compiler's commands are no progress of ours
    scene, settings = load_scene(scene_path), load_settings(settings_path)
    branches, wall_mm = truth.load(truth_path)
    name, steps = devices.steps(scene, str(scene_path))
    by_name = {branch.name: branch for branch in branches}
    if name not in by_name:
        raise InputError("no such branch", f"{scene_path}: procedure", name, f"one of {', '.join(by_name)}")
    branch = by_name[name]
    _check_inside(steps, branch, scene_path)
    lumen = vtp.read_triangles(pathlib.Path(anatomy) / "lumen.vtp", "run the anatomy step first")
    patient = Patient(branch, wall_mm)
    model = _model(settings)
    free_s, held_spans = slice_positions(
        branch.axis.length_mm, steps, settings["slice_spacing_mm"], settings["margin_mm"]
    )
    total = len(free_s) + sum(len(s) for _, _, s in held_spans)
    print(f"{total} slices on {name}", file=sys.stderr)
    records = []

    def solve_span(positions, stented):
        displacements = []
        for s in positions:
            moved, record = _solve(model, patient, steps, s, settings, stented)
            displacements.append(moved)
            records.append(record)
            print(
                f"slice {len(records)}/{total}: s {s:.2f} mm, radius {record['radius_before_mm']:.3f} -> "
                f"{np.sqrt(record['area_mm2'] / np.pi):.3f} mm, {record['iterations']} iterations",
                file=sys.stderr,
            )
        coupling = settings["edge_decay_mm"] if stented else 0.0
        return deformation.SpanField(positions, model.annulus.theta_rad, np.array(displacements), coupling)

    free = solve_span(free_s, False)
    held = [solve_span(s, True) for _, _, s in held_spans]
    field = deformation.LumenDeformation(free, held, settings["edge_decay_mm"])
    stents = [step.stent for step in steps if step.stent]
    middle = 0.5 * (free_s[0] + free_s[-1])
    outer = float(branch.healthy(np.array(middle))) + wall_mm
    foundation = np.pi * outer * settings["support_mpa_per_mm"]
    straight_s, straight = straightening.offset(branch.axis, stents, settings["vessel_bending_n_mm2"], foundation)
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
            models[refinement] = _model(changed, refinement)
        return _solve(models[refinement], patient, steps, s_mm, changed, stented)[1]["area_mm2"]

    error = own_error.estimate(records, settings, area_with)
    document = {
        "schema": "vci-reference-1",
        "case": scene.get("case"),
        "model": "plane-strain slices, multiplicative J2 plaque and Yeoh wall; straightening by a beam on a foundation",
        "branch": name,
        "settings": settings,
        "materials": _materials(settings),
        "steps": [{"name": s.name, "action": s.action, **vars(s.balloon)} for s in steps],
        "stents": [vars(stent) for stent in stents],
        "slices": sorted(records, key=lambda r: (r["s_mm"], r["stented"])),
        "recoil_percent": _recoil(records),
        "minimal_stent_area_mm2": min((r["area_mm2"] for r in records if r["stented"]), default=None),
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
    """The lumen (vtkPolyData) refined where it is stretched, and moved. Raises ComputationError if it folds."""
    field = LumenField(branches)
    before, triangles = vtp.arrays(lumen)
    from_wall = np.abs(field.value(before)) < 0.05  # not on a cap's disc

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


def _check_inside(steps, branch, scene_path):
    for number, step in enumerate(steps):
        half = 0.5 * step.balloon.length_mm
        s = step.balloon.centre_s_mm
        if s - half < 0 or s + half > branch.axis.length_mm:
            raise InputError(
                "device beyond the vessel",
                f"{scene_path}: procedure[{number}].devices[0].centre_s_mm",
                s,
                f"between {half:.1f} and {branch.axis.length_mm - half:.1f} mm",
            )


def _recoil(records):
    """Mean loss of radius in per cent from the last inflation to the end, over the stented slices."""
    losses = [
        100 * (1 - r["history"][-1]["radius_mm"] / r["history"][-1]["inflated_radius_mm"])
        for r in records
        if r["stented"]
    ]
    return float(np.mean(losses)) if losses else None


def _materials(settings):
    plaques = {key: vars(value) for key, value in zip(("fibrous", "lipid", "calcified"), materials.OF_TYPE.values())}
    wall = {"c10_mpa": settings["wall_c10_mpa"], "c20_mpa": settings["wall_c20_mpa"], "source": materials.WALL_SOURCE}
    return {**plaques, "wall": wall, "other_settings": materials.SETTINGS_SOURCE}

"""Tables on the reference: how far it opens each patient's narrowest place beside the engine, and its own error.

At the narrowest place the stent lies against the wall in both models, so the reference's lumen may be compared with the
engine's stent.
"""

import json

import numpy as np

from page_tables import markdown
from vci.benchmarks.device_shapes import ring_vertices

INFLATED = "contact-to-balance"  # stage at whose end a balloon is inflated and in balance


def throats(results):
    """Markdown with a row a patient and a row of means; None where no patient has a reference and frames."""
    rows = [found for folder in sorted((results / "cases").glob("*")) if (found := throat(folder))]
    if not rows:
        return None
    table = [
        [name, *(f"{value:.2f}" for value in values), *map("{:.1f}".format, recoil)] for name, values, recoil in rows
    ]
    recoils = np.array([recoil for _, _, recoil in rows])
    means = [f"{one.mean():.1f}" + (f" ± {one.std(ddof=1):.1f}" if len(one) > 1 else "") for one in recoils.T]
    table.append(["all", "", "", "", "", "", "", *means])
    headings = [
        "patient",
        "before, mm",
        "inflated, reference",
        "inflated, vci",
        "after, reference",
        "after, vci: stent",
    ]
    headings += ["after, vci: lumen", "springs back, reference, %", "springs back, vci, %"]
    return markdown(headings, table)


def throat(folder):
    """(case, diameters (mm) in the order of the table, recoil (%) of reference and vci) of a case's folder, or None."""
    truth, deployed = folder / "reference" / "reference.json", folder / "vci" / "deployment.json"
    if not truth.is_file() or not deployed.is_file() or not (folder / "vci" / "frames").is_dir():
        return None
    truth, deployment = json.loads(truth.read_text()), json.loads(deployed.read_text())
    one = min((one for one in truth["slices"] if one["stented"]), key=lambda one: one["radius_before_mm"])
    inflated = 2 * max(step["inflated_radius_mm"] for step in one["history"])
    after = 2 * one["history"][-1]["radius_mm"]
    widest, final = stent_diameters(folder / "vci", truth["stents"], deployment["stages"], one["s_mm"])
    profile = [(row["s_mm"], row["area_mm2"]) for row in deployment["csa_profile"] if row["area_mm2"]]
    lumen = 2 * np.sqrt(np.interp(one["s_mm"], *zip(*profile)) / np.pi)
    recoil = [100 * (1 - end / start) for start, end in ((inflated, after), (widest, final))]
    return folder.name, [2 * one["radius_before_mm"], inflated, widest, after, final, lumen], recoil


def stent_diameters(vci, stents, stages, s_mm):
    """(largest inflated, final) diameter (mm) of the stent at the arc length s_mm, from the frames of a deployment.

    vci: the folder of the deployment. stents: entry `stents` of reference.json, in the order of the procedure. stages:
    entry `stages` of deployment.json. If stents overlap at s_mm, the first of them counts.
    """
    number = next(k for k, one in enumerate(stents) if one["start_s_mm"] <= s_mm <= one["end_s_mm"])
    from_middle = s_mm - 0.5 * (stents[number]["start_s_mm"] + stents[number]["end_s_mm"])
    final = ring_diameter(vci / "devices" / f"stent{number + 1}.vtp", from_middle)
    steps = json.loads((vci / "scene.json").read_text())["procedure"]
    step = [one["name"] for one in steps if one["action"] == "stent"][number]
    first = next(k for k, stage in enumerate(stages) if stage["step"] == step)
    frames = [k for k in range(first, len(stages)) if stages[k]["stage"] == INFLATED]
    paths = [vci / "frames" / f"frame_device{number + 1}_{k:04d}.vtp" for k in frames]
    return max(ring_diameter(path, from_middle) for path in paths), final


def ring_diameter(path, from_middle_mm):
    """Diameter (mm) of the circle of the same area as a device's cross-section, at a place along it.

    The section is that of the ring there, seen along the device's axis. A ring of n vertices is taken as a regular
    polygon in a circle. from_middle_mm: arc length from the device's middle.
    """
    rings = ring_vertices(path)
    centres, count = rings.mean(axis=1), rings.shape[1]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(centres, axis=0), axis=1))])
    spokes = rings - centres[:, None]
    axis = np.gradient(centres, axis=0)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    polygons = 0.5 * np.abs(np.einsum("rvi,ri->r", np.cross(spokes, np.roll(spokes, -1, axis=1)), axis))
    circles = polygons * (2 * np.pi / count) / np.sin(2 * np.pi / count)
    return float(np.interp(from_middle_mm, along - 0.5 * along[-1], 2 * np.sqrt(circles / np.pi)))


def truth_errors(results):
    """Markdown with a row a patient: what the reference estimates of its error (reference.json); None without one.

    All are changes of a section's area in percent: of the checked slices with half the load step, with twice the
    elements, and with both, and of any place if a slice is left out.
    """
    table = []
    for file in sorted((results / "cases").glob("*/reference/reference.json")):
        truth = json.loads(file.read_text())
        found, changed = truth["error_estimate"], ("step", "mesh", "mesh_and_step")
        row = [truth["case"], str(len(truth["slices"])), str(len(found["slices"]))]
        row += [f"{abs(found[f'{key}_area_percent']):.3f}" for key in changed]
        table.append([*row, *(f"{found['spacing_area_percent'][key]:.2f}" for key in ("mean", "largest"))])
    if not table:
        return None
    headings = ["patient", "slices", "checked", "half the load step, %", "twice the elements, %", "both, %"]
    return markdown([*headings, "a slice left out, mean, %", "a slice left out, largest, %"], table)

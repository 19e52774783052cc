"""Transfers a plan to another segmentation of the same lumen: with the same devices, pressures and places in space."""

import os

import numpy as np

from common.documents import plan_reader
from common.errors import InputError
from common.files import write_json

from ..lumen_results import read_sections


def run(plan_file, from_folder, to_folder, out):
    """Writes the plan of `plan_file`, made for the anatomy `from_folder`, for the anatomy `to_folder`, into `out`.

    Raises InputError if the file is no plan. Raises it also if a treated branch is missing in the other lumen, or has
    its axis elsewhere.
    """
    plan = plan_reader.read(plan_file)
    if "segment" not in plan:
        where = f"{plan_file}, key segment"
        raise InputError("a plan without its treated segment", where, "missing", plan_reader.REMEDY)
    axes = read_sections(from_folder), read_sections(to_folder)
    where = f"{plan_file} in {to_folder}"
    relative = os.path.relpath(to_folder.resolve(), out.resolve().parent)
    plan |= {"lumen": f"{relative}/lumen.vtp", "centreline": f"{relative}/centreline.vtp"}
    segment = plan["segment"]
    for key in ("s_start_mm", "s_end_mm"):
        segment[key] = transferred_s_mm(segment["branch"], segment[key], *axes, where)
    for step in plan["procedure"]:
        for use in step["devices"]:
            use["centre_s_mm"] = transferred_s_mm(use["branch"], use["centre_s_mm"], *axes, where)
    write_json(out, plan)


def transferred_s_mm(branch, s_mm, before, after, where):
    """Arc length in mm, on a branch of the other anatomy, of the place at s_mm on the branch before.

    It is the place nearest in space. before, after: sections of the two anatomies (lumen_results.read_sections). If
    s_mm is beyond the first or last section, the distance beyond is kept. Raises InputError if the place is farther
    from the other axis than the vessel's inscribed radius. where: the plan's file, for messages.
    """
    if branch not in after:
        found = ", ".join(after)
        remedy = f"branches found: {found}; a reading that shows the branch, its outlet among the end points"
        raise InputError("a treated branch is missing", where, branch, remedy)
    line, other = _axis(before[branch]), _axis(after[branch])
    within = float(np.clip(s_mm, line[0][0], line[0][-1]))
    point = np.array([np.interp(within, line[0], line[1][:, k]) for k in range(3)])
    start, span = other[1][:-1], np.diff(other[1], axis=0)
    share = np.clip(np.einsum("ij,ij->i", point - start, span) / np.einsum("ij,ij->i", span, span), 0.0, 1.0)
    distance = np.linalg.norm(start + share[:, None] * span - point, axis=1)
    nearest = int(distance.argmin())
    radius = float(np.interp(within, line[0], line[2]))
    if distance[nearest] > radius:
        value = f"{distance[nearest]:.2f} mm at {s_mm:.1f} mm of {branch}, where the vessel's radius is {radius:.2f} mm"
        remedy = "draw both anatomies (anatomy picture): the other axis may take another way, or lie in another frame"
        raise InputError("a place of the plan lies off the other axis", where, value, remedy)
    s_other = other[0][nearest] + share[nearest] * (other[0][nearest + 1] - other[0][nearest])
    return round(float(s_other + s_mm - within), 3)


def _axis(rows):
    """(arc lengths (n,), points (n, 3), inscribed radii (n,)) of a branch's sections, in mm."""
    return (
        np.array([row["s_mm"] for row in rows]),
        np.array([[row["x_mm"], row["y_mm"], row["z_mm"]] for row in rows]),
        np.array([row["inscribed_radius_mm"] for row in rows]),
    )

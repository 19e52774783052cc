"""A picture of a surface with the candidates for ends of `lumen check`: some taken for ends, others for wall."""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import PolyCollection

from common import vtp
from common.documents import json_reader, schema

from . import picture_file

COLOURS = {True: "tab:green", False: "tab:red"}  # keys: whether a candidate was taken for an end
SIZE_INCHES = (13, 8)  # width and height
OSTIUM_COLOUR = "tab:blue"
MOST_TRIANGLES = 60_000  # of a surface with more triangles only every n-th one is drawn


def run(surface, candidates_file, out):
    """Writes the picture to the path `out` (.png or .svg).

    surface: a .vtp. candidates_file: path of the file of `lumen check --ends`, or None to draw the surface alone.
    """
    picture_file.check_format(out)
    points, triangles = vtp.points_and_triangles(
        vtp.read_triangles(surface, "give the surface of `lumen check --repaired`")
    )
    corners, candidates, trees = points[triangles], *_read_candidates(candidates_file)
    figure, views = plt.subplots(1, 2, figsize=SIZE_INCHES, layout="constrained")
    for axes, turn_deg in zip(views, (0, 90)):
        _draw(axes, corners, candidates, trees, turn_deg)
    lines = [_candidate_line(k, one) for k, one in enumerate(candidates, 1)] + [_tree_line(tree) for tree in trees]
    figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=7)
    picture_file.save(figure, out)


def _read_candidates(path):
    """(candidates for ends, coronary trees of a model with an aorta): two lists of dicts.

    path: file of `lumen check --ends`, or None.
    """
    if path is None:
        return [], []
    remedy = "give the file of `lumen check --ends`"
    document = json_reader.read(path, "ends", remedy)
    schema.validate(document, schema.read("end_candidates"), "a list of ends", remedy)
    return document.data["candidates"], document.data.get("trees", [])


def _draw(axes, corners, candidates, trees, turn_deg):
    """Draws one view: along the shortest principal axis, or along the middle one if `turn_deg` is 90 instead of 0.

    corners (m, 3, 3): corners of the triangles in mm. candidates, trees: results of _read_candidates().
    """
    middle = corners.reshape(-1, 3).mean(axis=0)
    first, second, third = np.linalg.svd(corners[:, 0][:: max(1, len(corners) // 5000)] - middle)[2]
    if turn_deg:
        second, third = third, -second
    drawn = corners[:: 1 + len(corners) // MOST_TRIANGLES]
    normal = np.cross(drawn[:, 1] - drawn[:, 0], drawn[:, 2] - drawn[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    order = np.argsort((drawn.mean(axis=1) - middle) @ third)
    light = 0.45 + 0.5 * np.abs(normal @ (third + 0.5 * first) / np.hypot(1, 0.5))
    flat = np.stack([(drawn - middle) @ first, (drawn - middle) @ second], axis=-1)
    axes.add_collection(PolyCollection(flat[order], facecolors=[str(g) for g in light[order]], edgecolors="none"))
    for number, one in enumerate(candidates, 1):
        x = np.array(one["centre_mm"]) - middle
        colour = COLOURS[one["is_end"]]
        axes.plot(x @ first, x @ second, "o", mfc="none", mec=colour, ms=12, mew=2)
        axes.annotate(str(number), (x @ first, x @ second), xytext=(8, 6), textcoords="offset points", color=colour)
    for tree in trees:
        x = np.array(tree["ostium_mm"]) - middle
        axes.plot(x @ first, x @ second, "D", mfc="none", mec=OSTIUM_COLOUR, ms=12, mew=2)
        axes.annotate(
            tree["name"], (x @ first, x @ second), xytext=(8, -14), textcoords="offset points", color=OSTIUM_COLOUR
        )
    axes.set(aspect="equal", xlabel="mm", ylabel="mm")
    axes.autoscale_view()


def _candidate_line(number, one):
    verdict = "end" if one["is_end"] else "wall"
    where = ", ".join(f"{x:.1f}" for x in one["centre_mm"])
    return f"{number}  {verdict}: {one['kind']} at ({where}), diameter {one['diameter_mm']:.2f} mm: {one['why']}"


def _tree_line(tree):
    where = ", ".join(f"{x:.1f}" for x in tree["ostium_mm"])
    size = f"diameter {tree['diameter_mm']:.2f} mm, {tree['length_mm']:.0f} mm long, {tree['outlets']} outlets"
    return f"{tree['name']}  coronary tree: ostium at ({where}), {size}"

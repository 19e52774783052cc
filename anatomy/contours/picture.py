"""A picture of a pull-back: areas and plaque burden along it, and the plaque unrolled."""

import numpy as np
from matplotlib import pyplot as plt

from common.patient.plaque_types import CALCIFIED, LIPID

from .. import picture_file


def draw(document, z_mm, thickness_mm, kind, out):
    """Writes the picture to the path `out` (.png or .svg).

    document: contours.json as a dict. z_mm: (k,) z of the surface's rings, as in the tables. thickness_mm, kind: (k, n)
    thickness and type of the plaque at n points round each ring, from angle 0 on; None without an outer wall.
    """
    rows = document["frames"]
    z = np.array([row["z_mm"] for row in rows])
    unrolled = thickness_mm is not None
    figure, axes = plt.subplots(2 if unrolled else 1, 1, figsize=(9, 6.5 if unrolled else 3.5), layout="constrained")
    area = np.atleast_1d(axes)[0]
    area.plot(z, [row["lumen_area_mm2"] for row in rows], "o-", ms=3, color="tab:red", label="lumen")
    if unrolled:
        traced = [row for row in rows if row["outer_wall_area_mm2"] is not None]
        at = [row["z_mm"] for row in traced]
        area.plot(at, [row["outer_wall_area_mm2"] for row in traced], "o-", ms=3, color="tab:blue", label="outer wall")
        burden = area.twinx()
        burden.plot(at, [row["plaque_burden_percent"] for row in traced], ":", color="0.4", label="plaque burden")
        burden.set(ylim=(0, 100), ylabel="plaque burden (%)")
    area.set(
        ylim=(0, None), ylabel="area (mm$^2$)", xlabel="z (mm)", title=f"frames along the pull-back; {document['axis']}"
    )
    area.legend(loc="lower right", fontsize=8, ncols=2)
    if unrolled:
        _draw_unrolled(figure, axes[1], z_mm, thickness_mm, kind)
    _put_proximal_left(np.atleast_1d(axes), z)
    picture_file.save(figure, out)


def _draw_unrolled(figure, axes, z_mm, thickness_mm, kind):
    round_deg = np.arange(thickness_mm.shape[1]) * 360 / thickness_mm.shape[1]
    shown = axes.pcolormesh(z_mm, round_deg, thickness_mm.T, shading="nearest", cmap="YlOrBr", vmin=0)
    figure.colorbar(shown, ax=axes, label="plaque thickness (mm)")
    for value, colour, name in ((CALCIFIED, "k", "calcified"), (LIPID, "tab:green", "lipid")):
        if (kind == value).any():
            axes.contour(z_mm, round_deg, (kind == value).T.astype(float), [0.5], colors=colour, linewidths=0.9)
            axes.plot([], [], color=colour, lw=0.9, label=name)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", fontsize=8)
    axes.set(xlabel="z (mm)", ylabel="round the lumen (degrees)", title="plaque beyond the healthy wall, unrolled")


def _put_proximal_left(all_axes, z):
    """Puts the proximal end on the left, so that the flow goes to the right."""
    for axes in all_axes:
        axes.set_xlim(*((z[-1], z[0])))
        axes.annotate("proximal", (0, -0.12), xycoords="axes fraction", fontsize=8, ha="left", va="top")
        axes.annotate("distal", (1, -0.12), xycoords="axes fraction", fontsize=8, ha="right", va="top")

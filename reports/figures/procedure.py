"""Lumen and devices of a procedure, step by step and stage by stage, as in figures 3 and 7 of Lyu et al. 2025."""

import matplotlib.pyplot as plt
import numpy as np

from reports.figures.lumen import FAR_WALL, MOST_TRIANGLES, NEAR_WALL, UNKNOWN
from reports.figures.lumen import add_triangles, draw_scale_bar, paint_order, view_axes
from reports.figures.style import save
from reports.inputs.reading import existing, read_json
from reports.inputs.surface import read_device, read_lumen

STAGES = {
    "deployment-to-contact": "Inflation",
    "contact-to-balance": "At full pressure",
    "balloon-extraction": "Balloon taken out",
}
ROOM_MM = 6.0  # of vessel shown beyond the devices
BALLOON, STENT = (0.55, 0.72, 0.90, 1.0), (0.16, 0.16, 0.2, 1.0)
WIDTH = 7.5  # inches
TITLE = 0.32  # inches, height of a row's title


def procedure_figure(case, deployment, frames, folder):
    """Writes <case>_procedure.{svg,png} and returns their paths. Rows are steps, columns stages, all in one view.

    deployment: deployment.json. frames: the folder of `vci deploy --frames`, with one frame for each stage.
    """
    stages = read_json(deployment, "vci deploy")["stages"]
    shown = [frame(frames, number) for number in range(len(stages))]
    axes3 = view_axes(shown[0][0].points)
    low, high = window([device.points @ axes3.T for _, devices in shown for device in devices])
    steps = steps_of(stages)
    width, height = high - low
    row = WIDTH / len(STAGES) * height / width + TITLE
    size = (WIDTH, row * len(steps))
    figure, grid = plt.subplots(len(steps), len(STAGES), figsize=size, squeeze=False)
    for axes in grid.ravel():
        axes.set_axis_off()
    places = place_of(stages)
    # Stents come first among a frame's devices. In a step's last stage the balloon is removed, so only stents are left.
    stents = {line: len(devices) for (_, devices), (line, _) in zip(shown, places)}
    for (lumen, devices), stage, (line, first) in zip(shown, stages, places):
        axes = grid[line, list(STAGES).index(stage["stage"])]
        draw(axes, axes3, lumen, devices[: stents[line]], devices[stents[line] :])
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        words = STAGES[stage["stage"]]
        name = stage["step"].replace("_", " ")
        axes.set_title(f"{line + 1}. {name}: {words[0].lower() + words[1:]}" if first else words, fontsize=8.5)
    draw_scale_bar(grid[0, 0], low)
    return save(figure, folder, f"{case}_procedure")


def draw(axes, axes3, lumen, stents, balloons):
    """Draws the far wall, balloons, the stents on them, and a see-through near wall."""
    wall = paint_order(lumen, axes3)
    grey = np.full((len(lumen.triangles), 4), UNKNOWN)
    add_triangles(axes, wall, ~wall["near"], grey, FAR_WALL)
    for devices, colour in ((balloons, BALLOON), (stents, STENT)):
        for device in devices:
            seen = paint_order(device, axes3)
            add_triangles(axes, seen, seen["near"], np.full((len(device.triangles), 4), colour), 1.0)
    add_triangles(axes, wall, wall["near"], grey, NEAR_WALL if stents or balloons else 1.0)


def frame(frames, number):
    """(lumen, [devices]) at the end of stage `number`, counted from 0, as Surfaces."""
    lumen = read_lumen(existing(frames / f"frame_lumen_{number:04d}.vtp", "vci deploy --frames"), MOST_TRIANGLES)
    found = sorted(frames.glob(f"frame_device*_{number:04d}.vtp"))
    return lumen, [device for device in map(read_device, found) if device]


def window(points):
    """Lower and upper corner (2,) in mm of a view that shows all devices and ROOM_MM round them.

    points: one array (n, 3) for each device, in the axes of the view.
    """
    together = np.vstack(points)[:, :2]
    return together.min(0) - ROOM_MM, together.max(0) + ROOM_MM


def place_of(stages):
    """[(row, first)] of the stages: the figure's row of each, and whether it is the first stage of its step.

    Each step has a row of its own, numbered from 0.
    """
    line, found = -1, []
    for number, stage in enumerate(stages):
        begins = number == 0 or stage["stage"] == next(iter(STAGES))
        line += begins
        found.append((line, begins))
    return found


def steps_of(stages):
    """The names of the steps, one for each row of the figure."""
    return [stage["step"] for stage, (_, begins) in zip(stages, place_of(stages)) if begins]

"""Lumen and devices of a procedure, step by step and stage by stage, like figures 3 and 7 of Lyu et al. 2025."""

import matplotlib.pyplot as plt
import numpy as np

from reports.figures.lumen import FAR_WALL_OPACITY, MOST_TRIANGLES, NEAR_WALL_OPACITY, NO_FFR_COLOUR
from reports.figures.lumen import draw_triangles, draw_scale_bar, project_triangles, view_axes
from reports.figures.style import save_figure
from reports.inputs.reading import require_file, read_json
from reports.inputs.surface import read_device, read_lumen

STAGE_TITLES = {
    "deployment-to-contact": "Inflation",
    "contact-to-balance": "At full pressure",
    "balloon-extraction": "Balloon taken out",
}
VIEW_MARGIN_MM = 6.0  # length of vessel shown beyond the devices
BALLOON_COLOUR, STENT_COLOUR = (0.55, 0.72, 0.90, 1.0), (0.16, 0.16, 0.2, 1.0)
STENT_OPACITY = 0.45  # a balloon inside is seen through the stent
FIGURE_WIDTH = 7.5  # inches
TITLE_HEIGHT = 0.32  # inches, height of a row's title


def procedure_figure(case, deployment, frames, folder):
    """Writes <case>_procedure.{svg,png} and returns their paths.

    Each step has a row and each stage a column; all panels have the same view. deployment: path of deployment.json.
    frames: the folder that `vci deploy --frames` wrote, with one frame for each stage.
    """
    stages = read_json(deployment, "vci deploy")["stages"]
    frames_shown = [read_frame(frames, number) for number in range(len(stages))]
    axes3 = view_axes(frames_shown[0][0].points)
    low, high = view_window([device.points @ axes3.T for _, devices in frames_shown for device in devices])
    steps = step_names(stages)
    width, height = high - low
    row = FIGURE_WIDTH / len(STAGE_TITLES) * height / width + TITLE_HEIGHT
    size = (FIGURE_WIDTH, row * len(steps))
    figure, grid = plt.subplots(len(steps), len(STAGE_TITLES), figsize=size, squeeze=False)
    for axes in grid.ravel():
        axes.set_axis_off()
    rows = stage_rows(stages)
    # Which devices are stents? They come first in a frame. In a step's last stage the balloon is gone, so the number of
    # devices there is the number of stents in all stages of this step.
    stents = {line: len(devices) for (_, devices), (line, _) in zip(frames_shown, rows)}
    for (lumen, devices), stage, (line, first) in zip(frames_shown, stages, rows):
        axes = grid[line, list(STAGE_TITLES).index(stage["stage"])]
        draw_stage(axes, axes3, lumen, devices[: stents[line]], devices[stents[line] :])
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        stage_title = STAGE_TITLES[stage["stage"]]
        name = stage["step"].replace("_", " ")
        axes.set_title(
            f"{line + 1}. {name}: {stage_title[0].lower() + stage_title[1:]}" if first else stage_title, fontsize=8.5
        )
    draw_scale_bar(grid[0, 0], low)
    return save_figure(figure, folder, f"{case}_procedure")


def draw_stage(axes, axes3, lumen, stents, balloons):
    """Draws the far wall, balloons, and the stents on them and the near wall, which are see-through."""
    wall = project_triangles(lumen, axes3)
    grey = np.full((len(lumen.triangles), 4), NO_FFR_COLOUR)
    draw_triangles(axes, wall, ~wall["near"], grey, FAR_WALL_OPACITY)
    for devices, colour, opacity in ((balloons, BALLOON_COLOUR, 1.0), (stents, STENT_COLOUR, STENT_OPACITY)):
        for device in devices:
            projected = project_triangles(device, axes3)
            draw_triangles(axes, projected, projected["near"], np.full((len(device.triangles), 4), colour), opacity)
    draw_triangles(axes, wall, wall["near"], grey, NEAR_WALL_OPACITY if stents or balloons else 1.0)


def read_frame(frames, number):
    """(lumen, [devices]) at the end of stage `number`, counted from 0, as Surfaces."""
    lumen = read_lumen(require_file(frames / f"frame_lumen_{number:04d}.vtp", "vci deploy --frames"), MOST_TRIANGLES)
    found = sorted(frames.glob(f"frame_device*_{number:04d}.vtp"))
    return lumen, [device for device in map(read_device, found) if device]


def view_window(points):
    """Lower and upper corner (2,) in mm of a view that shows all devices and VIEW_MARGIN_MM round them.

    points: one array (n, 3) for each device, in the axes of the view.
    """
    together = np.vstack(points)[:, :2]
    return together.min(0) - VIEW_MARGIN_MM, together.max(0) + VIEW_MARGIN_MM


def stage_rows(stages):
    """[(row, first)] for each stage: its row in the figure, and whether it is the first stage of its step.

    Each step has a row of its own, numbered from 0.
    """
    row, rows = -1, []
    for number, stage in enumerate(stages):
        starts_step = number == 0 or stage["stage"] == next(iter(STAGE_TITLES))
        row += starts_step
        rows.append((row, starts_step))
    return rows


def step_names(stages):
    """The names of the steps, one for each row of the figure."""
    return [stage["step"] for stage, (_, starts_step) in zip(stages, stage_rows(stages)) if starts_step]

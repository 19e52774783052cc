"""The picture of a procedure stage by stage."""

import json

import matplotlib.image
import numpy as np
import pytest

from common.errors import InputError
from reports.figures.procedure import BALLOON_COLOUR, STENT_COLOUR, stage_rows, procedure_figure, step_names

STAGES = ("deployment-to-contact", "contact-to-balance", "balloon-extraction")


def tube_file(write, path, radius, around=24):
    """Writes a vertical tube of 12 mm length about the z axis as VTP."""
    theta = 2 * np.pi * np.arange(around) / around
    ring = np.stack([radius * np.cos(theta), radius * np.sin(theta)], 1)
    points = np.array([[x, y, z] for z in np.linspace(-6, 6, 9) for x, y in ring])
    triangles = []
    for i in range(8):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            triangles += [(a, b, a + around), (b, b + around, a + around)]
    write(path, points, triangles)


@pytest.fixture
def frames(tmp_path):
    """A predilatation and a stent: a balloon alone, then a stent on its balloon, then the stent alone."""
    from tests.unit.reports.conftest import polydata_from, write_vtp

    def write(path, points, triangles):
        write_vtp(path, polydata_from(points, triangles))

    folder = tmp_path / "frames"
    devices = [[1.0], [1.0], [], [1.2, 1.1], [1.2, 1.1], [1.2]]
    for number, radii in enumerate(devices):
        tube_file(write, folder / f"frame_lumen_{number:04d}.vtp", 1.5)
        for k, radius in enumerate(radii, start=1):
            tube_file(write, folder / f"frame_device{k}_{number:04d}.vtp", radius)
    stages = [{"step": step, "stage": stage} for step in ("predilatation", "stent") for stage in STAGES]
    (tmp_path / "deployment.json").write_text(json.dumps({"stages": stages}))
    return tmp_path


def blue_share(picture):
    """Share of a picture's pixels that have the balloon's hue."""
    red, _, blue = (picture[..., k] for k in range(3))
    return np.mean(blue - red > 0.25 * (BALLOON_COLOUR[2] - BALLOON_COLOUR[0]))


def test_a_row_a_step_and_a_balloon_only_while_it_is_there(frames):
    assert STENT_COLOUR[2] - STENT_COLOUR[0] < 0.1, "the stent is not blue"
    _, png = procedure_figure("one", frames / "deployment.json", frames / "frames", frames)
    picture = matplotlib.image.imread(png)
    height, width = picture.shape[:2]
    panels = [
        [picture[i * height // 2 : (i + 1) * height // 2, j * width // 3 : (j + 1) * width // 3] for j in range(3)]
        for i in range(2)
    ]
    assert blue_share(panels[0][0]) > 0.05 and blue_share(panels[0][1]) > 0.05
    assert blue_share(panels[0][2]) == 0.0 and blue_share(panels[1][2]) == 0.0
    assert blue_share(panels[1][0]) > 0.02, "a balloon is seen through a stent as long as it"


def test_steps_of_the_same_name_have_their_own_rows():
    stages = [{"step": step, "stage": stage} for step in ("stent", "stent") for stage in STAGES]
    assert stage_rows(stages) == [(0, True), (0, False), (0, False), (1, True), (1, False), (1, False)]
    assert step_names(stages) == ["stent", "stent"]


def test_a_frame_that_is_missing_is_named(frames):
    (frames / "frames" / "frame_lumen_0004.vtp").unlink()
    with pytest.raises(InputError, match="frame_lumen_0004"):
        procedure_figure("one", frames / "deployment.json", frames / "frames", frames)

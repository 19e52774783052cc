"""The picture of the tree: it is written completely or not at all, has the same bits each time, and bad input is
refused."""

import itertools
import json

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.text import Text

from anatomy import picture
from common.errors import InputError

HEADER = (
    "branch,branch_id,s_mm,x_mm,y_mm,z_mm,tx,ty,tz,area_mm2,equivalent_diameter_mm,min_diameter_mm,max_diameter_mm,"
    "inscribed_radius_mm,reference_diameter_mm,curvature_per_mm,torsion_per_mm,flag"
)


@pytest.fixture
def folder(tmp_path):
    rows = [HEADER]
    for i in range(1, 40):
        s, d = i / 2, 3.0 - (1.2 if 18 < i < 24 else 0)
        flag = "end" if i < 4 or i > 36 else "ok"
        rows.append(f"main,0,{s},{s},{s * s / 50},0,1,0,0,7,{d},{d - 0.1},{d + 0.1},{d / 2},3.0,0.04,0,{flag}")
        if i < 12:
            rows.append(f"side1,1,{s},{10 + s},{2 - s},1,0,-1,0,2,1.6,1.5,1.7,0.8,1.6,0,0,ok")
    (tmp_path / "sections.csv").write_text("\n".join(rows) + "\n")
    lesion = {
        "name": "lesion1",
        "branch": "main",
        "s_start_mm": 9.5,
        "s_mla_mm": 10.5,
        "s_end_mm": 11.5,
        "mld_mm": 1.8,
        "diameter_stenosis_percent": 40,
        "proximal_reference_diameter_mm": 3.0,
        "distal_reference_diameter_mm": 3.0,
    }
    inlet = {"name": "inlet", "kind": "inlet", "branch": "main", "centre_mm": [0, 0, 0], "normal": [-1, 0, 0]}
    main = {"name": "main", "parent": None, "s_on_parent_mm": 0.0, "length_mm": 20.0}
    side = {"name": "side1", "parent": "main", "s_on_parent_mm": 10.0, "length_mm": 6.0}
    summary = {"schema": "vci-anatomy-1", "ends": [{**inlet, "diameter_mm": 3.0}], "branches": [main, side]}
    (tmp_path / "anatomy.json").write_text(json.dumps({**summary, "lesions": [lesion]}))
    return tmp_path


def test_png_is_the_same_each_time(folder):
    picture.run(folder, folder / "a.png")
    picture.run(folder, folder / "b.png")
    content = (folder / "a.png").read_bytes()
    assert content[:8] == b"\x89PNG\r\n\x1a\n" and content == (folder / "b.png").read_bytes()


def test_svg_names_branches_and_lesions(folder, monkeypatch):
    monkeypatch.setitem(picture.matplotlib.rcParams, "svg.fonttype", "none")
    picture.run(folder, folder / "a.svg")
    text = (folder / "a.svg").read_text()
    assert "side1" in text and "lesion 1: 40 %" in text and "inlet (3.00 mm)" in text


def test_refusals(folder):
    with pytest.raises(InputError, match="picture format"):
        picture.run(folder, folder / "a.gif")
    (folder / "sections.csv").unlink()
    with pytest.raises(InputError, match="sections"):
        picture.run(folder, folder / "a.png")
    assert not (folder / "a.png").exists()


@pytest.mark.parametrize("cut, what", [(1, "no section"), (20, "line 20"), (None, "line 2")])
def test_a_broken_table_is_refused_with_its_line(folder, cut, what):
    lines = (folder / "sections.csv").read_text().splitlines()
    broken = [lines[0].replace("s_mm", "s"), *lines[1:]] if cut is None else lines[:cut]
    if cut == 20:
        broken[-1] = broken[-1].rsplit(",", 8)[0]
    (folder / "sections.csv").write_text("\n".join(broken) + "\n")
    with pytest.raises(InputError, match=f"(?s){what}"):
        picture.run(folder, folder / "a.png")
    assert not (folder / "a.png").exists()


def test_labels_keep_clear_of_each_other_and_of_the_vessel():
    figure, axes = plt.subplots()
    wall = np.column_stack([np.linspace(0, 10, 200), np.full(200, 5.0)])
    axes.plot(*wall.T)
    axes.set(xlim=(0, 10), ylim=(0, 10))
    labels = [picture._label(axes, f"outlet{k} (2.00 mm)", (5.0, 5.0)) for k in range(4)]
    picture._place_labels(figure, axes, [(label, 0, wall) for label in labels])
    figure.canvas.draw()
    boxes = [label.get_window_extent() for label in labels]
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
    clear = axes.transData.transform(wall)
    assert not any(box.contains(*point) for box in boxes for point in clear)
    plt.close(figure)


def test_no_label_lies_on_the_wall(folder, monkeypatch):
    """The branches' silhouettes, not their axes alone, are kept clear."""
    place, on_wall = picture._place_labels, []

    def checked(figure, axes, labels):
        place(figure, axes, labels)
        figure.canvas.draw()
        outlines = [axes.transData.transform_path(patch.get_path()) for patch in axes.patches]
        boxes = [Text.get_window_extent(label) for label, *_ in labels]  # without the leaders
        on_wall.extend(outline.intersects_bbox(box, filled=True) for outline in outlines for box in boxes)

    monkeypatch.setattr(picture, "_place_labels", checked)
    picture.run(folder, folder / "a.png")
    assert len(on_wall) == 8 and not any(on_wall)  # two branches, four labels


@pytest.mark.parametrize("swing, lowest", [(0.1, True), (5, False)])
def test_picture_is_as_high_as_the_tree(folder, swing, lowest):
    lines = [line.split(",") for line in (folder / "sections.csv").read_text().splitlines()]
    rows = [line for line in lines if line[0] == "main"]
    for i, row in enumerate(rows):
        row[4] = str(swing * np.sin(i / 3))
    (folder / "sections.csv").write_text("\n".join([HEADER, *(",".join(row) for row in rows)]) + "\n")
    picture.run(folder, folder / "a.png")
    height = plt.imread(folder / "a.png").shape[0] / 130 - picture.PROFILE_INCHES
    assert (height < picture.LEAST_TREE_INCHES + 0.1) == lowest and height < 1.1 * picture.WIDTH_INCHES

"""Centrelines in bad files, or of another lumen, are refused."""

import dataclasses
import json

import numpy as np
import pytest

import tubes
from common.errors import InputError
from flow import __main__ as command_line
from flow.geometry import centreline

LENGTH, RADIUS = 24.0, 1.2  # mm


def _changed(name, at, value):
    line = tubes.centre_branch(LENGTH, lambda s: RADIUS)
    values = getattr(line, name).copy()
    values[at] = value
    return dataclasses.replace(line, **{name: values})


def _scaled(**factors):
    line = tubes.centre_branch(LENGTH, lambda s: RADIUS)
    return dataclasses.replace(line, **{name: factor * getattr(line, name) for name, factor in factors.items()})


def _written(folder, *lines):
    tubes.write_centreline(folder / "line.vtp", list(lines))
    return folder / "line.vtp"


@pytest.mark.parametrize(
    "line, words",
    [
        (
            _changed("points", (10, 1), np.nan),
            "point of a centreline is not finite(.|\n)*line.vtp: main(.|\n)*number 10",
        ),
        (_changed("radius_mm", 10, np.nan), "radius_mm of a centreline is not finite"),
        (_changed("s_mm", 10, np.inf), "s_mm of a centreline is not finite"),
        (_changed("radius_mm", 10, 0.0), "radius_mm of a centreline is not positive(.|\n)*point 10"),
        (_changed("points", 10, [2.75, 0, 0]), "two points of a centreline at one place(.|\n)*point 10"),
        (_changed("s_mm", 10, 2.25), "s_mm of a centreline does not ascend(.|\n)*point 9"),
        (_scaled(s_mm=1e-3), "s_mm of a centreline is not its arc length(.|\n)*0.024 mm where 24 mm"),
        (_scaled(s_mm=1.011), "s_mm of a centreline is not its arc length"),
        (_changed("s_mm", 0, -0.25), "s_mm of a centreline is not its arc length"),
    ],
)
def test_a_bad_branch_is_refused(tmp_path, line, words):
    with pytest.raises(InputError, match=words):
        centreline.read(_written(tmp_path, line))


def test_a_good_one_is_read(tmp_path):
    (read,) = centreline.read(_written(tmp_path, _scaled(s_mm=1.009)))
    assert read.length_mm == pytest.approx(1.009 * LENGTH)


def test_descending_s_and_branches_of_one_name_are_refused(tmp_path):
    line = tubes.centre_branch(LENGTH, lambda s: RADIUS)
    with pytest.raises(InputError, match="does not ascend"):
        centreline.read(_written(tmp_path, dataclasses.replace(line, s_mm=line.s_mm[::-1].copy())))
    with pytest.raises(InputError, match="two branches have the same name"):
        centreline.read(_written(tmp_path, line, line))


def test_a_line_that_covers_part_of_the_lumen_is_refused(tmp_path, capsys):
    """`flow mesh` and `flow rank` refuse it. A line that ends within a radius of the cap is accepted."""
    tube = tubes.tube(LENGTH, lambda s: RADIUS, 0.6)
    for length, refused in ((LENGTH, False), (LENGTH - RADIUS, False), (9.75, True)):
        tree = centreline.Tree([tubes.centre_branch(length, lambda s: RADIUS)])
        if refused:
            with pytest.raises(InputError, match="does not end at(.|\n)*line.vtp: end of main(.|\n)*12.1 of its radii"):
                centreline.check_ends(tree, tube, "line.vtp")
        else:
            centreline.check_ends(tree, tube, "line.vtp")
    half = [tubes.centre_branch(9.75, lambda s: RADIUS)]
    tubes.write_case(tmp_path / "plan", tube, half)
    line = ["--centreline", str(tmp_path / "plan" / "centreline.vtp")]
    document = tubes.boundary_document(half, [2e-6], [5e9], 8.0, 0.004)
    boundary = tmp_path / "boundary.json"
    boundary.write_text(json.dumps(document))
    for command in (
        ["mesh", str(tmp_path / "plan" / "lumen.vtp"), *line, "--out", str(tmp_path / "out.msh")],
        ["rank", f"half={tmp_path / 'plan'}", "--boundary", str(boundary), "--out", str(tmp_path / "r.csv")],
    ):
        with pytest.raises(SystemExit) as ended:
            command_line.main(command)
        said = capsys.readouterr().err
        assert ended.value.code == 2 and "does not end at" in said
    assert "plan half" in said and str(tmp_path / "plan") in said


def test_an_outlet_without_a_branch_and_a_line_the_other_way_are_refused():
    surface, branches = tubes.fork(length=12.0, at=6.0, side_length=6.0, edge_mm=0.8)
    centreline.check_ends(centreline.Tree(branches), surface, "line.vtp")
    with pytest.raises(InputError, match="outlet of the lumen without a branch(.|\n)*3"):
        centreline.check_ends(centreline.Tree(branches[:1]), surface, "line.vtp")
    turned = dataclasses.replace(branches[0], points=branches[0].points[::-1])
    with pytest.raises(InputError, match="does not end at(.|\n)*start of main"):
        centreline.check_ends(centreline.Tree([turned, branches[1]]), surface, "line.vtp")

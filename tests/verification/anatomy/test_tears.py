"""An opening narrower than the vessel behind it is a tear in the wall; the mouth of a short branch is an end."""

import json
import subprocess

import numpy as np
import pytest
import surfaces

AT, HOLE_MM = np.array([10.0, 1.5, 0.0]), 0.45


def lipped(height, turned=False):
    """(points, triangles) of an open tube with a hole in its wall. The hole's lip stands out by `height` (mm).

    So the wall beside the rim runs along the rim's normal, as at the mouth of a vessel.
    """
    points, triangles = surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 20, 0.2, capped=False)
    away = np.linalg.norm(points - AT, axis=1) < HOLE_MM
    triangles = triangles[~away[triangles].any(axis=1)]
    sides = np.sort(np.vstack([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    every, counts = np.unique(sides, axis=0, return_counts=True)
    border = {tuple(side) for side in every[counts == 1]}
    made, lip, number = [], [], {}
    for t in triangles:
        for k in range(3):
            a, b = int(t[k]), int(t[(k + 1) % 3])
            if (min(a, b), max(a, b)) in border and np.linalg.norm(points[a] - AT) < 1.5:
                for corner in (a, b):
                    if corner not in number:
                        number[corner] = len(points) + len(lip)
                        lip.append(points[corner] + [0, height, 0])
                made += [(b, a, number[a]), (b, number[a], number[b])]
    points, triangles = np.vstack([points, lip]), np.vstack([triangles, made])
    return points, triangles[:, ::-1] if turned else triangles


def openings(binary, surface, *options):
    """(result of `lumen check`, candidates that are ends)."""
    ends = surface.with_suffix(".json")
    command = [binary("lumen"), "check", surface, "--ends", ends, *options]
    done = subprocess.run([str(c) for c in command], text=True, capture_output=True, timeout=240)
    found = json.loads(ends.read_text())["candidates"] if ends.exists() else []
    return done, [one for one in found if one["is_end"]]


@pytest.mark.parametrize("turned", [False, True])
def test_a_tear_with_a_lip_is_filled_and_said(binary, tmp_path, turned):
    done, ends = openings(binary, surfaces.write(tmp_path / "t.stl", *lipped(0.04, turned)))
    assert done.returncode == 0, done.stderr
    assert len(ends) == 2 and "tear in the wall" in done.stdout + done.stderr


def test_the_mouth_of_a_short_branch_stays_an_end(binary, tmp_path):
    """The branch is a third of its radius long, hardly longer than the lip of a tear."""
    done, ends = openings(binary, surfaces.write(tmp_path / "t.stl", *lipped(0.2)))
    assert done.returncode == 0, done.stderr
    assert len(ends) == 3 and "tear in the wall" not in done.stdout + done.stderr


def test_a_point_of_the_user_keeps_the_opening(binary, tmp_path):
    surface = surfaces.write(tmp_path / "t.stl", *lipped(0.1))
    options = ["--inlet", "0,0,0", "--outlet", "20,0,0", "--outlet", ",".join(map(str, AT))]
    done, ends = openings(binary, surface, *options)
    assert "tear in the wall" not in done.stdout + done.stderr
    assert len(ends) == 3, done.stderr

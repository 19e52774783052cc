"""The bundle of three.js is the pinned version and keeps its licence. The viewer unpacks what Python packs."""

import json
import pathlib
import re
import shutil
import subprocess

import numpy as np
import pytest

from common.errors import InputError
from reports.inputs.surface import Surface
from reports.page.geometry import QUANTISATION_STEPS, order_for_compression, pack_surface
from reports.page.folder import THREE_FOLDER, three_script, three_version, webp

BUNDLE = pathlib.Path("build/three.min.js")


def test_the_bundle_is_of_the_pinned_version():
    lock = json.loads((THREE_FOLDER / "package-lock.json").read_text())["packages"]
    assert lock["node_modules/three"]["version"] == three_version()
    revision = three_version().split(".")[1]
    assert f'"{revision}"' in three_script(BUNDLE), "THREE.REVISION"


def test_the_viewer_uses_nothing_that_the_bundle_lacks():
    exported = set(re.findall(r"\w+", (THREE_FOLDER / "entry.js").read_text().split("*/")[1]))
    templates = THREE_FOLDER.parent / "templates"
    used = {name for file in templates.glob("*.js") for name in re.findall(r"THREE\.(\w+)", file.read_text())}
    assert used and used <= exported


def test_the_licence_goes_with_it():
    assert "SPDX-License-Identifier: MIT" in three_script(BUNDLE)


UNPACK = """
const fs = require("fs"), vm = require("vm");
globalThis.window = globalThis;
for (const file of process.argv.slice(1, 3)) vm.runInThisContext(fs.readFileSync(file, "utf8"));
const { packed, bounds } = JSON.parse(fs.readFileSync(0, "utf8"));
const shape = window.vciViewer.unpackGeometry(packed, bounds);
console.log(JSON.stringify([Array.from(shape.getAttribute("position").array), Array.from(shape.index.array)]));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="the package nodejs is not installed")
@pytest.mark.parametrize("count", [40, 260], ids=["16 bits an index", "32 bits an index"])
def test_the_viewer_unpacks_the_surface_that_was_packed(count):
    u, v = np.meshgrid(np.linspace(0, 20, count), np.linspace(0, 2 * np.pi, count), indexing="ij")
    points = np.column_stack([u.ravel(), 1.5 * np.cos(v).ravel(), 1.5 * np.sin(v).ravel()])
    corner = np.arange(count * count).reshape(count, count)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[:-1, 1:], corner[1:, 1:]))
    triangles = np.vstack([np.column_stack([a, b, c]), np.column_stack([b, d, c])])
    shuffled = np.random.default_rng(1).permutation(count * count)
    surface = Surface(points[np.argsort(shuffled)], shuffled[triangles])
    low, high = points.min(0), points.max(0)
    packed = pack_surface(order_for_compression(surface), low, high)
    assert packed["wide"] == (count * count > QUANTISATION_STEPS)
    script = THREE_FOLDER.parent / "templates" / "viewer.js"
    text = json.dumps({"packed": packed, "bounds": [low.tolist(), high.tolist()]})
    done = subprocess.run(["node", "-e", UNPACK, BUNDLE, script], input=text, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    found, index = (np.array(one).reshape(-1, 3) for one in json.loads(done.stdout))

    def corners(p, t):
        """Quantised corners of the triangles, (m, 9) integers: each begins with its lowest corner; rows are sorted."""
        steps = np.rint((p - low) / (high - low) * QUANTISATION_STEPS).astype(int)
        rank = np.unique(steps, axis=0, return_inverse=True)[1][t]
        turned = (rank.argmin(1)[:, None] + np.arange(3)) % 3
        rows = steps[np.take_along_axis(t, turned, 1)].reshape(-1, 9)
        return rows[np.lexsort(rows.T)]

    assert found.shape == points.shape and index.shape == triangles.shape
    assert np.array_equal(corners(found, index), corners(surface.points, surface.triangles))


def test_a_picture_that_is_none_is_refused(tmp_path):
    (tmp_path / "plan.png").write_bytes(b"\x89PNG, and no more")
    with pytest.raises(InputError, match="a picture cannot be read"):
        webp(tmp_path / "plan.png")

"""The bundle of three.js is the pinned version, stands in a page as it is, and keeps its licence."""

import json
import pathlib
import re

from reports.page.assets import THREE, three_script, three_version

BUNDLE = pathlib.Path("build/three.min.js")


def test_the_bundle_is_of_the_pinned_version():
    lock = json.loads((THREE / "package-lock.json").read_text())["packages"]
    assert lock["node_modules/three"]["version"] == three_version()
    revision = three_version().split(".")[1]
    assert f'"{revision}"' in three_script(BUNDLE), "THREE.REVISION"


def test_the_viewer_uses_nothing_that_the_bundle_lacks():
    exported = set(re.findall(r"\w+", (THREE / "entry.js").read_text().split("*/")[1]))
    templates = THREE.parent / "templates"
    used = {name for file in templates.glob("*.js") for name in re.findall(r"THREE\.(\w+)", file.read_text())}
    assert used and used <= exported


def test_the_licence_goes_with_it():
    assert "SPDX-License-Identifier: MIT" in three_script(BUNDLE)

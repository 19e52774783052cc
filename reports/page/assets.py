"""Files that are embedded in the report: images, style, scripts and three.js."""

import base64
import json
import pathlib

from common.errors import InputError
from reports.inputs.reading import existing

TEMPLATES = pathlib.Path(__file__).with_name("templates")
THREE = pathlib.Path(__file__).with_name("three")
TYPES = {".svg": "image/svg+xml", ".png": "image/png"}


def image_uri(path):
    """An SVG or PNG file as a data URI."""
    data = existing(path, "reports figures").read_bytes()
    return f"data:{TYPES[path.suffix]};base64,{base64.b64encode(data).decode('ascii')}"


def optional_image(path):
    """The image's data URI, None if there is no such file."""
    return image_uri(path) if path.exists() else None


def script(path, made_by="the repository"):
    """A script's text for a <script> element; InputError if it contains the closing tag."""
    text = existing(path, made_by).read_text()
    if "</script" in text.lower():
        raise InputError("a script cannot be put in a page", path, "</script", "use another version of it")
    return text


def three_version():
    """The version of three.js that the bundle is pinned to."""
    return json.loads((THREE / "package.json").read_text())["dependencies"]["three"]


def three_script(path):
    """The viewer's library: three.js and its trackball controls in one script, as three/bundle.sh makes it."""
    return script(path, "make build")

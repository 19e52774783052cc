"""Files that are embedded in the report: images, style, scripts and three.js."""

import base64
import io
import json
import pathlib

from PIL import Image

from common.errors import InputError
from reports.inputs.reading import require_file

TEMPLATE_FOLDER = pathlib.Path(__file__).with_name("templates")
THREE_FOLDER = pathlib.Path(__file__).with_name("three")
WEBP = {"format": "WEBP", "quality": 90, "method": 6}  # a fifth of the PNG file's bytes, no difference to be seen


def image_uri(path):
    """An SVG file, or a PNG file as WebP, as a data URI; InputError if the PNG cannot be read."""
    data, kind = require_file(path, "reports figures").read_bytes(), "svg+xml"
    if path.suffix == ".png":
        packed = io.BytesIO()
        try:
            Image.open(io.BytesIO(data)).save(packed, **WEBP)
        except OSError as error:
            raise InputError("a picture cannot be read", path, error, "make it again") from error
        data, kind = packed.getvalue(), "webp"
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"


def optional_image(path):
    """The image's data URI, None if there is no such file."""
    return image_uri(path) if path.exists() else None


def script_text(path, made_by="the repository"):
    """A script's text for a <script> element; InputError if it contains the closing tag."""
    text = require_file(path, made_by).read_text()
    if "</script" in text.lower():
        raise InputError("a script cannot be put in a page", path, "</script", "use another version of it")
    return text


def three_version():
    """The version of three.js that the bundle is pinned to."""
    return json.loads((THREE_FOLDER / "package.json").read_text())["dependencies"]["three"]


def three_script(path):
    """The viewer's library: three.js and its trackball controls in one script, as three/bundle.sh makes it."""
    return script_text(path, "make build")

"""The report's folder: pages, pictures, data, and the style and scripts that its pages share."""

import contextlib
import io
import json
import os
import pathlib
import shutil
import tempfile

from PIL import Image

from common.errors import InputError
from common.files import replacing, write_table
from reports.figures.style import COLOURS
from reports.inputs.reading import require_file

TEMPLATE_FOLDER = pathlib.Path(__file__).with_name("templates")
THREE_FOLDER = pathlib.Path(__file__).with_name("three")
WEBP = {"format": "WEBP", "quality": 90, "method": 6}  # a fifth of the bytes of the PNG, and no visible difference
SCRIPTS = ("viewer.js", "stage.js", "page.js")
INDEX, BENCHMARKS = "index.html", "benchmarks.html"
# The entries of a report. A new report first removes the old index and writes its own index last. So wherever there is
# an index, the report is complete.
OWN_ENTRIES = ("assets", "cases", "data", "figures", BENCHMARKS, INDEX)


def case_page(name):
    """The address of a case's page below the report's folder."""
    return f"cases/{name}.html"


class ReportFolder:
    """The report's files below `path`. Methods take and return their names relative to it.

    data_names: the files of data/ written so far.
    """

    def __init__(self, path):
        self.path, self.data_names, self._pictures = pathlib.Path(path), set(), {}

    def write(self, name, text):
        """Writes a text file."""
        with replacing(self.path / name) as partial:
            partial.write_text(text)

    def picture(self, path, name=""):
        """Copies an SVG file, or a PNG file as WebP, into the folder and returns its name there.

        name: the new name without suffix; by default the file keeps its name. Raises InputError for a picture that is
        missing or cannot be read, and for a second picture of the same name.
        """
        path, suffix = require_file(path, "reports figures"), {".png": ".webp"}.get(path.suffix, path.suffix)
        target = f"figures/{name or path.stem}{suffix}"
        if self._pictures.setdefault(target, path) != path:
            raise InputError("two pictures have one name", path, self._pictures[target], "rename one")
        with replacing(self.path / target) as partial:
            if path.suffix == ".png":
                partial.write_bytes(webp(path))
            else:
                shutil.copyfile(path, partial)
        return target

    def optional_picture(self, path, name=""):
        """Like `picture`, but returns None if there is no such file."""
        return self.picture(path, name) if path.exists() else None

    def copy_data(self, path, made_by, name=""):
        """Copies a file into data/. Raises InputError, which names the step `made_by`, if there is no such file."""
        name = name or path.name
        with replacing(self.path / "data" / name) as partial:
            shutil.copyfile(require_file(path, made_by), partial)
        self.data_names.add(name)

    def write_data(self, name, table):
        """Writes a DataFrame into data/ as CSV, unless it has no rows."""
        if len(table):
            write_table(self.path / "data" / name, table)
            self.data_names.add(name)

    def write_assets(self, three):
        """Writes what the pages share: style with the states' colours, three.js (file `three`), and scripts."""
        colours = " ".join(f"--{state}: {colour};" for state, colour in COLOURS.items())
        self.write("assets/style.css", f"{(TEMPLATE_FOLDER / 'style.css').read_text()}:root {{ {colours} }}\n")
        self.write("assets/three.min.js", three_script(three))
        for name in SCRIPTS:
            self.write(f"assets/{name}", (TEMPLATE_FOLDER / name).read_text())


@contextlib.contextmanager
def report_folder(path):
    """Yields a ReportFolder under a temporary name. If the block succeeds, its files replace an earlier report.

    Files in `path` that no report writes stay. Raises InputError if the folder cannot be made.
    """
    path = pathlib.Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("no folder can be made here", path, error.strerror, "another folder") from error
    with tempfile.TemporaryDirectory(prefix=".partial-", dir=path) as partial:
        yield ReportFolder(partial)
        for old in (path / name for name in reversed(OWN_ENTRIES)):
            if old.is_dir():
                shutil.rmtree(old)
            old.unlink(missing_ok=True)
        for new in (pathlib.Path(partial) / name for name in OWN_ENTRIES):
            if new.exists():
                os.replace(new, path / new.name)


def webp(path):
    """The bytes of a PNG file as WebP; InputError if it cannot be read."""
    packed = io.BytesIO()
    try:
        Image.open(path).save(packed, **WEBP)
    except OSError as error:
        raise InputError("a picture cannot be read", path, error, "make it again") from error
    return packed.getvalue()


def three_version():
    """The version of three.js that the bundle is pinned to."""
    return json.loads((THREE_FOLDER / "package.json").read_text())["dependencies"]["three"]


def three_script(path):
    """The viewer's library: three.js and its trackball controls in one script, as three/bundle.sh makes it."""
    return require_file(path, "make build").read_text()

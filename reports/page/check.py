"""Opens each page of a report in headless Chromium. Refuses console errors, and references that lead nowhere or out.

It also refuses a figure or table without a line below it that names its data and how it was made.
"""

import html.parser
import pathlib
import re
import subprocess
import tempfile
import urllib.parse

from common.errors import ComputationError, InputError
from common.files import replacing
from reports.inputs.reading import require_file

BROWSER = "chromium"
BROWSER_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--enable-logging=stderr",
    "--v=0",
)
WINDOW_PIXELS = "1440,900"  # width and height of the browser's window
TIMEOUT_S = 120  # longest run of the browser
SETTLE_MS = 4000  # virtual time of a page, enough for the 3D viewer to draw its first picture
CONSOLE_LINE = re.compile(r":CONSOLE[:(]\d+\)?\] (.*)")
DRIVER_MESSAGE = re.compile(
    r'^"\[\.WebGL-\w+\]GL Driver Message \([^)]*Performance'
)  # the software renderer's own remarks
REFERENCES = {
    "src",
    "srcset",
    "href",
    "data",
    "poster",
    "action",
    "formaction",
    "background",
    "ping",
    "manifest",
}
STYLE_REFERENCE = re.compile(r"url\(\s*['\"]?(?!data:|#)([^'\")]+)|@import\s+([^;]+)", re.IGNORECASE)
SOURCED = ("figure", "table")  # elements that need a line of class SOURCE_CLASS below them
SOURCE_CLASS = "source"
MOST_NAMED = 5  # largest number of problems that a message names


class Page(html.parser.HTMLParser):
    """What an HTML text refers to, and what it lacks.

    references: values of the attributes REFERENCES, without data: URIs. styles: references within styles. ids: ids of
    its elements. unsourced: figures and tables without a line on their data. policy: its content security policy.
    """

    def __init__(self, text):
        super().__init__()
        self.references, self.styles, self.ids, self.unsourced, self.policy = [], [], set(), [], None
        self._in_style, self._open = False, None
        self.feed(text)
        self._next_sourced(None)

    def handle_starttag(self, tag, attrs):
        attributes = {name: value or "" for name, value in attrs}
        self._in_style = tag == "style"
        if tag == "meta" and attributes.get("http-equiv", "").lower() == "content-security-policy":
            self.policy = attributes.get("content", "")
        self.ids.add(attributes.get("id"))
        self.styles += style_references(attributes.get("style", ""))
        self.references += [
            value for name, value in attributes.items() if name in REFERENCES and not value.startswith("data:")
        ]
        if tag in SOURCED:
            self._next_sourced(f"{tag} at line {self.getpos()[0]}")
        elif SOURCE_CLASS in attributes.get("class", "").split():
            self._open = None

    def handle_endtag(self, tag):
        self._in_style = self._in_style and tag != "style"

    def handle_data(self, data):
        if self._in_style:
            self.styles += style_references(data)

    def _next_sourced(self, description):
        self.unsourced += [self._open] if self._open else []
        self._open = description


def style_references(text):
    """The files that a style sheet or attribute would load."""
    return [(first or second).strip() for first, second in STYLE_REFERENCE.findall(text)]


def read_pages(index):
    """{path: Page} of a report's index and of all pages that it leads to. Raises InputError, which lists what is wrong.

    Wrong are: a reference to a file that is missing or outside the report's folder; a reference to a place that a page
    does not have; a page whose policy lets it fetch files; a figure or table without a line on its data.
    """
    index = require_file(index, "reports report").resolve()
    pages, waiting, problems = {}, [index], []
    while waiting:
        path = waiting.pop()
        page = pages[path] = Page(path.read_text())
        if page.policy is None or not page.policy.startswith("default-src 'none'"):
            problems.append(f"{path.name}: no content security policy that forbids to fetch (default-src 'none')")
        problems += [f"{path.name}: style refers to {name}" for name in page.styles]
        problems += [f"{path.name}: no line on the data of the {what}" for what in page.unsourced]
        for reference in page.references:
            target, problem = resolve(reference, path, index.parent)
            if problem:
                problems.append(f"{path.name}: {reference[:80]} {problem}")
            elif target.suffix == ".css":
                problems += [f"{target.name}: refers to {name}" for name in style_references(target.read_text())]
            elif target.suffix == ".html" and target not in pages and target not in waiting:
                waiting.append(target)
    problems += [
        f"{path.name}: {reference} names no place there"
        for path, page in pages.items()
        for reference in page.references
        if "#" in reference and reference.partition("#")[2] not in place_ids(reference, path, index.parent, pages)
    ]
    if problems:
        more = len(problems) - MOST_NAMED
        named = "; ".join(problems[:MOST_NAMED]) + (f"; {more} more" if more > 0 else "")
        raise InputError("the report is not whole", index.parent, named, "make the report again")
    return pages


def resolve(reference, page, folder):
    """(file, problem) for a reference of a page; problem is None if the file is in the report's folder."""
    parts = urllib.parse.urlsplit(reference)
    if parts.scheme or parts.netloc or parts.path.startswith("/"):
        return None, "leads out of the report's folder"
    target = (page.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else page
    if not target.is_relative_to(folder):
        return None, "leads out of the report's folder"
    return target, None if target.is_file() else "is not there"


def place_ids(reference, page, folder, pages):
    """The ids of the page to which a reference leads; empty if it leads to none of `pages`."""
    target, _ = resolve(reference, page, folder)
    return pages[target].ids if target in pages else set()


def console_messages(log):
    """The page's messages on the console, uncaught exceptions included.

    Headless Chromium logs all of them at one level, so any message counts as an error.
    """
    found = (CONSOLE_LINE.search(line) for line in log.splitlines())
    return [match[1].strip() for match in found if match and not DRIVER_MESSAGE.match(match[1])]


def run_browser(path, *arguments):
    """Runs Chromium on a file with a fresh profile; returns (standard output, log). ComputationError if it fails."""
    with tempfile.TemporaryDirectory() as profile:
        command = [BROWSER, *BROWSER_FLAGS, f"--user-data-dir={profile}", f"--window-size={WINDOW_PIXELS}"]
        command += [f"--virtual-time-budget={SETTLE_MS}", *arguments, pathlib.Path(path).resolve().as_uri()]
        try:
            result = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
        except FileNotFoundError as error:
            raise InputError("no browser to check with", BROWSER, str(error), "install the package chromium") from error
        except subprocess.TimeoutExpired as error:
            raise ComputationError("the browser did not finish", path, f"{TIMEOUT_S} s", "open it by hand") from error
    if result.returncode or "</html>" not in result.stdout and "--dump-dom" in arguments:
        raise ComputationError("the browser failed", path, result.stderr[-500:], "open the page by hand")
    return result.stdout, result.stderr


def check_report(index, screenshots=None):
    """Checks a report by its index.html and returns the paths of its pages, the index first.

    screenshots: a folder for a picture of each page, WINDOW_PIXELS large. Raises InputError as `read_pages` does, and
    ComputationError for a console error or a 3D viewer that does not start.
    """
    pages = list(read_pages(index))
    for path in pages:
        check_page(path)
        if screenshots:
            with replacing(screenshots / f"{path.stem}.png") as partial:
                run_browser(path, f"--screenshot={partial.resolve()}")
    return pages


def check_page(path):
    """Opens one page. Raises ComputationError for a console error or a 3D viewer that does not start."""
    page, log = run_browser(path, "--dump-dom")
    errors = console_messages(log)
    if errors:
        remedy = "open it in a browser and see the console"
        named = "; ".join(errors[:MOST_NAMED])
        raise ComputationError("a page of the report writes to the console", path, named, remedy)
    if 'class="viewer"' in page and 'class="stage live"' not in page:
        raise ComputationError("the 3-D viewer does not start", path, "no live stage", "see the browser's console")

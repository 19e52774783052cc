"""Opens a report in headless Chromium and refuses console errors and anything fetched from outside the file."""

import html.parser
import pathlib
import re
import subprocess
import tempfile

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
TIMEOUT_S = 120  # longest run of the browser
SETTLE_MS = 4000  # virtual time of the page, enough for the 3D viewer to draw its first picture
FIRST_CASE = re.compile(r'<article class="case" id="([^"]+)"')  # the 3D viewer starts when its case is in view
CONSOLE_LINE = re.compile(r":CONSOLE[:(]\d+\)?\] (.*)")
DRIVER_MESSAGE = re.compile(
    r'^"\[\.WebGL-\w+\]GL Driver Message \([^)]*Performance'
)  # the software renderer's own remarks
FETCHING_ATTRIBUTES = {
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
STYLE_FETCH = re.compile(r"url\(\s*['\"]?(?!data:|#)([^'\")]+)|@import\s+([^;]+)", re.IGNORECASE)


class ReferenceCollector(html.parser.HTMLParser):
    """Collects an HTML page's references to other files (`outside`) and its content security policy (`policy`)."""

    def __init__(self):
        super().__init__()
        self.outside, self.policy, self.in_style = [], None, False

    def handle_starttag(self, tag, attrs):
        attributes = {name: value or "" for name, value in attrs}
        self.in_style = tag == "style"
        if tag == "meta" and attributes.get("http-equiv", "").lower() == "content-security-policy":
            self.policy = attributes.get("content", "")
        for name, value in attributes.items():
            if name in FETCHING_ATTRIBUTES and not value.startswith(("data:", "#")):
                self.outside.append(f"<{tag} {name}={value[:80]!r}>")
            if name == "style":
                self.style(value)

    def handle_endtag(self, tag):
        if tag == "style":
            self.in_style = False

    def handle_data(self, data):
        if self.in_style:
            self.style(data)

    def style(self, text):
        self.outside += [f"style: {(a or b)[:80]!r}" for a, b in STYLE_FETCH.findall(text)]


def outside_references(text):
    """Resources that an HTML text would load from elsewhere, as descriptions; empty if the page needs no other file."""
    page = ReferenceCollector()
    page.feed(text)
    if page.policy is None or not page.policy.startswith("default-src 'none'"):
        page.outside.append("no content security policy that forbids scripts to fetch (default-src 'none')")
    return page.outside


def console_messages(log):
    """The page's messages on the console, uncaught exceptions included.

    Headless Chromium logs all of them at one level, so any message counts as an error.
    """
    found = (CONSOLE_LINE.search(line) for line in log.splitlines())
    return [match[1].strip() for match in found if match and not DRIVER_MESSAGE.match(match[1])]


def run_browser(path, *arguments, size="1440,900", anchor=""):
    """Runs Chromium on a file with a fresh profile; returns (standard output, log). ComputationError if it fails.

    size: of the window in pixels; anchor: id of the element to which the page is scrolled.
    """
    with tempfile.TemporaryDirectory() as profile:
        command = [BROWSER, *BROWSER_FLAGS, f"--user-data-dir={profile}", f"--window-size={size}"]
        command += [
            f"--virtual-time-budget={SETTLE_MS}",
            *arguments,
            pathlib.Path(path).resolve().as_uri() + (anchor and f"#{anchor}"),
        ]
        try:
            result = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
        except FileNotFoundError as error:
            raise InputError("no browser to check with", BROWSER, str(error), "install the package chromium") from error
        except subprocess.TimeoutExpired as error:
            raise ComputationError("the browser did not finish", path, f"{TIMEOUT_S} s", "open it by hand") from error
    if result.returncode or "</html>" not in result.stdout and "--dump-dom" in arguments:
        raise ComputationError("the browser failed", path, result.stderr[-500:], "open the report by hand")
    return result.stdout, result.stderr


def check_report(path, screenshot=None, size="1440,900"):
    """Raises ComputationError for a console error, InputError for an outside reference; saves a picture if asked."""
    text = require_file(path, "reports report").read_text()
    outside = outside_references(text)
    if outside:
        raise InputError("the report refers to other files", path, "; ".join(outside[:5]), "put them into the file")
    first = FIRST_CASE.search(text)
    page, log = run_browser(path, "--dump-dom", anchor=first[1] if first else "")
    errors = console_messages(log)
    if errors:
        remedy = "open it in a browser and see the console"
        raise ComputationError("the report writes to the console", path, "; ".join(errors[:5]), remedy)
    if 'class="viewer"' in page and 'class="stage live"' not in page:
        raise ComputationError("the 3-D viewer does not start", path, "no live stage", "see the browser's console")
    if screenshot:
        with replacing(screenshot) as partial:
            run_browser(path, f"--screenshot={partial.resolve()}", size=size)

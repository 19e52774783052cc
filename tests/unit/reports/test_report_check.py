"""The check of a report finds faults of its pages and files that its folder lacks."""

import shutil

import pytest

from common.errors import ComputationError, InputError
from reports.page.check import Page, check_report, console_messages, read_pages

POLICY = '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; style-src file:; img-src file:">'
SOURCE = '<p class="source">Data: <a href="data/a.csv">a.csv</a></p>'

needs_chromium = pytest.mark.skipif(shutil.which("chromium") is None, reason="the package chromium is not installed")


@pytest.fixture
def report(tmp_path):
    """A folder with an index, a page of a case, a style, a picture and data, without fault."""
    files = {
        "index.html": f'<link rel="stylesheet" href="assets/style.css"><h2 id="patients">x</h2>'
        f'<a href="cases/a.html#flow">a</a><figure><img src="figures/a.svg">{SOURCE}</figure>',
        "cases/a.html": '<a href="../index.html#patients">back</a><h2 id="flow">y</h2><a href="#flow">y</a>',
        "assets/style.css": "p { color: red }",
        "figures/a.svg": "<svg/>",
        "data/a.csv": "n\n1\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"<html>{POLICY}<body>{text}</body></html>" if name.endswith("html") else text)
    return tmp_path


def test_a_whole_report_passes(report):
    assert list(read_pages(report / "index.html")) == [report / "index.html", report / "cases" / "a.html"]


@pytest.mark.parametrize("name", ["cases/a.html", "assets/style.css", "figures/a.svg", "data/a.csv"])
def test_a_single_missing_file_is_noticed(report, name):
    (report / name).unlink()
    with pytest.raises(InputError, match=f"{name}.* is not there"):
        read_pages(report / "index.html")


@pytest.mark.parametrize(
    "name, body, problem",
    [
        ("cases/a.html", '<img src="figures/a.svg">', "a.html: figures/a.svg is not there"),
        ("cases/a.html", '<a href="../index.html#cases">x</a>', "#cases names no place there"),
        ("index.html", '<a href="#nowhere">x</a>', "#nowhere names no place there"),
        ("index.html", '<script src="https://example.org/three.js"></script>', "leads out of the report's folder"),
        ("index.html", '<a href="//example.org">x</a>', "leads out of the report's folder"),
        ("index.html", '<img src="/etc/hostname">', "leads out of the report's folder"),
        ("cases/a.html", '<a href="../../other.html">x</a>', "leads out of the report's folder"),
        ("index.html", "<style>@import 'x.css';</style>", "style refers to 'x.css'"),
        ("index.html", "<style>p { background: url(tile.png) }</style>", "style refers to tile.png"),
        ("index.html", '<p style="background: url(tile.png)">', "style refers to tile.png"),
        (
            "cases/a.html",
            "<table></table><table></table>" + SOURCE.replace("data", "../data"),
            "of the table at line 1",
        ),
        ("index.html", '<figure><img src="figures/a.svg"></figure>', "no line on the data of the figure at line 1"),
    ],
)
def test_what_is_wrong_with_a_page_is_named(report, name, body, problem):
    page = report / name
    page.write_text(page.read_text().replace("</body>", f"{body}</body>"))
    with pytest.raises(InputError) as error:
        read_pages(report / "index.html")
    assert problem in str(error.value)


def test_a_style_sheet_that_refers_to_files_is_refused(report):
    (report / "assets" / "style.css").write_text("p { background: url('tile.png') }")
    with pytest.raises(InputError, match="style.css: refers to tile.png"):
        read_pages(report / "index.html")


def test_a_page_without_policy_is_refused(report):
    page = report / "cases" / "a.html"
    page.write_text(page.read_text().replace(POLICY, ""))
    with pytest.raises(InputError, match="a.html: no content security policy"):
        read_pages(report / "index.html")


def test_data_within_a_page_is_no_reference():
    page = Page(f'<html>{POLICY}<body><a href="#top">up</a><img src="data:,"></body></html>')
    assert page.references == ["#top"] and not page.unsourced


def test_console_messages_of_a_log():
    log = (
        '[1:1:1121/07:INFO:CONSOLE:1] "Uncaught ReferenceError: x", source: file:///a (1)\n'
        '[1:1:1121/07:INFO:CONSOLE(3)] "boom", source: file:///a (3)\n'
        '[1:1:1121/07:INFO:CONSOLE:0] "[.WebGL-0xf5]GL Driver Message (OpenGL, Performance, X, High): stall", source\n'
        "[1:1:1121/07:ERROR:dbus/bus.cc:405] Failed to connect to the bus\n"
    )
    messages = console_messages(log)
    assert len(messages) == 2 and "ReferenceError" in messages[0] and "boom" in messages[1]


@needs_chromium
def test_a_whole_report_is_opened_page_by_page(report, tmp_path):
    """The check saves a picture of each page."""
    pages = check_report(report / "index.html", tmp_path / "shots")
    assert pages == [report / "index.html", report / "cases" / "a.html"]
    assert sorted(path.name for path in (tmp_path / "shots").iterdir()) == ["a.png", "index.png"]


@needs_chromium
@pytest.mark.parametrize("script", ["undefined_function()", "console.error('boom')", "fetch('data.json')"])
def test_a_page_with_a_failing_script_is_refused(report, script):
    """The script fails on the page of a case, so the check must open that page too."""
    page = report / "cases" / "a.html"
    policy = POLICY.replace("'none';", "'none'; script-src 'unsafe-inline';")
    page.write_text(page.read_text().replace(POLICY, policy).replace("</body>", f"<script>{script}</script></body>"))
    with pytest.raises(ComputationError, match="console"):
        check_report(report / "index.html")

"""The documentation as a site: it builds without a warning, has every page, and the settings of the schemas."""

import html
import importlib.util
import pathlib
import re
import shutil
import subprocess

import pytest

from common.documents import schema

ROOT = pathlib.Path(__file__).resolve().parents[3]
NEEDED = ("sphinx", "myst_parser", "furo")

pytestmark = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in NEEDED), reason="run `make docs` once: it installs Sphinx"
)


def built(source, out):
    """sphinx-build as `make docs` calls it."""
    command = ["/usr/bin/sphinx-build", "-q", "-W", "--keep-going", "-c", source / "docs", "-b", "html", source, out]
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site")
    result = built(ROOT, out)
    assert result.returncode == 0 and not result.stderr, result.stderr
    return out


def test_every_page_is_there(site):
    """All pages under version control but templates, and the short ones that say what a source folder holds."""
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    folders = re.compile(r"\.github/|anatomy/src/|common/vtk/|vci/.*/README\.md|reports/page/three/README\.md")
    pages = [name for name in listed.split() if not folders.match(name)]
    missing = [name for name in pages if not (site / name).with_suffix(".html").is_file()]
    assert len(pages) > 20 and not missing
    assert "docs/index.html" in (site / "index.html").read_text()


@pytest.mark.parametrize(
    "name", ["case", "balloon", "stent", "anatomy", "deployment", "flow", "reference", "ct", "metrics"]
)
def test_settings_are_those_of_the_schemas(site, name):
    """Each key at the top of a schema is in a table, beside its description."""
    text = html.unescape(re.sub(r"<[^>]*>", "", (site / "docs" / "settings.html").read_text()))
    text = re.sub(r"\s+", " ", text)
    for key, inner in schema.read(name)["properties"].items():
        assert key in text
        # up to the first character that typography changes
        words = re.match(r"[\w ,]*", inner.get("description", ""))[0].strip() if inner else ""
        assert words in text, f"{name}.{key}"


def test_a_broken_link_fails_the_build(tmp_path):
    """A page that links to no page is a warning, and warnings fail."""
    (tmp_path / "docs").mkdir()
    for name in ("conf.py", "schema_tables.py"):
        shutil.copy(ROOT / "docs" / name, tmp_path / "docs" / name)
    for folder in ("site", "static"):
        shutil.copytree(ROOT / "docs" / folder, tmp_path / "docs" / folder)
    (tmp_path / "common").symlink_to(ROOT / "common")
    page = tmp_path / "docs" / "index.md"
    page.write_text("# Site\n[here](#site)\n")
    assert built(tmp_path, tmp_path / "out").returncode == 0
    page.write_text("# Site\n[nowhere](nowhere.md)\n")
    result = built(tmp_path, tmp_path / "out")
    assert result.returncode != 0 and "nowhere.md" in result.stderr

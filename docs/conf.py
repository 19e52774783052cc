"""The documentation as a site: `make docs` (Sphinx with MyST and furo). Each page stays with its part."""

import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1]), str(pathlib.Path(__file__).resolve().parent)]

project = "vci: virtual coronary intervention"
author = "the vci authors"
extensions = ["myst_parser", "schema_tables"]
html_theme = "furo"
html_title = project
html_static_path = ["static"]
html_css_files = ["tables.css"]
html_extra_path = ["site"]  # index.html, which leads to docs/index.html
html_copy_source = False
root_doc = "docs/index"
# Sphinx's source folder is the repository's root. The site has README.md and the pages of every part.
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/*.md",
    "anatomy/**.md",
    "vci/**.md",
    "flow/**.md",
    "data_synthetic/*.md",
    "reports/*.md",
    "whatif/*.md",
    "config/patients/*/README.md",
]
# The README of a source folder is for those who read the sources, so it is no page of the site.
source_folders = ["anatomy/src", "common/vtk", "vci/*/README.md", "vci/*/*/README.md", "reports/page/three/README.md"]
exclude_patterns = ["build*", "results", "data", ".git", ".snakemake", "tests", *source_folders]
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]

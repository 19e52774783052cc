"""Tables of docs/source-map.md from reports/page/source_map.yaml, which the report shows too.

    /usr/bin/python3 tests/verification/source_tables.py

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`.
"""

import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).resolve().parents[2])]

from page_tables import Page, markdown  # noqa: E402

from reports.page.source_map import read_source_map  # noqa: E402

HEADINGS = ["number", "what", "here", "in the report"]
EQUATION = "Equation "
PAGE_NAMES = {"index": "index", "patient": "a patient's page", "benchmarks": "benchmarks"}


def equations(_=None):
    """Markdown of the equations."""
    return table(row for row in read_source_map() if row["number"].startswith(EQUATION))


def figures(_=None):
    """Markdown of the figures and tables."""
    return table(row for row in read_source_map() if not row["number"].startswith(EQUATION))


def table(rows):
    """Markdown of rows of source_map.yaml."""
    return markdown(HEADINGS, [cells(row) for row in rows])


def cells(row):
    """The cells of a row of source_map.yaml. One without code has its remark there, as the reason."""
    number, remark = row["number"].removeprefix(EQUATION), row.get("remark", "")
    if "code" not in row:
        return [number, row["what"], f"none: {remark}", "no"]
    if not row["places"]:
        return [number, row["what"], row["code"], "index, `#source-map`: file and function"]
    return [number, row["what"], row["code"], ". ".join(filter(None, ["; ".join(map(words, row["places"])), remark]))]


def words(place):
    """A place of the report, as the page names it: page, element, what stands there, and what it needs."""
    needs = f" (needs {place['needs']})" if "needs" in place else ""
    return f"{PAGE_NAMES[place['page']]}, `#{place['section']}`: {place['words']}{needs}"


PAGE = Page("docs/source-map.md", {}, {}, {"equations": equations, "figures": figures})

if __name__ == "__main__":
    PAGE.path.write_text(PAGE.filled(PAGE.path.read_text(), None))

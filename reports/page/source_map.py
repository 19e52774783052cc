"""Where each figure, table and equation of the published study is: the rows of source_map.yaml, as links."""

import pathlib
import re

import markupsafe

from common.documents import config
from reports.page.folder import BENCHMARKS, INDEX, case_page

MARKS = re.compile(r"`([^`]+)`|\[([^\]]+)\]\([^)]+\)")  # code, or a link, in Markdown
SOURCE_MAP_FILE = pathlib.Path(__file__).with_name("source_map.yaml")


def read_source_map():
    """The rows (dicts) of source_map.yaml, with the keys of config/schemas/source_map.schema.yaml.

    Raises InputError for a value that the schema does not allow.
    """
    return config.load(SOURCE_MAP_FILE, "source_map")["rows"]


def source_map_rows(ids, names):
    """Rows {number, what, code, links, missing, remark} for the table of the index page.

    ids: {page: ids of its elements}, with pages named as in the report's folder. names: cases of the report. links:
    [{href, words, case}], relative to the index; `case` is empty for a page that is no patient's. missing:
    [{words, needs}] of the places that this report does not have; `needs` may be empty. code, remark: HTML, or empty.
    """
    rows = []
    for row in read_source_map():
        links, missing = [], []
        for place in row["places"]:
            found = next(
                ((page, name) for page, name in place_pages(place, names) if place["section"] in ids[page]), None
            )
            if found is None:
                missing.append({"words": place["words"], "needs": place.get("needs", "")})
            else:
                page, name = found
                href = f"{'' if page == INDEX else page}#{place['section']}"
                links.append({"href": href, "words": place["words"], "case": name})
        texts = {key: inline_html(row.get(key, "")) for key in ("code", "remark")}
        rows.append({"number": row["number"], "what": row["what"], **texts, "links": links, "missing": missing})
    return rows


def inline_html(text):
    """HTML (markupsafe.Markup) of a line of Markdown with code and links. Links lead out of the report, so they go."""
    escaped = str(markupsafe.escape(text))
    return markupsafe.Markup(MARKS.sub(lambda m: f"<code>{m[1]}</code>" if m[1] else m[2], escaped))


def place_pages(place, names):
    """[(page, case)] on which a place may be, in order. `case` is empty for a page that is no patient's."""
    if place["page"] == "patient":
        return [(case_page(name), name) for name in names if name in (place["cases"] or names)]
    return [(INDEX if place["page"] == "index" else BENCHMARKS, "")]

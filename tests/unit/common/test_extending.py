"""docs/extending.md: the places that it names exist."""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[3]
PLACE = re.compile(r"`((?:vci|anatomy|flow|reports|common|config|workflow|tests)/[\w./-]*)`")


def missing(text):
    """Files and folders named in a page that are not there."""
    return [place for place in PLACE.findall(text) if not (ROOT / place).exists()]


def test_places_exist():
    text = (ROOT / "docs" / "extending.md").read_text()
    assert len(PLACE.findall(text)) > 20 and not missing(text)


def test_a_place_that_is_gone_is_found():
    assert missing("`vci/wall/` and `vci/wall/nothing.hpp`") == ["vci/wall/nothing.hpp"]

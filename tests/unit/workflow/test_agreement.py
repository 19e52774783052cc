"""The page on a study beside another system's manifest: what agrees, what is too far off, what is missing."""

import copy
import json

import pytest

from common.errors import ComputationError
from workflow import agreement

NUMBERS = {"mean_area_mm2": 5.0, "minimum_area_mm2": 2.0, "mean_curvature_per_mm": 0.1}
FFR = {"ffr": 0.9, "ffr_error_estimate": 0.001}


def manifest(system, packages):
    states = {"pre": {**NUMBERS, **FFR}, "reference": dict(NUMBERS)}
    same = {"anatomy": {"lumen.vtp": "a", "anatomy.json": "b"}}
    return {
        "schema": "vci-manifest-1",
        "made_on": {"system": system, "processor": "any", "environment": {}, "packages": packages},
        "cases": {"one": {"same": same, "numbers": states}},
    }


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A function from what is changed in the study's document to the page's text and the error, or None."""
    shipped = tmp_path / "nine.json"
    shipped.write_text(json.dumps(manifest("Debian GNU/Linux 12 (bookworm)", {"gmsh": "4.8", "numpy": "1"})))

    def write(change):
        study = manifest("Debian GNU/Linux 13 (trixie)", {"gmsh": "4.13", "numpy": "1"})
        study["cases"]["one"]["same"]["anatomy"]["lumen.vtp"] = "other"
        change(study["cases"]["one"]["numbers"])
        monkeypatch.setattr(agreement, "build_manifest", lambda folder: copy.deepcopy(study))
        out, error = tmp_path / "page.md", None
        try:
            agreement.write_agreement(shipped, tmp_path, out)
        except ComputationError as raised:
            error = raised
        return out.read_text(), error

    return write


def test_the_page_names_both_systems_versions_and_bits(written):
    text, error = written(lambda numbers: None)
    assert error is None
    assert "# The nine cohort on Debian 13 and Debian 12" in text
    assert "| `gmsh` | 4.8 | 4.13 |" in text and "numpy" not in text
    assert "| anatomy | 2 | 1 |" in text
    assert "Of 7 numbers 7 agree" in text


def test_the_page_of_the_documentation_has_the_title_of_its_manifest(repo_root):
    shipped = json.loads((repo_root / "config" / "manifests" / "quick.json").read_text())
    title = (repo_root / "docs" / "debian13.md").read_text().splitlines()[0]
    found = manifest("Debian GNU/Linux 13 (trixie)", {})
    assert (
        agreement.markdown_page("quick", shipped, found, agreement.compare_numbers(shipped, found)).splitlines()[0]
        == title
    )


@pytest.mark.parametrize(
    "state, key, value, within",
    [
        ("pre", "mean_area_mm2", 5.0 * 1.009, True),
        ("pre", "mean_area_mm2", 5.0 * 1.011, False),
        ("reference", "minimum_area_mm2", 2.0 * 0.981, True),
        ("reference", "minimum_area_mm2", 2.0 * 0.979, False),
        ("pre", "ffr", 0.9019, True),  # both estimates are .001
        ("pre", "ffr", 0.9021, False),
        ("pre", "ffr", None, False),
    ],
)
def test_numbers_have_their_limits(written, state, key, value, within):
    text, error = written(lambda numbers: numbers[state].update({key: value}))
    assert (error is None) == within
    assert (f"Of 7 numbers {7 if within else 6} agree") in text
    assert text.count("**") == (0 if within else 4)  # in the table of all, and in that of the largest


def test_a_state_that_is_missing_is_not_passed_over(written):
    text, error = written(lambda numbers: numbers.pop("reference"))
    assert "Of 7 numbers 4 agree" in text
    assert "3 of 7 numbers" in str(error)

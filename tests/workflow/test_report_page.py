"""The finished report of the quick cohort opens from disk without console errors or network, and is complete.

The environment variable VCI_REPORT names the report. Without it the tests are skipped, since the study takes minutes.
"""

import csv
import hashlib
import os
import pathlib

import pytest

from reports.page.check import check_report
from reports.page.sources import SOURCES

CASES = ("quick_focal", "quick_branch")


@pytest.fixture(scope="module")
def report():
    """results/report/index.html of a finished quick study."""
    name = os.environ.get("VCI_REPORT")
    if not name:
        pytest.skip("VCI_REPORT is not set: make study COHORT=quick, then VCI_REPORT=results/report/index.html")
    path = pathlib.Path(name)
    assert path.is_file(), f"{path} was not made"
    return path


def test_opens_from_disk_without_error_or_network(report):
    """Every page, with every file that it names."""
    assert len(check_report(report)) >= 1 + len(CASES)


def test_shows_every_case_and_the_published_agreement(report):
    index = report.read_text()
    for case in CASES:
        assert f'href="cases/{case}.html"' in index
        assert f"<h1>{case}</h1>" in (report.parent / "cases" / f"{case}.html").read_text()
    for number in ("1.55", "1.89"):
        assert number in index, "published agreement of the cross-sectional area"


def test_hands_out_the_data_of_every_figure_and_table(report):
    wanted = {name.format(case=case) for source in SOURCES.values() for name in source.data for case in CASES}
    assert wanted - {"failed.csv"} <= {path.name for path in (report.parent / "data").iterdir()}


def test_nine_patients_stay_within_15_mb(report):
    """The size for nine patients is estimated: nine times the larger case, and the study's own files grow with the
    number of patients."""
    files = [path for path in report.parent.rglob("*") if path.is_file()]
    sizes = {path: path.stat().st_size for path in files}
    of_case = {case: sum(sizes[path] for path in files if path.name.startswith(case)) for case in CASES}
    fixed = sum(sizes[path] for path in files if path.parent.name == "assets")
    of_study = sum(sizes.values()) - sum(of_case.values()) - fixed
    assert fixed + 9 * max(of_case.values()) + 9 / len(CASES) * of_study < 15e6


def test_names_the_provenance_by_its_hash(report):
    provenance = report.parents[1] / "study" / "provenance.json"
    assert hashlib.sha256(provenance.read_bytes()).hexdigest() in report.read_text()


def test_numbers_stand_behind_the_page(report):
    """The rows of agreement.csv cover both cases."""
    with open(report.parents[1] / "study" / "agreement.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert rows
    assert {int(row["n"]) for row in rows if row.get("n")} == {len(CASES)}

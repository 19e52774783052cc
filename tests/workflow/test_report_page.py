"""The finished report of the quick cohort: opens from disk without console error or network, and shows what it must.

VCI_REPORT names the report; without it the test is skipped, since making it takes minutes.
"""

import csv
import hashlib
import os
import pathlib

import pytest

from reports.page.check import check_report

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
    check_report(report)


def test_shows_every_case_and_the_published_agreement(report):
    page = report.read_text()
    for case in CASES:
        assert case in page
    for number in ("1.55", "1.89"):
        assert number in page, "published agreement of the cross-sectional area"


def test_names_the_provenance_by_its_hash(report):
    provenance = report.parents[1] / "study" / "provenance.json"
    assert hashlib.sha256(provenance.read_bytes()).hexdigest() in report.read_text()


def test_numbers_stand_behind_the_page(report):
    """The agreement covers both cases, and its rows are numbers."""
    with open(report.parents[1] / "study" / "agreement.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert rows
    assert {int(row["n"]) for row in rows if row.get("n")} == {len(CASES)}

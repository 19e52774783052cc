"""tests/fuzz/page.py: the page on damaged files has a row for each reader, from its log alone."""

import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "fuzz")]

import page  # noqa: E402


def _log(name):
    if name.startswith("python."):
        return f"{name[7:]}: 2000 mutants in 600 s of processor time, 3 read, 1 faults\n"
    return "SUMMARY: AddressSanitizer: 8 bytes\nstat::number_of_executed_units: 1234567\n"


def test_each_reader_has_a_row_with_its_files_and_faults():
    text = page.page(_log, 600, "abc12345")
    rows = [line for line in text.splitlines() if line.startswith("| ")][2:]
    assert len(rows) == 3 + 7 + 4 and len(set(rows)) == len(rows)
    assert "| mask (.nrrd) | C++ | 1,234,567 | 1 |" in rows and "| case | Python | 2,000 | 1 |" in rows
    assert "FUZZ_SECONDS=600" in text and "revision abc12345" in text


@pytest.mark.parametrize("broken", ["surface.ply", "python.study"])
def test_a_reader_that_did_not_end_makes_no_page(broken):
    with pytest.raises(ValueError, match=broken.split(".", maxsplit=1)[1] if "python" in broken else broken):
        page.page(lambda name: "" if name == broken else _log(name), 600, "abc12345")


def test_the_readers_are_those_that_are_run():
    lines = (ROOT / "tests" / "fuzz" / "run.sh").read_text().splitlines()
    line = next(one for one in lines if one.startswith("readers="))
    for name in page.CPP_READERS:
        assert name.split(".")[0] in line and name.split(".")[-1] in line
    for name in page.PYTHON_READERS:
        assert name in line[line.index("python.") :]

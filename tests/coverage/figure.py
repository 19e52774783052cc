"""Prints the share of lines that the tests ran, from cpp.json (gcovr) and python.json (coverage) of a folder.

--readme FILE writes it between the marks <!-- coverage --> and <!-- end --> of that page too.
"""

import argparse
import json
import pathlib
import re

COVERAGE_MARKS = re.compile(r"(<!-- coverage -->).*?(<!-- end -->)", re.S)


def coverage_sentence(folder):
    """The figures in one sentence. C++ is left out without cpp.json. Raises FileNotFoundError without python.json."""
    shares = {}
    if (folder / "cpp.json").exists():
        shares["C++"] = json.loads((folder / "cpp.json").read_text())["line_percent"]
    shares["Python"] = json.loads((folder / "python.json").read_text())["totals"]["percent_covered"]
    parts = " and ".join(f"{share:.0f} % of the lines in {language}" for language, share in shares.items())
    return f"The tests run {parts} (`make coverage`)."


def main():
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--readme", type=pathlib.Path)
    options = parser.parse_args()
    said = coverage_sentence(options.folder)
    print(said)
    if options.readme:
        text, count = COVERAGE_MARKS.subn(rf"\1{said}\2", options.readme.read_text())
        if count != 1:
            raise SystemExit(f"{options.readme} lacks the marks of the coverage")
        options.readme.write_text(text)


if __name__ == "__main__":
    main()

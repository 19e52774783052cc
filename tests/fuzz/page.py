"""Writes docs/fuzzing.md from the logs of `make fuzz`.

    page.py --logs build-fuzz --seconds 600 --out docs/fuzzing.md
"""

import argparse
import pathlib
import re
import subprocess

PAGE_HEAD = """# What the readers do with damaged files

Does a damaged input file crash a program, or is it refused with a message? `make fuzz FUZZ_SECONDS={seconds}` tests
this and writes this page. Each reader of files gets damaged copies of sound files for {seconds} seconds. It must read
each copy or refuse it with a message. Anything else is a fault: a crash, memory that is not freed, undefined
behaviour, or a file that takes too long (25 seconds in C++, 5 in Python).

The table has the number of damaged files that each reader got, and the faults. The sources are of revision {revision}.

| reader | language | files | faults |
| --- | --- | --- | --- |
"""
PAGE_TAIL = """
For the C++ readers libFuzzer chooses the changes by the code that they reach. These readers run under the address and
undefined-behaviour sanitizers. The Python readers get random changes of lines, words, numbers and bytes. One leak in
VTK is left out; `tests/fuzz/leaks.txt` names it. A file that causes a fault is kept in `build-fuzz/found`.
"""
CPP_READERS = {
    "scene": "scene of the deployment",
    "lumen": "lumen of the deployment (.vtp)",
    "centreline": "centreline of the deployment (.vtp)",
    **{f"surface.{suffix}": f"surface (.{suffix})" for suffix in ("stl", "vtp", "ply", "obj")},
    **{f"surface.{suffix}": f"mask (.{suffix})" for suffix in ("nii", "nrrd", "mha")},
}
PYTHON_READERS = {"contours": "contour table", "case": "case", "study": "study", "device": "device family"}


def libfuzzer_row(name, log):
    """Row of a reader from libFuzzer's log. Raises ValueError if the log has no final count."""
    count = re.search(r"number_of_executed_units:\s*(\d+)", log)
    if not count:
        raise ValueError(f"{name}: the log does not say how many files were read")
    faults = len(re.findall(r"^SUMMARY: ", log, re.M))
    return f"| {CPP_READERS[name]} | C++ | {int(count[1]):,} | {faults} |"


def python_row(name, log):
    """Row of a reader from the output of python_readers.py. Raises ValueError if it has no final count."""
    found = re.search(rf"^{name}: (\d+) mutants in .* (\d+) faults$", log, re.M)
    if not found:
        raise ValueError(f"{name}: the log does not say how many files were read")
    return f"| {PYTHON_READERS[name]} | Python | {int(found[1]):,} | {found[2]} |"


def page(logs, seconds, revision):
    """Text of the page. logs: function of a reader's name, such as python.case, that returns the text of its log."""
    rows = [libfuzzer_row(name, logs(name)) for name in CPP_READERS]
    rows += [python_row(name, logs(f"python.{name}")) for name in PYTHON_READERS]
    return PAGE_HEAD.format(seconds=seconds, revision=revision) + "\n".join(rows) + "\n" + PAGE_TAIL


def main():
    """The command: writes the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--logs", type=pathlib.Path, required=True, help="folder of scene.log, ..., python.study.log")
    parser.add_argument("--seconds", type=int, required=True, help="that each reader ran")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    command = ["git", "describe", "--always", "--dirty", "--abbrev=8"]
    revision = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    text = page(lambda name: (options.logs / f"{name}.log").read_text(errors="replace"), options.seconds, revision)
    options.out.write_text(text)


if __name__ == "__main__":
    main()

"""Fuzzes the readers that are Python: contour tables, cases, the study, device families.

Mutants of sound files are read in this process. Each is read, or refused by one UserError. What ends otherwise stays in
the folder and is named.

    PYTHONPATH=. /usr/bin/python3 tests/fuzz/python_readers.py --seconds 60 --out build-fuzz/found
"""

import argparse
import pathlib
import random
import sys
import time
import traceback
import warnings

import numpy as np

from anatomy.contours import pullback
from common.documents import config
from common.errors import UserError

ROOT = pathlib.Path(__file__).resolve().parents[2]
LONGEST_S = 5  # of processor time, for a file of some kB
LINES = [
    "",
    "&a",
    "*a",
    "!!python/object:os.system",
    "<<: *a",
    "- - -",
    "? : ?",
    "nan",
    ".inf",
    "1e400",
    "\t",
    "\ufeff",
    "\0",
]


def outlines(step_mm=0.5, frames=6, points=12):
    """A contour table of round outlines."""
    angle = 2 * np.pi * np.arange(points) / points
    rows = [(k, 4 + 1.5 * np.cos(a), 4 + 1.5 * np.sin(a), k * step_mm) for k in range(frames) for a in angle]
    return "frame,x_mm,y_mm,z_mm\n" + "".join(f"{k},{x:.4f},{y:.4f},{z:.4f}\n" for k, x, y, z in rows)


READERS = {  # name: (seeds, suffix, function of a path)
    "contours": ([outlines(), outlines().replace(",", "\t")], ".csv", lambda path: pullback.read({"lumen": path})),
    "case": ([file.read_text() for file in sorted(ROOT.glob("config/cases/*.yaml"))], ".yaml", config.load_case),
    "study": ([(ROOT / "config" / "study.yaml").read_text()], ".yaml", config.load_study),
    "device": ([file.read_text() for file in sorted(ROOT.glob("config/devices/*.yaml"))], ".yaml", config.load_device),
}


def mutant(text, numbers):
    """The text as bytes, with one or four random changes of bytes, words or lines."""
    data = text.encode()
    for _ in range(numbers.choice([1, 1, 1, 4])):
        lines = data.split(b"\n")
        line, kind = numbers.randrange(len(lines)), numbers.randrange(7)
        if kind == 0:
            at = numbers.randrange(len(data) + 1)
            data = data[:at] + bytes([numbers.randrange(256)]) + data[at + numbers.randrange(3) :]
            continue
        words = lines[line].split(b" " if b" " in lines[line] else b",")
        if kind == 1:
            words[numbers.randrange(len(words))] = numbers.choice(LINES + ["-1", "0", "1e308", "9" * 400]).encode()
            lines[line] = b" ".join(words) if b" " in lines[line] else b",".join(words)
        elif kind == 2:
            lines[line] = numbers.choice(LINES).encode()
        elif kind == 3:
            del lines[line]
        elif kind == 4:
            lines.insert(numbers.randrange(len(lines)), lines[line])
        elif kind == 5:
            lines[line] = b" " * numbers.randrange(1, 5) + lines[line]
        else:
            lines[line] = lines[line][: numbers.randrange(len(lines[line]) + 1)]
        data = b"\n".join(lines)
    return data


def complaint(read, path):
    """(complaint, whether the file was read). The complaint is "" if the reader answers or refuses in time."""
    begin = time.process_time()
    try:
        read(path)
        complaint_text, was_read = "", True
    except UserError:
        complaint_text, was_read = "", False
    except Exception:
        complaint_text, was_read = traceback.format_exc(limit=-3), False
    seconds = time.process_time() - begin
    return complaint_text or (f"took {seconds:.1f} s" if seconds > LONGEST_S else ""), was_read


def fuzz(name, seconds, seed, out):
    """Reads mutants for `seconds` of processor time; returns the number of faults."""
    seeds, suffix, read = READERS[name]
    numbers, begin, count, read_well, faults = random.Random(f"{name} {seed}"), time.process_time(), 0, 0, 0
    path = out / f"{name}{suffix}"
    for text in seeds:
        path.write_text(text)
        assert complaint(read, path) == ("", True), name
    while time.process_time() - begin < seconds:
        path.write_bytes(mutant(numbers.choice(seeds), numbers))
        complaint_text, was_read = complaint(read, path)
        count, read_well = count + 1, read_well + was_read
        if complaint_text:
            faults += 1
            path.rename(out / f"{name}-{seed}-{count}{suffix}")
            print(f"{name}-{seed}-{count}{suffix}: {complaint_text}", flush=True)
    path.unlink(missing_ok=True)
    print(f"{name}: {count} mutants in {seconds:g} s of processor time, {read_well} read, {faults} faults", flush=True)
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60, help="of processor time for each reader (60)")
    parser.add_argument("--seed", default="1", help="for other mutants (1)")
    parser.add_argument("--readers", nargs="+", default=sorted(READERS), choices=sorted(READERS), help="default: all")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for what is found")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")  # about overflowing numbers, which the checks refuse
    sys.exit(1 if sum(fuzz(name, options.seconds, options.seed, options.out) for name in options.readers) else 0)


if __name__ == "__main__":
    main()

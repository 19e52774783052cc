"""Seeded mutations of sound input files, and what `lumen check` does with them.

Run: /usr/bin/python3 tests/verification/anatomy/fuzz.py FOLDER [--count 1000] [--seed 0] [--formats m.nii ...]: every
input that ends otherwise than by success or one refusal stays in FOLDER and is named on standard output.
"""

import argparse
import gzip
import os
import pathlib
import resource
import subprocess
import sys

import masks
import numpy as np
import surfaces

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from places import build_folder  # noqa: E402

LUMEN = build_folder() / "lumen"
SECONDS, MEMORY_GIB = 20, 4
HEADER = 400  # bytes in which half of the mutations fall: headers are where readers go astray
NUMBERS = [
    b"0",
    b"-1",
    b"1",
    b"2",
    b"7",
    b"255",
    b"65536",
    b"2147483647",
    b"-2147483648",
    b"4294967296",
    b"1e308",
    b"nan",
]
WORDS = [b"", b"float", b"double", b"char", b"uint", b"list", b"x", b"\0", b"%s%n", b"A" * 300, b"\n", b"\n\n", b"inf"]


def _tube():
    return surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 12, 1.0)


def _ascii(path, writer):
    writer.SetFileName(str(path))
    writer.SetInputData(surfaces.polydata(*_tube()))
    writer.SetFileTypeToASCII()
    writer.Write()
    return path


def _xml(path, mode):
    writer = surfaces.vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(surfaces.polydata(*_tube()))
    {"ascii": writer.SetDataModeToAscii, "appended": writer.SetDataModeToAppended}[mode]()
    writer.Write()
    return path


def _mask(path, writer):
    matrix = masks.affine([0.5] * 3)
    inside = masks.capsules(masks.voxels((34, 16, 16), matrix), [((3.5, 4, 4), (13, 4, 4), 1.6, 1.6)])
    return writer(path, inside.astype(int), matrix)


def _pair(path, suffix):
    """The header of a mask whose voxels lie beside it in `voxels.raw`, which stay as they are."""
    whole = _mask(path.parent / f"whole{suffix}", masks.WRITERS[suffix]).read_bytes()
    mark = b"\n\n" if suffix == ".nrrd" else b"LOCAL\n"
    at = whole.index(mark)
    (path.parent / "voxels.raw").write_bytes(whole[at + len(mark) :])
    head = whole[:at]
    path.write_bytes(head + (b"\ndata file: voxels.raw\n\n" if suffix == ".nrrd" else b"voxels.raw\n"))
    return path


FORMATS = {
    "binary.stl": lambda path: surfaces.write(path, *_tube()),
    "ascii.stl": lambda path: _ascii(path, surfaces.vtk.vtkSTLWriter()),
    "binary.ply": lambda path: surfaces.write(path, *_tube()),
    "ascii.ply": lambda path: _ascii(path, surfaces.vtk.vtkPLYWriter()),
    "o.obj": lambda path: surfaces.write(path, *_tube()),
    "ascii.vtp": lambda path: _xml(path, "ascii"),
    "appended.vtp": lambda path: _xml(path, "appended"),
    "m.nii": lambda path: _mask(path, masks.nifti),
    "m.nii.gz": lambda path: _mask(path, masks.nifti),
    "m.nrrd": lambda path: _mask(path, masks.nrrd),
    "m.mha": lambda path: _mask(path, masks.meta),
    "m.nhdr": lambda path: _pair(path, ".nrrd"),
    "m.mhd": lambda path: _pair(path, ".mha"),
}


def mutated(content, random):
    """A copy of the bytes with one to four changes: bytes or bits set, pieces cut, doubled or moved, numbers and words
    of a text replaced, the end lost."""
    data = bytearray(content)
    for _ in range(random.integers(1, 5)):
        limit = max(1, min(len(data), HEADER) if random.random() < 0.5 else len(data))
        at, kind = int(random.integers(limit)), int(random.integers(7))
        length = int(random.integers(1, 40))
        if kind == 0:
            data[at : at + 1] = bytes([random.integers(256)])
        elif kind == 1:
            data[at : at + 1] = bytes([(data[at] if data else 0) ^ (1 << int(random.integers(8)))])
        elif kind == 2:
            del data[at : at + length]
        elif kind == 3:
            data[at:at] = data[int(random.integers(limit)) :][:length]
        elif kind == 4 and random.random() < 0.3:
            del data[at:]
        elif kind == 5:
            data[at : at + 4] = random.choice(np.array([0, -1, 1, 2**31 - 1, -(2**31), 10**8], "<i4")).tobytes()
        else:
            _replace_word(data, at, random)
    return bytes(data)


def _replace_word(data, at, random):
    """Puts a number in the place of the next number of a text, or a word in that of the next word."""
    if random.random() < 0.6:
        accepted, words = b"0123456789.-+e", NUMBERS
    else:
        accepted, words = bytes(range(33, 127)), WORDS
    while at < len(data) and data[at] not in accepted:
        at += 1
    end = at
    while end < len(data) and data[end] in accepted:
        end += 1
    data[at:end] = words[int(random.integers(len(words)))]


def _limit():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_GIB << 30, MEMORY_GIB << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def complaint(lumen, path):
    """What is wrong with how `lumen check` ends on a file: "" after success (0) or one refusal (2 or 3)."""
    command = [str(lumen), "check", str(path)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, capture_output=True, timeout=SECONDS, preexec_fn=_limit, env=environment)
    except subprocess.TimeoutExpired:
        return f"no end after {SECONDS} s"
    if done.returncode not in (0, 2, 3):
        return f"exit code {done.returncode}: {done.stderr[-200:].decode(errors='replace')}"
    if done.returncode and done.stderr.count(b"error: ") != 1:
        return f"{done.stderr.count(b'error: ')} error messages: {done.stderr[-300:].decode(errors='replace')}"
    return ""


def run(lumen, folder, name, count, seed):
    """[(path, complaint)] of `count` mutations of one format; files that give none are removed."""
    sound = FORMATS[name](folder / name)
    assert complaint(lumen, sound) == "", complaint(lumen, sound)
    content = sound.read_bytes()
    packed = name.endswith(".gz")
    found = []
    for k in range(count):
        random = np.random.default_rng([seed, sorted(FORMATS).index(name), k])
        inner = packed and random.random() < 0.8  # else the compressed bytes themselves
        data = mutated(gzip.decompress(content) if inner else content, random)
        path = folder / f"{seed}-{k}-{name}"
        path.write_bytes(gzip.compress(data, 1, mtime=0) if inner else data)
        why = complaint(lumen, path)
        if why:
            found.append((path, why))
        else:
            path.unlink()
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=1000, help="mutations of each format")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--formats", nargs="*", default=sorted(FORMATS), choices=sorted(FORMATS))
    parser.add_argument("--lumen", type=pathlib.Path, default=LUMEN)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for one in options.formats:
        for where, reason in run(options.lumen, options.folder, one, options.count, options.seed):
            print(where, reason, flush=True)

"""Seeds and seeded mutants of the files that the deployment engine reads; as a program it writes them to folders."""

import argparse
import copy
import json
import pathlib
import random
import re
import tempfile

import vtk

from common import vtp
from vci.benchmarks import scenes

ROOT = pathlib.Path(__file__).resolve().parents[2]
READERS = ("scene", "lumen", "centreline")
TUBE = scenes.Tube(length=16, edge=1.2, lesion_length=6)  # the vessel of the targets; its lumen has 150 points
NUMERICS = {"maximal_steps_per_stage": 2, "device_edge_mm": 1.2}  # an accepted file must not take long
ODD_VALUES = [None, True, -1, 0, 1e308, -1e308, 10**30, "", "main", [], {}, [[]], "1e9", 1e-320, 3.5]


def mutate_bytes(content, numbers):
    """The content after 1, 3 or 20 changes: bytes changed, cut out or doubled, the end cut off, or a digit replaced."""
    content = bytearray(content)
    for _ in range(numbers.choice([1, 1, 3, 20])):
        at = numbers.randrange(len(content))
        kind = numbers.randrange(5)
        if kind == 0:
            content[at] = numbers.randrange(256)
        elif kind == 1:
            del content[at : at + numbers.randrange(1, 200)]
        elif kind == 2:
            content[at:at] = content[at : at + numbers.randrange(1, 60)]
        elif kind == 3:
            del content[at:]
            break
        else:
            digits = [k for k, c in enumerate(content[:4000]) if chr(c).isdigit()]
            if digits:
                content[numbers.choice(digits)] = ord(numbers.choice("0123456789-."))
        if not content:
            break
    return bytes(content)


def value_paths(node, path=()):
    """Paths of all values in a document."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in items:
        yield path + (key,)
        yield from value_paths(value, path + (key,))


def replace_with_odd_value(content, numbers):
    """(JSON text with one of its values replaced by an odd one, what was replaced)."""
    document = json.loads(content)
    *parents, last = numbers.choice(list(value_paths(document)))
    node = document
    for key in parents:
        node = node[key]
    value = numbers.choice(ODD_VALUES)
    node[last] = value
    return json.dumps(document), f"{(*parents, last)} = {value!r}"


def vtp_encodings(data):
    """name -> bytes of a vtkPolyData in each form in which VTK writes it."""
    written = {}
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "file.vtp"
        for mode in ("Ascii", "Binary", "Appended"):
            for compressor in ("None", "ZLib", "LZ4", "LZMA"):
                for raw in (False, True):
                    for header in (32, 64):
                        if mode == "Ascii" and (compressor, header) != ("None", 32) or mode != "Appended" and raw:
                            continue
                        writer = vtk.vtkXMLPolyDataWriter()
                        writer.SetInputData(data)
                        writer.SetFileName(str(file))
                        getattr(writer, f"SetDataModeTo{mode}")()
                        getattr(writer, f"SetCompressorTypeTo{compressor}")()
                        writer.SetBlockSize(1024)  # bytes, so that the lumen's points fill several blocks
                        writer.SetEncodeAppendedData(not raw)
                        (writer.SetHeaderTypeToUInt64 if header == 64 else writer.SetHeaderTypeToUInt32)()
                        writer.Write()
                        name = f"{mode}_{compressor}_{'raw' if raw else 'base64'}_{header}".lower()
                        written[name] = file.read_bytes()
    return written


def _scenes(folder):
    """name -> document: plain; plaque, folding and kissing; springs with textbook integration; a side branch."""
    plain = json.loads(scenes.write_scene(folder, TUBE, length=6.0, numerics=NUMERICS).read_text())
    full = json.loads(
        scenes.write_scene(
            folder,
            TUBE,
            length=6.0,
            shifts=(0.0, 2.0),
            kissing=0.8,
            folding={"wings": 3, "shaft_diameter_mm": 0.5, "membrane_thickness_mm": 0.02, "wrap": "clockwise"},
            wall={"plaque": {"fibrous": {"youngs_modulus_mpa": 2}, "calcified": {"yield_strain": None}}},
            numerics={"initial_step_ms": 0.3, "pcg_precision": "double", "contact_surface": "facets"},
        ).read_text()
    )
    full["segment"] = {"branch": "main", "s_start_mm": 4, "s_end_mm": 12}
    springs = copy.deepcopy(plain)
    springs["wall"] = {"model": "mass-spring", "spring_mapping": "van_gelder"}
    springs["numerics"] = {"integration": "textbook", "fixed_step_ms": 0.01, "velocity_stop_mm_per_ms": 1e-4}
    side = copy.deepcopy(plain)
    side["procedure"][-1]["action"] = "side_branch_opening"
    side["procedure"][-1]["devices"][0]["branch"] = "side"
    return {"plain": plain, "full": full, "springs": springs, "side": side}


def _with_side_branch(data):
    """The centreline with a second line that leaves it halfway."""
    points = vtp.points(data)
    first, second = [tuple(p) for p in points], [tuple(points[len(points) // 2] + [0.5 * k, 0, k]) for k in range(6)]
    result = scenes.polydata(first + second, [range(len(first)), range(len(first), len(first + second))], lines=True)
    names = vtk.vtkStringArray()
    names.SetName("branch_name")
    for name in ("main", "side"):
        names.InsertNextValue(name)
    result.GetCellData().AddArray(names)
    return result


def seeds():
    """reader -> {name: bytes}: files that are read without a complaint."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        documents = _scenes(folder)
        lumen, centreline = (vtp.read(folder / f"{name}.vtp", "") for name in ("lumen", "centreline"))
    branches = {f"side_{name}": content for name, content in vtp_encodings(_with_side_branch(centreline)).items()}
    return {
        "scene": {name: json.dumps(document).encode() for name, document in documents.items()},
        "lumen": vtp_encodings(lumen),
        "centreline": vtp_encodings(centreline) | branches,
    }


def mutants(reader, of, count, seed):
    """`count` mutants (bytes) of a reader's seeds {name: bytes}. Every second mutant of a scene has an odd value."""
    numbers = random.Random(f"{reader} {seed}")
    for k in range(count):
        content = of[numbers.choice(sorted(of))]
        yield replace_with_odd_value(content, numbers)[0].encode() if reader == "scene" and k % 2 else mutate_bytes(
            content, numbers
        )


def dictionary(reader, contents):
    """libFuzzer's dictionary: the words of a reader's seeds; of scenes also the keys that the engine asks for."""
    text = b"\n".join(contents).decode()
    if reader == "scene":
        sources = (file.read_text() for file in sorted((ROOT / "vci").rglob("*.cpp")))
        text += "\n".join(source for source in sources if "checked_json.hpp" in source)
    words = re.findall(r'"([a-z_-]{3,40})"' if reader == "scene" else r'[A-Za-z]+="[^"]*"|<[A-Za-z]+', text)
    escaped = (word.replace("\\", "\\\\").replace('"', '\\"') for word in sorted(set(words)))
    return "".join(f'"{word}"\n' for word in escaped)


def main():
    """Writes DIR/READER/NAME, DIR/READER.dict and, where asked for, mutants DIR/READER/mutant_K."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder")
    parser.add_argument("--mutants", type=int, default=0, help="of each reader's files")
    parser.add_argument("--seed", default="", help="for other mutants")
    options = parser.parse_args()
    for reader, files in seeds().items():
        folder = options.out / reader
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)
        for k, content in enumerate(mutants(reader, files, options.mutants, options.seed)):
            (folder / f"mutant_{k:05}").write_bytes(content)
        readable = [content for name, content in files.items() if reader == "scene" or "ascii" in name]
        (options.out / f"{reader}.dict").write_text(dictionary(reader, readable))


if __name__ == "__main__":
    main()

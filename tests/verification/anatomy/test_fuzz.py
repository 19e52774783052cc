"""Damaged files of every format are read or refused with one message, in limited time and memory (see fuzz.py)."""

import fuzz
import pytest

COUNT = 25


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(fuzz.FORMATS))
def test_no_mutation_crashes_or_hangs(binary, tmp_path, name):
    found = fuzz.run(binary("lumen"), tmp_path, name, COUNT, seed=1)
    assert not found, "\n".join(f"{path.name}: {why}" for path, why in found)


def refused(lumen, path, content):
    path.write_bytes(content)
    done = lumen(path, path.parent / "out")
    assert done.returncode == 2 and done.stderr.count("error: ") == 1, (done.returncode, done.stderr)
    return done.stderr


@pytest.mark.parametrize(
    "old, new, said",
    [
        (b"property float x", b"property flat x", "property flat x"),
        (b"property float y", b"property float q", "no property y"),
        (b"property float z", b"property list uchar float z", "z is a list"),
        (b"property list uchar int vertex_indices", b"property list float int vertex_indices", "list float int"),
        (b"element vertex ", b"element vertex 9", "vertex"),
        (b"element face ", b"element face -", "element face -"),
        (b"end_header", b"end_of_header", "end_of_header"),
    ],
)
def test_ply_headers_are_checked_before_they_are_believed(lumen, tmp_path, old, new, said):
    whole = fuzz.FORMATS["binary.ply"](tmp_path / "tube.ply").read_bytes()
    assert old in whole
    message = refused(lumen, tmp_path / "tube.ply", whole.replace(old, new, 1))
    assert "not a sound PLY file" in message and said in message


def test_ply_records_of_the_wrong_length_are_refused(lumen, tmp_path):
    path = fuzz.FORMATS["ascii.ply"](tmp_path / "tube.ply")
    lines = path.read_bytes().split(b"\n")
    first = lines.index(b"end_header") + 1
    lines[first + 4] = b"1.5 2.5"
    assert "vertex 4" in refused(lumen, path, b"\n".join(lines))


@pytest.mark.parametrize(
    "face, said",
    [
        (b"1//1 2//1 3//1", "normal"),
        (b"1/1 2/1 3/7", "texture coordinate"),
        (b"1/1 2/1 3/-7", "texture coordinate"),
        (b"1 2 999999", "point"),
        (b"0 1 2", "point"),
    ],
)
def test_obj_faces_name_what_the_file_has(lumen, tmp_path, face, said):
    lines = fuzz.FORMATS["o.obj"](tmp_path / "tube.obj").read_bytes().rstrip().split(b"\n")
    lines[-1:] = [b"vt 0 0", b"f " + face, lines[-1]]
    message = refused(lumen, tmp_path / "tube.obj", b"\n".join(lines) + b"\n")
    assert f"a face names a {said} that the file does not have" in message
    assert f"line {len(lines) - 1}" in message


@pytest.mark.parametrize("field", [b"sizes", b"type", b"encoding"])
def test_nrrd_headers_need_what_the_reader_needs(lumen, tmp_path, field):
    whole = fuzz.FORMATS["m.nrrd"](tmp_path / "m.nrrd").read_bytes()
    assert field.decode() in refused(lumen, tmp_path / "m.nrrd", whole.replace(b"\n" + field + b":", b"\nnone:", 1))


def test_nifti_dimensions_are_checked(lumen, tmp_path):
    whole = bytearray(fuzz.FORMATS["m.nii"](tmp_path / "m.nii").read_bytes())
    whole[42:44] = (-3).to_bytes(2, "little", signed=True)
    assert "dim[1]" in refused(lumen, tmp_path / "m.nii", bytes(whole))

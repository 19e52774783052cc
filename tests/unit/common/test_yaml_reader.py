"""Strict YAML: numbers as people write them, places of values, and every kind of file that is refused."""

import pytest

from common import yaml_reader
from common.errors import InputError


def read(tmp_path, text):
    file = tmp_path / "a.yaml"
    file.write_text(text)
    return yaml_reader.read(file)


@pytest.mark.parametrize(
    "text, value",
    [("1e-3", 1e-3), ("1E5", 1e5), ("-.5", -0.5), ("3", 3), ("3.", 3.0), ("+2.5e+1", 25.0), ("1.5e", "1.5e")],
)
def test_numbers(tmp_path, text, value):
    found = read(tmp_path, f"a: {text}").data["a"]
    assert found == value and type(found) is type(value)


@pytest.mark.parametrize("text, value", [("true", True), ("false", False), ("no", "no"), ("on", "on"), ("null", None)])
def test_only_true_and_false_are_booleans(tmp_path, text, value):
    assert read(tmp_path, f"a: {text}").data["a"] == value


def test_lines_and_names_of_values(tmp_path):
    document = read(tmp_path, "a: 1\nb:\n  - c: 2\n  -\n    d: 3\n")
    assert document.line(("b", 1, "d")) == 5
    assert document.line(("b", 0, "not there")) == 3
    assert document.where(("b", 1, "d")).endswith("a.yaml, line 5, key b[2].d")


def test_empty_file_is_an_empty_group(tmp_path):
    assert read(tmp_path, "# nothing\n").data == {}


@pytest.mark.parametrize(
    "text, words",
    [
        ("a: 1\nb: 2\na: 3\n", ["given twice", "line 3", "line 1"]),
        ("x:\n  - {a: 1, a: 2}\n", ["given twice", "x[1].a"]),
        ("a: [1\n", ["not valid YAML", "line"]),
        ("a: b: c\n", ["not valid YAML", "line 1"]),
        ("a: {b: .inf}\n", ["not finite", "a.b"]),
        ("a: [1, .nan]\n", ["not finite", "a[2]"]),
        ("a: !!python/object:os.system x\n", ["not valid YAML"]),
    ],
)
def test_refused(tmp_path, text, words):
    with pytest.raises(InputError) as error:
        read(tmp_path, text)
    for word in words:
        assert word in str(error.value)


def test_missing_and_binary_files_are_refused(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        yaml_reader.read(tmp_path / "none.yaml")
    (tmp_path / "b.yaml").write_bytes(b"\xff\xfe\x00a")
    with pytest.raises(InputError, match="UTF-8"):
        yaml_reader.read(tmp_path / "b.yaml")
    (tmp_path / "c.yaml").write_bytes(b"a: 1\nb: \x00\x01")
    with pytest.raises(InputError, match=r"does not allow\n.*c.yaml, line 2\n.*#x00"):
        yaml_reader.read(tmp_path / "c.yaml")

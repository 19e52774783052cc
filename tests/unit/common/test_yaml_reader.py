"""Strict YAML: numbers as people write them, places of values, and every kind of file that is refused."""

import pytest

from common.documents import yaml_reader
from common.errors import InputError


LAUGHS = "k0: &k0 [1]\n" + "".join(
    f"k{i}: &k{i} [" + 9 * f"*k{i - 1}," + "]\n" for i in range(1, 9)
)  # nine of the last


def read(tmp_path, text):
    file = tmp_path / "a.yaml"
    file.write_text(text)
    return yaml_reader.read(file)


@pytest.mark.parametrize(
    "text, value",
    [
        ("0130", 130),
        ("0x10", 16),
        ("0o17", 15),
        ("2:10", "2:10"),
        ("1_0", "1_0"),
        ("2026-01-02", "2026-01-02"),
        ("1e-3", 1e-3),
        ("1E5", 1e5),
        ("-.5", -0.5),
        ("3", 3),
        ("3.", 3.0),
        ("+2.5e+1", 25.0),
        ("1.5e", "1.5e"),
    ],
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
        ("a: &x [*x]\n", ["within itself"]),
        ("a: " + 3000 * "[" + 3000 * "]", ["nested too deeply"]),
        (LAUGHS, ["too many values", "multiply"]),
        ("? [a, b]\n: 1\n", ["key that is no word", "line 1"]),
        ("b: {mass: 130,5}\n", ["key that is no word", "in b", "decimal comma"]),
        ("a: !!int x\n", ["its tag does not fit", "!!int x"]),
        ("a: !!set {b, c}\n", ["tag that a configuration does not have", "!!set"]),
        ("a: 1" + 400 * "0" + "\n", ["too many digits", "key a"]),
        ('a: "\\ud800"\n', ["half a character", "#xd800"]),
        ("a: !!python/object:os.system x\n", ["tag that a configuration does not have", "line 1", "key a"]),
    ],
    ids=lambda value: value[:20] if isinstance(value, str) else value[0],
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


def test_anchors_aliases_and_merge_keys(tmp_path):
    text = "base: &base {a: 1, b: [2]}\nother: {<<: *base, a: 3}\nsame: *base\n"
    assert read(tmp_path, text).data == {
        "base": {"a": 1, "b": [2]},
        "other": {"a": 3, "b": [2]},
        "same": {"a": 1, "b": [2]},
    }

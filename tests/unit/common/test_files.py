"""Files are written whole or not at all."""

import hashlib
import json
import math

import pandas as pd
import pytest

from common.errors import InputError
from common.files import replacing, sha256, write_json, write_table


def test_success_puts_the_file_in_place(tmp_path):
    with replacing(tmp_path / "new" / "a.txt") as partial:
        assert partial.parent == tmp_path / "new" and partial.suffix == ".txt"
        partial.write_text("done")
    assert [file.name for file in (tmp_path / "new").iterdir()] == ["a.txt"]


def test_failure_keeps_the_old_file_and_leaves_nothing_else(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(RuntimeError):
        with replacing(tmp_path / "a.txt") as partial:
            partial.write_text("half")
            raise RuntimeError
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"a.txt": "old"}


def test_json_refuses_numbers_that_are_not_finite(tmp_path):
    write_json(tmp_path / "a.json", {"a": [1, 2.5]})
    assert json.loads((tmp_path / "a.json").read_text()) == {"a": [1, 2.5]}
    with pytest.raises(ValueError):
        write_json(tmp_path / "b.json", {"a": float("nan")})
    assert not (tmp_path / "b.json").exists()


@pytest.mark.parametrize("digits, text", [({}, "3.14159"), ({"digits": 2}, "3.1"), ({"digits": None}, repr(math.pi))])
def test_a_table_has_the_digits_asked_for_and_empty_fields(tmp_path, digits, text):
    write_table(tmp_path / "a.csv", pd.DataFrame({"a": [math.pi, math.nan], "b": [1, 2]}), **digits)
    assert (tmp_path / "a.csv").read_bytes() == f"a,b\n{text},1\n,2\n".encode()


def test_a_place_where_nothing_can_be_written_is_refused(tmp_path):
    (tmp_path / "a").write_text("file")
    for place, where in ((tmp_path / "a" / "b.json", tmp_path / "a"), (tmp_path, tmp_path)):
        with pytest.raises(InputError) as caught:
            write_json(place, {})
        assert caught.value.where == str(where)
    assert (tmp_path / "a").read_text() == "file"


def test_a_hash_is_of_the_whole_file(tmp_path):
    content = bytes(range(256)) * 4096  # longer than the blocks in which it is read
    (tmp_path / "a").write_bytes(content)
    assert sha256(tmp_path / "a") == hashlib.sha256(content).hexdigest()

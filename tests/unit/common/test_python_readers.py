"""The fuzzer of the readers in Python: its mutants differ by the seed alone, and it tells a fault from a refusal."""

import random

import python_readers

from common.errors import InputError


def test_mutants_are_those_of_their_seed():
    text = "a: 1\nb: [2, 3]\n"
    found = [[python_readers.mutant(text, random.Random(seed)) for _ in range(3)] for seed in (1, 1, 2)]
    assert found[0] == found[1] != found[2]


def test_a_refusal_is_an_answer_and_any_other_error_is_a_fault(tmp_path):
    def refuse(path):
        raise InputError("what", path, "value", "remedy")

    assert python_readers.complaint(lambda path: None, tmp_path) == ("", True)
    assert python_readers.complaint(refuse, tmp_path) == ("", False)
    said, answered = python_readers.complaint(lambda path: [][0], tmp_path)
    assert "IndexError" in said and not answered


def test_faults_are_kept_and_counted(tmp_path, monkeypatch):
    def read(path):
        return {}[1] if path.read_bytes() != b"sound: 1\n" else 1

    monkeypatch.setitem(python_readers.READERS, "toy", (["sound: 1\n"], ".yaml", read))
    assert python_readers.fuzz("toy", 0.05, "1", tmp_path) > 0
    assert list(tmp_path.glob("toy-1-*.yaml"))

"""A user's error ends a command with one message and its exit code; a defect keeps its traceback."""

import pytest

from common.errors import ComputationError, InputError, error_message, guarded


@pytest.mark.parametrize("kind, code", [(InputError, 2), (ComputationError, 3)])
def test_guarded_prints_one_message_and_exits(capsys, kind, code):
    @guarded
    def main():
        raise kind("no lumen", "a.stl", 7, "give one")

    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == code
    assert capsys.readouterr().err == "error: no lumen\n  where:  a.stl\n  value:  7\n  remedy: give one\n"


def test_guarded_lets_defects_through_and_returns_results():
    @guarded
    def main(fail):
        if fail:
            raise KeyError("defect")
        return 5

    assert main(False) == 5
    with pytest.raises(KeyError):
        main(True)


def test_the_last_error_of_a_log_counts_and_ends_it():
    assert error_message("error: first\n  remedy: x\nmore\nerror: last\n  remedy: y\n") == "error: last\n  remedy: y"
    assert error_message("") == ""

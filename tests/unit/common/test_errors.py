"""A user's error ends a command with one message and its exit code; a defect keeps its traceback."""

import errno

import pytest

from common.errors import ComputationError, InputError, error_message, error_sentence, error_summary, guarded


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


def test_a_full_disk_is_one_message_and_a_missing_file_a_defect(capsys):
    @guarded
    def main(number):
        raise OSError(number, "the system's reason", "out.csv")

    with pytest.raises(SystemExit) as end:
        main(errno.ENOSPC)
    assert end.value.code == 1
    lines = capsys.readouterr().err.splitlines()
    assert lines[:3] == [
        "error: a file cannot be read or written",
        "  where:  out.csv",
        "  value:  the system's reason",
    ]
    with pytest.raises(FileNotFoundError):
        main(errno.ENOENT)


def test_a_real_full_disk_ends_a_command_with_one_message(capsys):
    @guarded
    def main():
        with open("/dev/full", "w") as file:
            file.write("x")

    with pytest.raises(SystemExit):
        main()
    assert "  value:  No space left on device" in capsys.readouterr().err


def test_ctrl_c_ends_a_command_without_traceback(capsys):
    @guarded
    def main():
        raise KeyboardInterrupt

    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 130
    assert capsys.readouterr().err == "ended by Ctrl-C\n"


def test_the_last_error_of_a_log_counts_and_ends_it():
    assert error_message("error: first\n  remedy: x\nmore\nerror: last\n  remedy: y\n") == "error: last\n  remedy: y"
    assert error_message("") == ""


def test_the_last_lines_count_in_a_log_without_an_error():
    assert error_message("a\nb\nc\n", last_lines=2) == "b\nc"
    assert error_summary("a\nb\nc\n") == "c" and error_summary("") == ""
    assert error_sentence("a\nValueError: c\n") == "" == error_sentence("")


def test_an_error_in_one_line():
    text = "switched off: x\nerror: no balance\n  where:  stage\n  value:  residual 1\n  remedy: none\n"
    assert error_summary(text) == "error: no balance; where:  stage; value:  residual 1"
    assert error_sentence(text) == "no balance"

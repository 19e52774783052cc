"""A program that has no answer is told apart from one that is not there."""

import pytest

from common.errors import InputError
from whatif import engine


def test_what_a_program_complains_of_is_the_reason():
    with pytest.raises(engine.ProcedureFailed) as caught:
        engine.run_program(["sh", "-c", "echo >&2; echo 'error: no force balance' >&2; echo more >&2; exit 3"])
    assert caught.value.reason == "no force balance" and "sh" in str(caught.value)


def test_a_program_that_says_nothing_is_named_by_its_code():
    with pytest.raises(engine.ProcedureFailed, match="exit code 5"):
        engine.run_program(["sh", "-c", "exit 5"])


def test_a_missing_program_is_bad_input(tmp_path):
    with pytest.raises(InputError, match="make build"):
        engine.run_program([tmp_path / "vci", "deploy"])

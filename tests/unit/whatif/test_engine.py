"""Programs that refuse, break off or are missing are told apart."""

import pytest

from common.errors import ComputationError, InputError
from whatif import engine


def test_the_last_error_of_a_program_is_the_reason():
    """`vci deploy` logs its progress before an error, so the reason is the last error line."""
    script = (
        "echo 'switched off: wall further than 6 mm' >&2; echo 'error: no force balance' >&2; echo '  where: x' >&2"
    )
    with pytest.raises(engine.ProcedureFailed) as caught:
        engine.run_program(["sh", "-c", f"{script}; exit 3"])
    assert caught.value.reason == "no force balance" and "sh" in str(caught.value)


@pytest.mark.parametrize("end, said", [("exit 1", "exit code 1"), ("kill -9 $$", "exit code -9")])
def test_a_program_that_breaks_off_is_no_answer(end, said):
    """A crash, or a lack of memory, must not be kept as the result of a plan."""
    with pytest.raises(ComputationError, match=said) as caught:
        engine.run_program(["sh", "-c", f"echo step 3 >&2; {end}"])
    assert not isinstance(caught.value, engine.ProcedureFailed) and "step 3" in str(caught.value)


def test_a_missing_program_is_bad_input(tmp_path):
    with pytest.raises(InputError, match="make build"):
        engine.run_program([tmp_path / "vci", "deploy"])

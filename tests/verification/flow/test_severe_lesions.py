"""FFR of the most severe lesions in three dimensions, meshed and solved at default settings by the commands."""

import pathlib
import sys

import pytest

sys.path[:0] = [str(pathlib.Path(__file__).parent)]

import hard_cases  # noqa: E402

pytestmark = pytest.mark.long

# percent of the diameter: FFR of an axisymmetric solution; axisymmetric.py and the published values agree
REFERENCE = {85: 0.22700, 90: 0.12830}
WITHIN = 1e-3  # the errors are .0004 at 85 % and .0008 at 90 %; at 90 % the answer is from the mesh of two rings


@pytest.mark.parametrize("percent", REFERENCE)
def test_ffr_behind_a_severe_lesion(percent, tmp_path):
    name = f"single_{percent}"
    hard_cases.write(name, tmp_path)
    row = hard_cases.run(name, tmp_path)
    print(row)
    assert row["outcome"] == "converged" and float(row["artificial"]) == 0
    assert float(row["ffr"]) == pytest.approx(REFERENCE[percent], abs=WITHIN)
    assert float(row["residual_n"]) <= 1e-8


def test_the_estimate_where_the_error_is_large(tmp_path):
    """At a throat Reynolds number of 1,500 the mesh of three rings has an error of .0031, several times that of the
    other straight tubes. The estimate must show this."""
    name = "throat_re_1500"
    hard_cases.write(name, tmp_path)
    row = hard_cases.run(name, tmp_path)
    print(row)
    error = abs(float(row["error"]))
    assert 0.002 < error < 0.005
    assert 0.75 * error <= float(row["estimate"]) <= 3 * error

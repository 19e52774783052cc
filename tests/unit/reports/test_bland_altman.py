"""Bland-Altman statistics against numbers worked out by hand."""

import pytest

from common.errors import InputError
from reports.study.bland_altman import bland_altman

# differences 1, -1, 3, 1: mean 1, squared deviations 0 + 4 + 4 + 0 = 8, sd = sqrt(8 / 3)
A, B = [11.0, 9.0, 13.0, 11.0], [10.0, 10.0, 10.0, 10.0]
SD = 1.632993161855452
T_975_3 = 3.182446305  # Student's t, 97.5 %, 3 degrees of freedom, from tables


def test_bias_sd_and_limits():
    result = bland_altman(A, B)
    assert result.n == 4
    assert result.bias == pytest.approx(1.0, abs=1e-12)
    assert result.sd == pytest.approx(SD, abs=1e-12)
    assert result.loa_lower == pytest.approx(1.0 - 1.96 * SD, abs=1e-12)
    assert result.loa_upper == pytest.approx(1.0 + 1.96 * SD, abs=1e-12)


def test_confidence_interval_of_the_bias():
    half = T_975_3 * SD / 2.0
    result = bland_altman(A, B)
    assert result.bias_ci_lower == pytest.approx(1.0 - half, abs=1e-6)
    assert result.bias_ci_upper == pytest.approx(1.0 + half, abs=1e-6)


def test_swapping_the_methods_changes_the_sign():
    there, back = bland_altman(A, B), bland_altman(B, A)
    assert back.bias == -there.bias and back.sd == there.sd
    assert back.loa_lower == pytest.approx(-there.loa_upper)


def test_one_case_has_no_spread_and_two_no_interval():
    one, two = bland_altman([2.0], [1.5]), bland_altman([2.0, 3.0], [1.0, 1.0])
    assert (one.bias, one.sd, one.loa_lower, one.bias_ci_lower) == (0.5, None, None, None)
    assert two.sd == pytest.approx(0.5**0.5) and two.loa_upper is not None and two.bias_ci_upper is None


@pytest.mark.parametrize("a, b", [([1.0, 2.0], [1.0]), ([], []), ([float("nan")], [1.0])])
def test_refuses_what_cannot_be_compared(a, b):
    with pytest.raises(InputError):
        bland_altman(a, b)

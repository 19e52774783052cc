"""Mean arterial pressure by its formula, and pressures that are refused."""

import pytest

from common.patient.blood_pressure import mean_arterial_pressure_mmhg
from common.errors import InputError


def test_mean_arterial_pressure():
    assert mean_arterial_pressure_mmhg(120, 80) == pytest.approx(96.0)


@pytest.mark.parametrize("sbp, dbp", [(80, 120), (80, 80), (120, 0)])
def test_pressures_out_of_order_are_refused(sbp, dbp):
    with pytest.raises(InputError, match="diastolic"):
        mean_arterial_pressure_mmhg(sbp, dbp)

"""The viscosity laws at low, middle and high shear rates, and an unknown law."""

import numpy as np
import pytest

from common.errors import InputError
from flow import settings
from flow.physics import viscosity

GIVEN = viscosity.from_settings(settings.make(viscosity_model="carreau_yasuda"))


def test_limits_and_knee():
    fluid = viscosity.from_document({"viscosity": GIVEN})
    assert fluid(0.0) == pytest.approx(0.056)
    assert fluid(1e12) == pytest.approx(0.00345, rel=1e-4)
    # at rate = 1 / lambda: mu_inf + (mu_0 - mu_inf) 2^((n - 1) / a)
    assert fluid(1 / 1.902) == pytest.approx(0.00345 + 0.05255 * 2 ** (-0.78 / 1.25), rel=1e-12)
    assert (np.diff(fluid(np.logspace(-3, 5, 50))) < 0).all()


def test_newtonian_is_the_default():
    assert viscosity.from_settings(settings.make()) is None
    fluid = viscosity.from_document({"viscosity_pa_s": 0.004, "viscosity": None})
    assert fluid(np.array([0.0, 1e3])) == pytest.approx(0.004)


def test_unknown_model_in_the_settings_is_refused():
    with pytest.raises(InputError, match="viscosity_model"):
        settings.make(viscosity_model="casson")

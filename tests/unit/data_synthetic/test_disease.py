import numpy as np
import pytest

from data_synthetic import disease


@pytest.mark.parametrize("shape", ["focal", "diffuse", "tandem"])
def test_weight_is_bounded_and_ends_smoothly(shape):
    lesion = {"shape": shape, "centre_s_mm": 20.0, "length_mm": 16.0}
    s = np.linspace(5, 35, 6001)
    w = disease.stenosis_profile(lesion, s, 0.7)
    assert w.min() >= 0 and 0.9 < w.max() <= 1
    assert w[np.abs(s - 20) >= 8].max() < 1e-9
    assert np.abs(np.gradient(w, s)[np.abs(np.abs(s - 20) - 8) < 0.01]).max() < 0.01


def test_tandem_has_two_minima_of_the_lumen():
    w = disease.stenosis_profile({"shape": "tandem", "centre_s_mm": 10.0, "length_mm": 12.0}, np.linspace(4, 16, 1201))
    peaks = np.flatnonzero((w[1:-1] > w[:-2]) & (w[1:-1] >= w[2:]))
    assert len(peaks) == 2


def test_calcium_spans_its_arc_and_length():
    lesion = {"centre_s_mm": 10.0, "calcium": {"arc_deg": 90, "direction_deg": 170, "length_mm": 4}}
    theta = np.radians(np.arange(0, 360, 0.25))
    share = disease.calcium_share(lesion, 10.0, theta)
    assert np.degrees(np.sum(share > 0.5) * (theta[1] - theta[0])) == pytest.approx(90, abs=1)
    assert disease.calcium_share(lesion, 10.0, np.radians(-170)) > 0.8  # across the jump of the angle at 180 degrees
    assert disease.calcium_share(lesion, 12.0, np.radians(170)) == pytest.approx(0.5, abs=0.01)
    assert disease.calcium_share({"centre_s_mm": 1.0}, 1.0, theta).max() == 0

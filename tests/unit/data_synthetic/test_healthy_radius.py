import numpy as np
import pytest

from data_synthetic import healthy_radius


def side(s_mm, **changes):
    return {"s_mm": s_mm, "diameter_mm": 1.6, "length_mm": 8, **changes}


def test_taper_between_ostia_and_none_along_them(vessel):
    data = vessel()
    (fork,) = healthy_radius.bifurcations(data)
    assert (
        fork.end_mm - fork.start_mm > 2 * healthy_radius.TRANSITION_HALF_MM
    )  # the rim of the ostium lies farther downstream
    level = healthy_radius.main_healthy_radius(
        data, np.array([fork.s_mm + healthy_radius.TRANSITION_HALF_MM, fork.end_mm])
    )
    assert level[0] == pytest.approx(level[1], rel=1e-12)
    per_cm = 1 - 0.01 * data["main"]["taper_percent_per_cm"]
    for start in (2.0, fork.end_mm + 0.1):
        first, second = healthy_radius.main_healthy_radius(data, np.array([start, start + 2]))
        assert second / first == pytest.approx(per_cm**0.2, rel=1e-12)


def test_side_branch_is_as_wide_as_asked_in_its_ostium(vessel):
    data = vessel()
    (fork,), (asked,) = healthy_radius.bifurcations(data), healthy_radius.ordered_side_branches(data)
    s = np.array([0.0, fork.side_level_mm, fork.side_level_mm + 10])
    radius = healthy_radius.side_healthy_radius(asked, fork, s)
    assert radius == pytest.approx([0.8, 0.8, 0.8 * 0.97], rel=1e-12)


def test_two_branches_at_one_place_share_the_power(vessel):
    data = vessel(side_branches=[side(15, azimuth_deg=0), side(15, azimuth_deg=180, diameter_mm=1.4)], lesions=[])
    m, (first, second) = data["murray_exponent"], healthy_radius.bifurcations(data)
    before, after = healthy_radius.main_healthy_radius(
        data, np.array([first.start_mm, max(first.end_mm, second.end_mm)])
    )
    assert before**m == pytest.approx(after**m + 0.8**m + 0.7**m, rel=1e-12)
    assert first.after_mm == pytest.approx(second.before_mm, rel=1e-12)


def test_nothing_is_left_where_a_side_branch_takes_all(vessel):
    data = vessel(side_branches=[side(15, diameter_mm=3.6), side(20)], lesions=[])
    first, second = healthy_radius.bifurcations(data)
    assert first.after_mm == second.before_mm == second.after_mm == 0

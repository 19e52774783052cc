"""Random cohorts: every patient can be built, is the same for the same seed, and keeps to the stated distributions."""

import numpy as np
import pytest

from common.documents import schema
from common.errors import InputError
from data_synthetic import draw, patient, tree
from data_synthetic.__main__ import main


def test_files_are_valid_cases_and_the_same_whatever_the_count(tmp_path):
    main(["draw", "--count", "3", "--seed", "5", "--out", str(tmp_path / "three")])
    main(["draw", "--count", "2", "--seed", "5", "--out", str(tmp_path / "two")])
    names = sorted(path.name for path in (tmp_path / "three").iterdir())
    assert names == ["patient001.yaml", "patient002.yaml", "patient003.yaml"]
    for name in names[:2]:
        assert (tmp_path / "two" / name).read_bytes() == (tmp_path / "three" / name).read_bytes()
    for name in names:
        assert patient.load(tmp_path / "three" / name)["plan"] == "auto"
    assert draw.draw_patient(5, 1) != draw.draw_patient(6, 1) != draw.draw_patient(6, 2)


def test_a_cohort_may_have_any_size(tmp_path, monkeypatch):
    made = draw.draw_patient(5, 1)
    monkeypatch.setattr(draw, "draw_patient", lambda seed, number: made)
    monkeypatch.setattr(draw.config, "load_case", lambda path: made)
    paths = draw.run(1001, 5, tmp_path)
    assert len(set(paths)) == 1001 and all(path.is_file() for path in paths)
    assert [paths[k].name for k in (0, 998, 999)] == ["patient001.yaml", "patient999.yaml", "patient1000.yaml"]


def test_values_keep_to_their_ranges_and_vary():
    rng = np.random.default_rng(1)
    cases = [draw._random_case(rng) for _ in range(400)]
    values = {
        "lvm": ([c["patient"]["lvm_g"] for c in cases], 90, 240),
        "ostial": ([c["vessel"]["main"]["ostial_diameter_mm"] for c in cases], 3.2, 5.0),
        "length": ([c["vessel"]["main"]["length_mm"] for c in cases], 60, 110),
        "sides": ([len(c["vessel"]["side_branches"]) for c in cases], 2, 5),
        "stenosis": ([c["vessel"]["lesions"][0]["diameter_stenosis_percent"] for c in cases], 55, 78),
        "bound": ([c["vessel"]["main"]["max_curvature_per_mm"] for c in cases], 0.1, 0.3),
    }
    for name, (found, low, high) in values.items():
        assert low <= min(found) < max(found) <= high, name
    stenosis = np.array(values["stenosis"][0])
    assert stenosis.mean() == pytest.approx(68, abs=0.8) and stenosis.std() == pytest.approx(4.7, abs=0.5)
    arteries = [c["vessel"]["artery"] for c in cases]
    assert arteries.count("lad") / 400 == pytest.approx(0.5, abs=0.08)
    assert np.mean(["calcium" in c["vessel"]["lesions"][0] for c in cases]) == pytest.approx(0.3, abs=0.08)
    shapes = {c["vessel"]["lesions"][0]["shape"] for c in cases}
    assert shapes == {"focal", "diffuse", "tandem"}
    assert all(c["patient"]["sbp_mmhg"] - c["patient"]["dbp_mmhg"] >= 30 for c in cases)


def test_what_cannot_be_built_is_drawn_again(monkeypatch):
    tried = []

    def refuse_first(vessel, where):
        tried.append(vessel["seed"])
        if len(tried) == 1:
            raise InputError("impossible", where, 0, "another")

    monkeypatch.setattr(patient, "check", refuse_first)
    case = draw.draw_patient(3, 1)
    assert len(tried) >= 2 and case["vessel"]["seed"] == tried[-1]


@pytest.mark.parametrize("count, seed, key", [(0, 1, "--count"), (-3, 1, "--count"), (1, -1, "--seed")])
def test_bad_numbers_are_refused(tmp_path, count, seed, key):
    with pytest.raises(InputError, match=key):
        draw.run(count, seed, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_lesion_lies_where_the_catalogue_has_a_stent():
    for number in range(1, 9):  # the second of them would be too wide otherwise
        case = draw.draw_patient(5, number)
        main = tree.grow(schema.with_defaults(case["vessel"], schema.read("vessel")))[0]
        lesion = case["vessel"]["lesions"][0]
        centre = lesion["centre_s_mm"]
        at, distal = 2 * main.healthy_radius(np.array([centre, centre + 0.5 * lesion["length_mm"]]))
        assert at >= 2.6 and distal <= 4.4

"""FFR of given lumens: those of the calibration keep their FFR, wider ones have a higher, narrower ones a lower FFR."""

import pathlib

import pytest

from common.errors import InputError
from whatif import lumens


@pytest.fixture
def case(vessel, monkeypatch):
    """The vessel with lumens below a folder; their radii are in their names, in hundredths of a millimetre."""
    vessel.folder, own = pathlib.Path("case"), vessel.lumen
    vessel.lumen = lambda place: own(int(place.parent.name[1:]) / 100 if isinstance(place, pathlib.Path) else place)
    return vessel


def test_the_calibrated_lumens_are_given_back_and_others_lie_beside_them(case):
    found = lumens.ffr_of_lumens(
        case, ["arm/r140", "arm/r100", "arm/r120", "arm/r160", "arm/r90"], ["pre", "vci", "rc"]
    )
    ffr = {name: one["ffr"] for name, one in found["lumens"].items()}
    assert ffr["r140"] == pytest.approx(0.90) and ffr["r100"] == pytest.approx(0.70)
    assert ffr["r90"] < 0.70 < ffr["r120"] < 0.90 < ffr["r160"] < 1.0
    at = {name: one["at"] for name, one in found["lumens"].items()}
    assert (at["r160"], at["r120"], at["r90"]) == ("below", "between", "beyond")
    assert found["error"] > 0 and found["error_from"] == ["rc"]


def test_without_the_planned_procedure_there_is_nothing_to_calibrate_on(case):
    with pytest.raises(InputError, match="vci"):
        lumens.ffr_of_lumens(case, ["arm/r140"], ["pre", "rc"])

"""The picture of a plan shows its devices over the lumen. It has the same bits each time, and bad input is refused."""

import json

import matplotlib
import pytest
from narrowed_vessels import measured_vessel, focal

from anatomy.planning import plan, plan_picture, proposal
from common.errors import InputError


@pytest.fixture
def planned(families, written, tmp_path):
    """(anatomy folder, plan.json) of two lesions that are treated."""
    summary, sections = measured_vessel(focal(12, 8, 60), focal(36, 8, 75), sides=((24.0, 2.0),))
    steps = proposal.propose(summary, sections, families, "case", "all").steps
    document = {"schema": "vci-scene-1", "case": "two_lesions", **plan.procedure(steps, families, summary, "case")}
    (tmp_path / "plan.json").write_text(json.dumps(document))
    return written(summary, sections), tmp_path / "plan.json"


def test_names_devices_lesions_and_side_branches(planned, tmp_path, monkeypatch):
    monkeypatch.setitem(matplotlib.rcParams, "svg.fonttype", "none")
    plan_picture.run(*planned, tmp_path / "a.svg")
    text = (tmp_path / "a.svg").read_text()
    assert "two_lesions" in text and "lesion1 75 %" in text and "side1" in text
    assert text.count("des_") == 2 and text.count("non_compliant_") == 2
    for name in ("a.png", "b.png"):
        plan_picture.run(*planned, tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_refusals(planned, tmp_path):
    with pytest.raises(InputError, match="picture format"):
        plan_picture.run(*planned, tmp_path / "a.gif")
    nothing = json.dumps(json.loads(planned[1].read_text()) | {"procedure": []})
    for text, what in ((nothing, "procedure.*at least 1"), ("{}", "not a plan"), ("[]", "not a group of keys")):
        planned[1].write_text(text)
        with pytest.raises(InputError, match=f"(?s){what}"):
            plan_picture.run(*planned, tmp_path / "a.png")
    assert not (tmp_path / "a.png").exists()

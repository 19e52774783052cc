"""Plans are compared over one and the same stretch of the vessel."""

import types

from whatif import plans


def test_areas_of_every_plan_are_measured_along_the_planned_segment(monkeypatch):
    planned = {"branch": "main", "s_start_mm": 10.0, "s_end_mm": 28.0}
    own = planned | {"s_start_mm": 14.0, "s_end_mm": 24.0}
    monkeypatch.setattr(plans, "read_summary", lambda folder: None)
    monkeypatch.setattr(plans, "procedure", lambda *given: {"segment": own, "devices": {}, "procedure": ["shorter"]})
    case = types.SimpleNamespace(scene={"segment": planned, "procedure": ["planned"], "wall": {}}, anatomy=lambda: None)
    scene = plans.scene_with_steps(case, {}, [])
    assert scene["segment"] == planned and scene["procedure"] == ["shorter"] and "wall" in scene

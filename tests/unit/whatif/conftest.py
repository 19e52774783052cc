"""A straight vessel with Poiseuille flow, before and after a procedure, as the study's files describe it."""

import numpy as np
import pandas as pd
import pytest

from flow import settings as settings_module
from flow.geometry.centreline import Branch, Tree
from flow.inputs import boundary

LENGTH_MM, PATIENT = 40.0, {"lvm_g": 150, "sbp_mmhg": 120, "dbp_mmhg": 80}
BALLOON = {"kind": "balloon", "chart": {"pressure_bar": [4, 16]}, "rated_burst_pressure_bar": 14}


class Vessel:
    """A case as whatif reads it: a tube with a radius of 1 mm before PCI and larger radii after it."""

    def __init__(self):
        self.flow_settings = settings_module.make()
        s = np.linspace(0.0, LENGTH_MM, 81)
        points = np.stack([s, 0 * s, 0 * s], axis=1)
        self.centrelines = Tree([Branch("main", 0, points, s, np.ones_like(s))])
        end = {"name": "outlet1", "kind": "outlet", "region_id": 2, "branch": "main", "diameter_mm": 2.0}
        branch = {"name": "main", "parent": None, "s_on_parent_mm": None, "length_mm": LENGTH_MM}
        self.anatomy_before = {"schema": "vci-anatomy-1", "ends": [end], "branches": [branch], "lesions": []}
        self.boundary = boundary.make(self.anatomy_before, self.centrelines, PATIENT, self.flow_settings)
        stent = {"device": "des", "branch": "main", "centre_s_mm": 19.0, "pressure_bar": 10.0}
        self.scene = {
            "segment": {"branch": "main", "s_start_mm": 10.0, "s_end_mm": 28.0},
            "devices": {"des": {"kind": "stent", "length_mm": 18.0, "balloon": "own"}, "own": BALLOON},
            "procedure": [{"devices": [stent]}],
            "wall": {"youngs_modulus_mpa": 0.8, "plaque": {}},
        }
        self.radii = {"pre": 1.0, "vci": 1.4, "rc": 1.5}
        self.flow_results = {state: {"ffr": ffr} for state, ffr in (("pre", 0.70), ("vci", 0.90), ("rc", 0.92))}

    def anatomy(self, state="pre"):
        return state

    def lumen(self, state):
        s = np.linspace(0.5, LENGTH_MM - 0.5, 79)
        area = np.pi * (self.radii[state] if isinstance(state, str) else state) ** 2 + 0 * s
        table = pd.DataFrame({"branch": "main", "s_mm": s, "x_mm": s, "y_mm": 0.0, "z_mm": 0.0, "area_mm2": area})
        return self.anatomy_before, table

    def flow_result(self, state):
        return self.flow_results[state]


@pytest.fixture
def vessel():
    return Vessel()


@pytest.fixture
def plan():
    """The procedure of a plan.json: predilatation, stent, post-dilatation."""
    devices = {}

    def step(action, family, diameter, length, pressure):
        device = f"{family}_{diameter:.2f}x{length}"
        devices[device] = {"nominal_diameter_mm": diameter, "length_mm": length}
        use = {"device": device, "branch": "main", "centre_s_mm": 20.0, "pressure_bar": pressure}
        return {"name": action, "action": action, "devices": [use]}

    steps = [step("predilatation", "semi_compliant", 2.5, 15, 10), step("stent", "des", 3.0, 18, 12)]
    return {"devices": devices, "procedure": [*steps, step("postdilatation", "non_compliant", 3.25, 15, 18)]}

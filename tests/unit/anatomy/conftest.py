"""The devices, and a measured vessel with one lesion."""

import pytest

from common import config


@pytest.fixture(scope="module")
def families(repo_root):
    return config.load_devices(repo_root / "config" / "devices")


@pytest.fixture
def summary():
    lesion = {
        "name": "lesion1",
        "branch": "main",
        "s_start_mm": 16.0,
        "s_mla_mm": 20.0,
        "s_end_mm": 26.0,
        "mld_mm": 1.1,
        "reference_diameter_mm": 3.1,
        "proximal_reference_diameter_mm": 3.3,
        "distal_reference_diameter_mm": 2.9,
        "diameter_stenosis_percent": 64.0,
    }
    side = {"name": "side1", "length_mm": 9.0, "s_on_parent_mm": 20.0}
    branches = [{"name": "main", "length_mm": 50.0, "s_on_parent_mm": 0.0}, side]
    return {"schema": "vci-anatomy-1", "lesions": [lesion], "branches": branches}

"""A mesh is accepted only with the surface and centreline that it was made from."""

import pytest

import tubes
from common.errors import InputError
from flow.geometry import centreline, surface
from flow.meshing import provenance

LENGTH, RADIUS = 6.0, 1.2


def test_another_surface_centreline_or_report_is_refused(tmp_path):
    """Refused are a vessel moved aside, a centreline moved aside, and a report without the SHA-256 of its lumen."""
    line = tubes.centre_branch(LENGTH, lambda s: RADIUS)
    own, other = (tubes.tube(LENGTH, lambda s: RADIUS, 0.4) for _ in range(2))
    other.points[:, 1] += 1e-3
    for name, lumen in (("own", own), ("other", other)):
        tubes.write_case(tmp_path / name, lumen, [line])
    tree = centreline.read(tmp_path / "own" / "centreline.vtp")
    made_from = provenance.fingerprint(surface.read(tmp_path / "own" / "lumen.vtp"), tree)
    provenance.check(tmp_path / "own" / "lumen.vtp", tree, made_from, "mesh.json")
    with pytest.raises(InputError, match="another surface"):
        provenance.check(tmp_path / "other" / "lumen.vtp", tree, made_from, "mesh.json")
    tree.main.points[:, 2] += 1e-3
    with pytest.raises(InputError, match="or centreline"):
        provenance.check(tmp_path / "own" / "lumen.vtp", tree, made_from, "mesh.json")
    with pytest.raises(InputError, match="what its mesh was made from"):
        provenance.check(tmp_path / "own" / "lumen.vtp", tree, None, "mesh.json")

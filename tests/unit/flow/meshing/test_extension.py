"""Extensions of ends that lie too close to a narrowing."""

import json
import pathlib

import numpy as np
import pandas as pd
import pytest

import tubes
from common.errors import InputError
from flow import __main__ as command_line
from flow import settings
from flow.geometry import centreline, surface
from flow.meshing import extension
from flow.reduced import extended

# the radius is at least 0.95 of the healthy one before 5.6 mm and behind 10.4 mm
NARROWED = tubes.lesion(1.5, 0.5, 8, 6)


def _needed(length=14.0, radius=NARROWED, **given):
    tree = centreline.Tree([tubes.centre_branch(length, radius)])
    tube = tubes.tube(length, radius, 0.3)
    return tube, tree, extension.find_extensions(tube, tree, settings.make(**given))


def test_an_end_too_close_to_a_narrowing_is_extended_to_its_clearance():
    tube, tree, found = _needed(outlet_clearance_diameters=4, inlet_clearance_diameters=2.5)
    assert [(one.region_id, one.branch) for one in found] == [(1, "main"), (2, "main")]
    inlet, outlet = found
    assert outlet.distance_mm == pytest.approx(3.6, abs=0.3) and inlet.distance_mm == pytest.approx(5.6, abs=0.3)
    # The outlet gets half of its clearance because half of the radius is left at the throat.
    assert outlet.length_mm + outlet.distance_mm == pytest.approx(6.0, rel=0.01)
    assert inlet.length_mm + inlet.distance_mm == pytest.approx(7.5, rel=0.01)
    assert outlet.direction == pytest.approx([1, 0, 0]) and inlet.direction == pytest.approx([-1, 0, 0])
    longer = extension.extend_surface(tube, found)
    surface.check(longer, "extended")
    assert longer.points[:, 0].min() == pytest.approx(-inlet.length_mm)
    assert longer.points[:, 0].max() == pytest.approx(14 + outlet.length_mm)
    area = [np.linalg.norm(tube.area_vectors()[tube.region == cap].sum(axis=0)) for cap in (1, 2)]
    more = sum(a * one.length_mm for a, one in zip(area, found))
    assert longer.volume_mm3() == pytest.approx(tube.volume_mm3() + more, rel=1e-9)
    line = extension.extend_tree(tree, found).main
    assert line.length_mm == pytest.approx(14 + inlet.length_mm + outlet.length_mm)
    assert line.points[0] == pytest.approx([-inlet.length_mm, 0, 0]) and (np.diff(line.s_mm) > 0).all()
    assert line.radius(8 + inlet.length_mm) == pytest.approx(0.75)


def test_far_from_narrowings_nothing_is_extended_but_what_is_asked_for():
    assert _needed(40.0)[2] == [] == _needed(outlet_clearance_diameters=0, inlet_clearance_diameters=0)[2]
    assert _needed(14.0, tubes.lesion(1.5, 0.35, 8, 6))[2] == [], "a third narrower: no jet worth it"
    _, _, found = _needed(40.0, outlet_extension_diameters=2)
    assert len(found) == 1 and found[0].length_mm == pytest.approx(6, rel=0.01) and found[0].distance_mm is None


def test_room_behind_a_narrowing_grows_with_its_jet():
    def room(reduction):
        found = _needed(14.0, tubes.lesion(1.5, reduction, 8, 6), inlet_clearance_diameters=0)[2]
        return [one.length_mm + one.distance_mm for one in found]

    assert room(0.41) == []  # the wanted distance is less than the actual one
    (milder,), (strong,), (stronger,) = (room(reduction) for reduction in (0.55, 0.6, 0.8))
    assert strong == pytest.approx(24.0, rel=0.01) and stronger == pytest.approx(24.0, rel=0.01)
    assert milder == pytest.approx(18.0, rel=0.02)


def test_the_narrowing_that_asks_for_most_counts():
    def radius(s):
        return np.minimum(tubes.lesion(1.5, 0.7, 8, 6)(s), tubes.lesion(1.5, 0.45, 16, 4)(s))

    _, _, found = _needed(20.0, radius, inlet_clearance_diameters=0)
    # The distance is measured from the end of the first narrowing, which is the stronger one.
    assert len(found) == 1 and found[0].distance_mm == pytest.approx(20 - 10.6, abs=0.4)
    assert found[0].length_mm + found[0].distance_mm == pytest.approx(24.0, rel=0.01)


def test_the_network_goes_through_the_extensions():
    found = [extension.Extension(1, "main", 3.0, [-1, 0, 0], 1.0), extension.Extension(2, "main", 5.0, [1, 0, 0], 1.0)]
    branches = [{"name": "main", "parent": None, "s_on_parent_mm": None}]
    branches += [{"name": "side", "parent": "main", "s_on_parent_mm": 4.0}]
    sections = pd.DataFrame({"branch": ["main"] * 2 + ["side"], "s_mm": [0.0, 10, 0], "area_mm2": [7.0, 6, 2]})
    anatomy, longer = extended.extend_anatomy({"branches": branches}, sections, found)
    assert anatomy["branches"][1]["s_on_parent_mm"] == 7.0 and branches[1]["s_on_parent_mm"] == 4.0
    main = longer[longer["branch"] == "main"].sort_values("s_mm")
    assert main["s_mm"].tolist() == [0, 3, 13, 18] and main["area_mm2"].tolist() == [7, 7, 6, 6]
    assert sections["s_mm"].tolist() == [0, 10, 0]


@pytest.fixture
def mesh(monkeypatch):
    """Name of a mesh that counts as having 9 cells; a mesh named coarse.msh counts as having 4."""
    monkeypatch.setattr(extended.compat, "count_cells", lambda path: {"mesh": 9, "coarse": 4}[pathlib.Path(path).stem])
    return "mesh.msh"


def test_a_report_of_the_mesh_gives_the_extensions(tmp_path, mesh):
    path = tmp_path / "mesh.json"
    one = extension.Extension(2, "main", 3.0, [1.0, 0, 0], None)
    report = {"extensions": [vars(one)], "cells": 9, "swept": {"cells": 4, "spans": []}}
    path.write_text(json.dumps(report))
    assert extended.read_report(path, mesh) == ([one], [], None)
    path.write_text(json.dumps(report | {"cells": 8}))
    with pytest.raises(InputError, match="report is of another mesh"):
        extended.read_report(path, mesh)
    path.write_text("{}")
    with pytest.raises(InputError, match="report of the volume mesh"):
        extended.read_report(path, mesh)


ONE = {"region_id": 2, "branch": "main", "length_mm": 5.0, "direction": [1.0, 0.0, 0.0], "distance_mm": None}


@pytest.mark.parametrize(
    "change, words",
    [
        ({"length_mm": -5}, "length_mm(.|\n)*-5"),
        ({"length_mm": "5"}, "length_mm(.|\n)*'5'"),
        ({"direction": [1.0, 0.0]}, "direction"),
        ({"branch": 3}, "branch"),
        ({"more": 3}, "more"),
    ],
)
def test_a_bad_extension_is_refused_in_plain_words(tmp_path, mesh, change, words):
    path = tmp_path / "mesh.json"
    path.write_text(json.dumps({"cells": 9, "swept": {}, "extensions": [ONE | change]}))
    with pytest.raises(InputError, match="report of the volume mesh(.|\n)*extensions.1.(.|\n)*" + words):
        extended.read_report(path, mesh)


@pytest.mark.parametrize("change", [{"branch": "side7"}, {"region_id": 7}, {"direction": [9.0, 0.0, 0.0]}])
def test_an_extension_of_another_lumen_is_refused(change):
    line = tubes.centre_branch(8.0, lambda s: 1.2)
    document = tubes.boundary_document([line], [2e-6], [5e9], 7.0, 0.004)
    anatomy = {"branches": [{"name": "main", "parent": None, "s_on_parent_mm": None}]}
    sections = pd.DataFrame({"branch": "main", "s_mm": line.s_mm, "area_mm2": np.pi * line.radius_mm**2})
    case = anatomy, sections, document, settings.make()
    extended.ExtendedLumen([extension.Extension(**ONE)], centreline.Tree([line]), *case)
    with pytest.raises(InputError, match="extension of another lumen"):
        extended.ExtendedLumen([extension.Extension(**(ONE | change))], centreline.Tree([line]), *case)


def test_a_coarse_mesh_of_another_lumen_is_refused(tmp_path, mesh):
    """The coarse mesh may give the answer. It is accepted if the same report lists it, or if its own report is of the
    same lumen."""
    path, coarse, own = tmp_path / "mesh.json", tmp_path / "coarse.msh", tmp_path / "coarse.json"
    report = {"extensions": [], "cells": 9, "swept": {"cells": 9}, "made_from_sha256": "ab"}

    def read(given, beside=None):
        path.write_text(json.dumps(given))
        own.unlink(missing_ok=True)
        if beside:
            own.write_text(json.dumps(beside))
        return extended.read_report(path, mesh, [coarse])

    assert read(report | {"coarse": [{"swept": {"cells": 4}, "cells": 4}]}) == ([], [], "ab")
    assert read(report, report | {"cells": 4}) == ([], [], "ab")
    other = report | {"coarse": [{"swept": {"cells": 5}, "cells": 5}]}
    longer = report | {"cells": 4, "extensions": [{"length_mm": 1.0}]}
    refused = [(other, None), (other, report | {"cells": 4}), (report, None), (report, report), (report, longer)]
    for given, beside in refused + [(report, report | {"cells": 4, "made_from_sha256": "cd"})]:
        with pytest.raises(InputError, match="not known to be of the same lumen"):
            read(given, beside)


def test_a_report_that_is_missing_is_refused_or_said(tmp_path, capsys):
    """A missing report that the user names is refused. If no report lies beside the mesh, there is a warning."""
    radius = tubes.lesion(1.2, 0.3, 4.0, 4.0)
    tubes.write_case(tmp_path, tubes.tube(8.0, radius, 0.4), [tubes.centre_branch(8.0, radius)])
    document = tubes.boundary_document([tubes.centre_branch(8.0, radius)], [2e-6], [5e9], 7.0, 0.004)
    (tmp_path / "boundary.json").write_text(json.dumps(document))
    line = ["--centreline", str(tmp_path / "centreline.vtp")]
    meshed = ["--out", str(tmp_path / "mesh.msh"), "--rings", "2", "--json", str(tmp_path / "report.json")]
    command_line.main(["mesh", str(tmp_path / "lumen.vtp"), *line, *meshed])
    solve = ["solve", str(tmp_path / "mesh.msh"), *line, "--boundary", str(tmp_path / "boundary.json")]
    solve += ["--model", "network", "--out", str(tmp_path / "out")]
    with pytest.raises(SystemExit) as ended:
        command_line.main([*solve, "--mesh-report", str(tmp_path / "none.json")])
    assert ended.value.code == 2 and "none.json" in capsys.readouterr().err
    assert not (tmp_path / "out" / "ffr.json").exists()

    def warnings(*options):
        command_line.main([*solve, *options])
        return json.loads((tmp_path / "out" / "ffr.json").read_text())["warnings"]

    (said, of_the_model), printed = warnings(), capsys.readouterr().err
    assert "mesh.json" in said and said in printed and "network model" in of_the_model
    assert warnings("--mesh-report", str(tmp_path / "report.json")) == [of_the_model]


def test_meshes_that_could_not_be_swept_are_said(tmp_path, mesh):
    path, failed = tmp_path / "mesh.json", {"cells": 0, "spans": [], "reason": "error: no room\n  where:  span 2"}
    path.write_text(
        json.dumps({"extensions": [], "cells": 9, "swept": {"cells": 4}, "coarse": [{"swept": failed}, {"swept": {}}]})
    )
    (said,) = extended.read_report(path, mesh)[1]
    assert "coarsest mesh is not swept" in said and said.endswith("error: no room where: span 2")


@pytest.mark.slow
@pytest.mark.parametrize("model", ["3d", "network"])
def test_an_outlets_ffr_is_read_where_the_vessel_ended(tmp_path, model):
    line, radius = tubes.centre_branch(6.0, lambda s: 1.0), 1.0
    tubes.write_case(tmp_path, tubes.tube(6.0, lambda s: radius, 0.5), [line])
    document = tubes.boundary_document([line], [2e-6], [5e9], 4.0, 0.004)
    (tmp_path / "boundary.json").write_text(json.dumps(document))
    along, mesh = ["--centreline", str(tmp_path / "centreline.vtp")], str(tmp_path / "mesh.msh")
    longer = ["--outlet-extension-diameters", "3", "--rings", "2"]
    command_line.main(["mesh", str(tmp_path / "lumen.vtp"), *along, "--out", mesh, *longer])
    files = ["--boundary", str(tmp_path / "boundary.json"), "--out", str(tmp_path)]
    command_line.main(["solve", mesh, *along, *files, "--model", model])
    answer = json.loads((tmp_path / "ffr.json").read_text())
    (outlet,), table = answer["outlets"], pd.read_csv(tmp_path / "pullback.csv")
    assert outlet["ffr"] == pytest.approx(table["ffr"].iloc[-1], abs=1e-9) and table["s_mm"].iloc[-1] == 6.0
    drop = (outlet["ffr"] * 12000.0 - outlet["pressure_pa"]) / (12000.0 - outlet["pressure_pa"])
    assert drop == pytest.approx(0.5, abs=0.03)  # half of Poiseuille's drop occurs in the second half of the 12 mm

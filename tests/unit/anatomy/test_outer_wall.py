"""The reference where the outer wall is known: lumen and plaque."""

import numpy as np
import pytest
import vtk
from narrowed_vessels import measured_vessel, plateau
from vtk.util.numpy_support import numpy_to_vtk

from anatomy.planning import outer_wall, plan, proposal, remarks
from common import vtp


@pytest.fixture
def diseased(tmp_path):
    """(summary, sections, lumen.vtp) of a vessel of 3 mm with diffuse disease: from 12 mm on its lumen is 1.6 mm wide.

    The reference that was fitted to the lumen is narrow too.
    """
    lumen = lambda s: np.interp(s, [8, 12], [2.9, 1.6])  # noqa: E731
    summary, sections = measured_vessel(plateau(12, 45, 44), lumen=lumen, healthy=lambda s: np.maximum(lumen(s), 1.75))
    points, plaque = [], []
    for row in sections["main"]:
        row |= {"x_mm": row["s_mm"], "y_mm": 0.0, "z_mm": 0.0}
        radius = row["equivalent_diameter_mm"] / 2
        for turn in np.linspace(0, 2 * np.pi, 12, endpoint=False):
            points.append((row["s_mm"], radius * np.cos(turn), radius * np.sin(turn)))
            plaque.append((1.5 - radius) * (1 + np.cos(turn)))  # eccentric
    del sections["side1"], summary["branches"][1], summary["ends"][1]
    poly, cells, at = vtk.vtkPolyData(), vtk.vtkCellArray(), vtk.vtkPoints()
    at.SetData(numpy_to_vtk(np.array(points), deep=True))
    for k in range(len(points) - 12):
        cells.InsertNextCell(3, (k, k + 1, k + 12))
    poly.SetPoints(at)
    poly.SetPolys(cells)
    for data, name, values in (
        (poly.GetPointData(), "plaque_thickness_mm", np.array(plaque)),
        (poly.GetCellData(), "region_id", np.zeros(len(points) - 12)),
    ):
        array = numpy_to_vtk(values, deep=True)
        array.SetName(name)
        data.AddArray(array)
    vtp.write(tmp_path / "lumen.vtp", poly)
    return summary, sections, tmp_path / "lumen.vtp"


def test_reference_is_lumen_and_plaque(diseased):
    _, sections, file = diseased
    found = outer_wall.with_lumen_and_plaque_reference(sections, file)["main"]
    assert [row["reference_diameter_mm"] for row in found] == pytest.approx([3.0] * len(found), abs=0.05)


def test_stents_are_sized_by_the_vessel(diseased, families):
    """All distal lumen is 1.6 mm wide. By the lumen alone only a balloon would be planned. By the vessel's 3 mm it is a
    stent of 2.75 or 3 mm."""
    summary, sections, file = diseased
    assert proposal.propose(summary, sections, families, "case").treatments[0].stents == []
    done = proposal.propose(summary, outer_wall.with_lumen_and_plaque_reference(sections, file), families, "case")
    assert {stent.diameter for one in done.treatments for stent in one.stents} <= {2.75, 3.0}
    assert done.treatments[0].target.percent == pytest.approx(47, abs=2)


@pytest.mark.parametrize(
    "lumen, known",
    [({"path": "a.stl"}, False), ({"contours": {"lumen": "a"}}, False), ({"contours": {"outer_wall": "a"}}, True)],
)
def test_known_where_contours_have_it(lumen, known):
    assert outer_wall.has_traced_wall({"lumen": lumen}) == known
    assert not outer_wall.has_traced_wall({"vessel": {}})


def test_the_plan_says_which_reference_it_used(diseased, families):
    """The stenosis is 47 % by the outer wall. It is less by the profile, since the lumen is narrow everywhere. The
    remark gives both."""
    summary, sections, file = diseased
    done = proposal.propose(summary, outer_wall.with_lumen_and_plaque_reference(sections, file), families, "case")
    reference = plan.reference_document(done, by_outer_wall=True)
    assert reference["by"] == "outer wall"
    lesion = reference["lesions"][0]
    assert lesion["diameter_stenosis_percent"] == pytest.approx(47, abs=2)
    assert lesion["anatomy_percent"] == summary["lesions"][0]["diameter_stenosis_percent"]
    (said,) = remarks.of_reference(reference)
    assert "outer wall" in said and f"{lesion['anatomy_percent']:.0f} %" in said
    lesion["anatomy_percent"] = lesion["diameter_stenosis_percent"]
    assert not list(remarks.of_reference(reference))

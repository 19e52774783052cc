"""The flow of another state of the same vessel, as a first guess: `flow solve --start FOLDER`."""

import dataclasses
import pathlib

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from common.documents import json_reader, schema
from common.errors import InputError
from flow.geometry import correspondence, locate, tet10
from flow.physics.units import M_PER_MM

REMEDY = "give the folder that `flow solve` wrote"
LARGEST_VELOCITY_FACTOR = 2.0  # velocities are multiplied by the ratio of two areas, at most by this factor


@dataclasses.dataclass
class StartState:
    """A solved state of the vessel: the locate.FieldSampler of its flow at points in mm, and the inflow in m3/s.

    artificial_viscosity: factor eps in this flow; mesh_name: name of the mesh file of this flow; to_other_lumen:
    geometry.correspondence.Correspondence from the lumen to be solved to the lumen of this state.
    """

    sampler: locate.FieldSampler
    inflow: float
    artificial_viscosity: float
    mesh_name: str
    to_other_lumen: correspondence.Correspondence

    def fields_at(self, points):
        """First guess (velocity (n, 3) in m/s, pressure (n,) in Pa) at points (n, 3) in m of the lumen to be solved.

        The two lumens differ in area but are assumed to carry the same flow. So the velocity is multiplied by the
        solved state's area over the area of the lumen to be solved. This factor is at most
        LARGEST_VELOCITY_FACTOR, and at least its inverse.
        """
        other_points, rotations, radius_ratio = self.to_other_lumen(points / M_PER_MM)
        velocity, pressure, _ = self.sampler(other_points)
        factor = np.clip(radius_ratio**2, 1 / LARGEST_VELOCITY_FACTOR, LARGEST_VELOCITY_FACTOR)
        return factor[:, None] * np.einsum("nji,nj->ni", rotations, velocity), pressure


def read(folder, tree, other):
    """StartState from the output folder of `flow solve` for another state of the vessel.

    tree: geometry.centreline.Tree of the lumen to be solved; other: Tree of that state. Raises InputError for files
    that are missing or of another kind, and where the two trees have different branches.
    """
    path, answer = pathlib.Path(folder) / "solution.vtu", pathlib.Path(folder) / "ffr.json"
    for file in (path, answer):
        if not file.is_file():
            raise InputError("no such file", file, "missing", REMEDY)
    names, others = ({branch.name for branch in one} for one in (tree, other))
    if names != others:
        value = f"{', '.join(sorted(others))}; the lumen has {', '.join(sorted(names))}"
        raise InputError("the state to start from has other branches", "--start", value, "leave --start out")
    document = json_reader.read(answer, "ffr.json")
    kind = "a flow in three dimensions to start from"
    schema.validate(document, schema.read("start_flow"), kind, "solve it with model 3d")
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    values = {name: grid.GetPointData().GetArray(name) for name in ("velocity_m_per_s", "pressure_pa")}
    if grid.GetNumberOfCells() == 0 or grid.GetMaxCellSize() != 10 or not all(values.values()):
        raise InputError("not a solution of the flow", path, f"{grid.GetNumberOfCells()} cells", REMEDY)
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 10)[:, tet10.VTK_ORDER].astype(int)
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    fields = [vtk_to_numpy(values[name]).astype(float) for name in values]
    sampler = locate.FieldSampler(locate.Locator(points, cells), *fields)
    described = [document.data[key] for key in ("inlet_flow_m3_per_s", "artificial_viscosity", "mesh")]
    return StartState(sampler, *described, correspondence.Correspondence(tree, other))

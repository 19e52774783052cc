"""The answer of a reduced model alone (setting `model`). It fills the same files as the 3D model."""

import sys

import numpy as np

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.physics import ffr
from flow.solvers import solved_mesh

NAMES = {
    "axisymmetric": "axisymmetric Navier-Stokes in branch {branch}, 1D network elsewhere",
    "network": "1D network",
}

# the largest |3D minus model| in trees, rounded up (measured.md): (where the model's FFR is at least MILD, below it)
ELSEWHERE = {"axisymmetric": (0.045, 0.1), "network": (0.05, 0.05)}
MILD = 0.85

# the measured error of each model in words (measured.md)
MEASURED = {
    "axisymmetric": "within .0002 of an independent solution in straight round tubes with lesions of 62 to 90 %",
    "network": "up to .01 above an independent solution in straight round tubes with one lesion of 62 to 90 %, .02"
    " below it with two",
}


def unknown_error(model):
    """[warning], printed too: this answer's error is not known; it quotes the model's error measured elsewhere."""
    trees = f"up to {max(ELSEWHERE[model]):.2f} above the 3D model in trees, which bend and branch"
    said = f"the error of this FFR is not known; the {model} model was {MEASURED[model]}, and {trees}"
    print(said, file=sys.stderr, flush=True)
    return [said]


class Sampler:
    """A Predictor's velocity and pressure, at points and at the nodes of a LumenSpace (zero velocity on the wall)."""

    def __init__(self, predicted, space):
        self.predicted = predicted
        self.velocity, self.pressure = predicted.fields(space.nodes()[0])
        self.velocity[space.wall_nodes()] = 0.0

    def __call__(self, points):
        """(velocity (m, 3), pressure (m,), inside (m,)) at points (m, 3) in m, as geometry.locate.FieldSampler."""
        velocity, pressure = self.predicted.fields(points)
        return velocity, pressure, np.ones(len(points), bool)


class Reduced:
    """The space and sampler of a Predictor on a mesh, from which flow.solve writes its files."""

    def __init__(self, predicted, path):
        self.space = spaces.read(path)
        self.sampler = Sampler(predicted, self.space)

    def destroy(self):
        """Does nothing: the caller destroys the Predictor. solvers.solved_mesh.Solved has the same method."""


def collect(model, predicted, solved, case, reference):
    """(document of ffr.json without timings, pullback table) of the reduced model `model`.

    predicted: reduced.coupled.Predictor; solved: Reduced; case: reduced.extended.Extended; reference: pressure in Pa
    that FFR is over. Raises ComputationError where the axisymmetric model has no answer.
    """
    if model == "axisymmetric" and predicted.tube is None:
        raise ComputationError("the axisymmetric model has no answer", "model", predicted.reason, "use another model")
    network, tree, flows = case.network, case.original, predicted.flows
    probes = ffr.at_probes(case.document["probes"], tree, solved.sampler, reference)
    for probe in probes:
        probe["error_estimate"] = None

    def flow_at(branch, s_mm):
        return float(flows[network.downstream(branch, s_mm)].sum())

    table = ffr.pullback(tree, solved.sampler, reference, flow_at)
    pressure = [predicted.pressures[outlet["branch"]][1][-1] for outlet in network.outlets]
    at_ends = ffr.at_ends(network.names, pressure, case, solved.sampler, reference)
    answer = {
        "schema": "vci-ffr-1",
        "status": solved_mesh.CONVERGED,
        "model": NAMES[model].format(branch=predicted.branch.name),
        "ffr": probes[0]["ffr"],
        "probes": probes,
        "outlets": [
            {
                "name": name,
                "flow_m3_per_s": float(flow),
                "pressure_pa": float(p),
                "ffr": value,
            }
            for name, flow, p, value in zip(network.names, flows, pressure, at_ends)
        ],
        "inlet_flow_m3_per_s": float(flows.sum()),
        "dofs": predicted.tube.dofs if predicted.tube else len(network.segments),
        "error_estimate": None,
    }
    return answer, table

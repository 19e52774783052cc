"""The answer of a reduced model alone (setting `model`). It fills the same files as the 3D model."""

import sys

import numpy as np

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.solvers import solved_mesh

NAMES = {
    "axisymmetric": "axisymmetric Navier-Stokes in branch {branch}, 1D network elsewhere",
    "network": "1D network",
}

# |3D minus model| in trees: the largest of the nine patients, rounded up (where the model's FFR is at least MILD, below
# it). The axisymmetric model has .055 and .106, the network .058 and .056 (measured.md).
ELSEWHERE = {"axisymmetric": (0.06, 0.11), "network": (0.06, 0.06)}
MILD = 0.85

# The measured error of each model, as words for a warning. The errors with one lesion are from measured.md. The error
# with two is from tandem_60 (tests/verification/flow/hard_cases.py): the network had .7109, the reference .7344.
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
    """The answer of the reduced model `model` on a mesh, with what flow.solve reads of a solvers.solved_mesh.Solved.

    predicted: reduced.coupled.Predictor. Raises ComputationError where the axisymmetric model has no answer.
    """

    status, estimate = solved_mesh.CONVERGED, None

    def __init__(self, model, predicted, path):
        self.space = spaces.read(path)
        if model == "axisymmetric" and predicted.tube is None:
            raise ComputationError(
                "the axisymmetric model has no answer", "model", predicted.reason, "use another model"
            )
        network = predicted.network
        self.sampler = Sampler(predicted, self.space)
        self.model = NAMES[model].format(branch=predicted.branch.name)
        self.names, self.outflows, self.inflow = network.names, predicted.flows, float(predicted.flows.sum())
        self.pressures = [predicted.pressures[outlet["branch"]][1][-1] for outlet in network.outlets]
        self.dofs = predicted.tube.dofs if predicted.tube else len(network.segments)

    def destroy(self):
        """Does nothing: the caller destroys the Predictor. solvers.solved_mesh.Solved has the same method."""

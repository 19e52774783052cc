"""The answer of a reduced model alone (setting `model`). It fills the same output files as a 3D solve."""

import sys

import numpy as np

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.solvers import solved_mesh

NAMES = {
    "axisymmetric": "axisymmetric Navier-Stokes in branch {branch}, 1D network elsewhere",
    "network": "1D network",
}

# Largest |FFR of the 3D model minus FFR of the reduced model| in the nine patients' trees, rounded up. The first value
# holds where the reduced model's FFR is at least MILD, the second below it. Unrounded they are .055 and .106
# (axisymmetric), .058 and .056 (network); see measured.md.
ELSEWHERE = {"axisymmetric": (0.06, 0.11), "network": (0.06, 0.06)}
MILD = 0.85

# The measured error of each model's FFR, as words for a warning. The errors with one lesion are from measured.md. The
# error with two is from tandem_60 (tests/verification/flow/hard_cases.py): the network had .7109, the reference .7344.
MEASURED = {
    "axisymmetric": "within .0002 of an independent solution in straight round tubes with lesions of 62 to 90 %",
    "network": "up to .01 above an independent solution in straight round tubes with one lesion of 62 to 90 %, .02"
    " below it with two",
}


def unknown_error(model):
    """[warning], printed too, that the error of this FFR is not known. It quotes the model's error in other lumens."""
    trees = f"up to {max(ELSEWHERE[model]):.2f} above the 3D model in trees, which bend and branch"
    said = f"the error of this FFR is not known; the {model} model was {MEASURED[model]}, and {trees}"
    print(said, file=sys.stderr, flush=True)
    return [said]


class Sampler:
    """Velocity and pressure by a reduced.coupled.Predictor, as geometry.locate.FieldSampler gives those of a 3D flow.

    `velocity` (n, 3) in m/s and `pressure` (n,) in Pa are the values at the velocity nodes of the LumenSpace `space`.
    On the wall this velocity is set to 0.
    """

    def __init__(self, predicted, space):
        self.predicted = predicted
        self.velocity, self.pressure = predicted.fields(space.nodes()[0])
        self.velocity[space.wall_nodes()] = 0.0

    def __call__(self, points):
        """(velocity (m, 3) in m/s, pressure (m,) in Pa, inside (m,) always True) at points (m, 3) in m."""
        velocity, pressure = self.predicted.fields(points)
        return velocity, pressure, np.ones(len(points), bool)


class Reduced:
    """The answer of the reduced model `model`, with its fields on the mesh file `path`.

    It has the attributes of a solvers.solved_mesh.Solved that flow.solve reads. predicted: reduced.coupled.Predictor.
    Raises ComputationError where the axisymmetric model has no answer.
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
        """Does nothing, since the caller destroys the Predictor. flow.solve calls `destroy` of every answer."""

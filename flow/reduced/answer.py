"""The answer of a reduced model alone (setting `model`). It fills the same output files as a 3D solve."""

import numpy as np

from common.errors import ComputationError
from flow.discretisation import spaces
from flow.solvers import solved_mesh

MODEL_NAMES = {
    "axisymmetric": "axisymmetric Navier-Stokes in branch {branch}, 1D network elsewhere",
    "network": "1D network",
}

# Largest |FFR of the 3D model minus FFR of the reduced model| in the nine patients' trees, rounded up. The first value
# holds where the reduced model's FFR is at least MILD_FFR, the second below it. Unrounded they are .055 and .106
# (axisymmetric), .058 and .056 (network); see measured.md.
ERROR_IN_OTHER_PATIENTS = {"axisymmetric": (0.06, 0.11), "network": (0.06, 0.06)}
MILD_FFR = 0.85

# The measured error of each model's FFR, as words for a warning. The errors with one lesion are from measured.md. With
# two (tandem_60 of tests/verification/flow/hard_cases.py) the network had an FFR of .7109, the reference .7344.
MEASURED_ERROR_WORDS = {
    "axisymmetric": "within .0002 of an independent solution in straight round tubes with lesions of 62 to 90 %",
    "network": "up to .01 above an independent solution in straight round tubes with one lesion of 62 to 90 %, .02"
    " below it with two",
}


def unknown_error_warning(model):
    """[warning] that the error of this FFR is not known. It quotes the model's error in other lumens."""
    trees = f"up to {max(ERROR_IN_OTHER_PATIENTS[model]):.2f} above the 3D model in trees, which bend and branch"
    return [f"the error of this FFR is not known; the {model} model was {MEASURED_ERROR_WORDS[model]}, and {trees}"]


class Sampler:
    """Velocity and pressure of a reduced.coupled.Predictor, read at points like a geometry.locate.FieldSampler.

    `velocity` (n, 3) in m/s and `pressure` (n,) in Pa are the values at the velocity nodes of the LumenSpace `space`.
    On the wall this velocity is set to 0.
    """

    def __init__(self, predictor, space):
        self.predictor = predictor
        self.velocity, self.pressure = predictor.fields(space.nodes()[0])
        self.velocity[space.wall_nodes()] = 0.0

    def __call__(self, points):
        """(velocity (m, 3) in m/s, pressure (m,) in Pa, inside (m,) always True) at points (m, 3) in m."""
        velocity, pressure = self.predictor.fields(points)
        return velocity, pressure, np.ones(len(points), bool)


class ReducedAnswer:
    """The answer of the reduced model `model`, with its fields on the mesh file `path`.

    It has the attributes of a solvers.solved_mesh.SolvedMesh that flow.solve reads. predictor:
    reduced.coupled.Predictor. Raises ComputationError where the axisymmetric model has no answer.
    """

    status, estimate = solved_mesh.CONVERGED, None

    def __init__(self, model, predictor, path):
        self.space = spaces.read(path)
        if model == "axisymmetric" and predictor.tube is None:
            raise ComputationError(
                "the axisymmetric model has no answer", "model", predictor.reason, "use another model"
            )
        network = predictor.network
        self.sampler = Sampler(predictor, self.space)
        self.model = MODEL_NAMES[model].format(branch=predictor.branch.name)
        self.outlet_names, self.outflows, self.inflow = (
            network.outlet_names,
            predictor.flows,
            float(predictor.flows.sum()),
        )
        self.pressures = [predictor.pressures[outlet["branch"]][1][-1] for outlet in network.outlets]
        self.dofs = predictor.tube.dofs if predictor.tube else len(network.segments)

    def destroy(self):
        """Does nothing, since the caller destroys the Predictor. flow.solve calls `destroy` of every answer."""

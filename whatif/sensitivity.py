"""How much FFR and areas depend on uncertain inputs: of the flow alone, and of flow and procedure together."""

import copy
import pathlib
import tempfile

from common.errors import ComputationError, InputError
from whatif import calibrated, engine, sampling, segmentation
from whatif.case import BEFORE, PLANNED, patient_of
from whatif.flow_inputs import Input, boundary_at, inputs_of

FFR, AREA = "ffr", "minimal_stent_area_mm2"
FLOW_SAMPLES, DEPLOYMENT_SAMPLES = 128, 16
DEPLOYMENT = (
    Input("balloon_pressure", "pressure in every balloon", -20.0, 0.0, 20.0, "%"),
    Input("placement", "place of every device", -2.0, 0.0, 2.0, "mm"),
    Input("wall_stiffness", "stiffness of the wall", 0.5, 1.0, 2.0, "times", "log"),
    Input("plaque_stiffness", "stiffness of the plaque", 0.5, 1.0, 2.0, "times", "log"),
)


class Answers:
    """FFR with varied inputs of the flow, by the 1D network. Its losses are scaled to the 3D answer of each state."""

    def __init__(self, case, case_file):
        self.case = case
        self.patient, self.measured = patient_of(case_file)
        self.inputs = inputs_of(self.patient, case.flow, len(case.boundary["outlets"]))
        self.inputs.append(segmentation.radius_input())
        self.solved = {state: case.answer(state) for state in (BEFORE, PLANNED)}
        self.lumens = {state: case.lumen(case.anatomy(state)) for state in self.solved}
        self.planned = {state: self.loss(state, {}) for state in self.lumens}

    def loss(self, state, values, other=None):
        """The network's loss (1 - FFR) in a state's lumen, with inputs of the flow at `values`.

        other: (scene, lumen) of another procedure, which takes the place of the state's.
        """
        document = boundary_at(self.case, self.patient, self.measured, values)
        # the probes stay at the study's places, whatever the inputs are
        document["probes"] = self.case.boundary["probes"]
        scene, lumen = other or (self.case.scene, self.lumens[state])
        held = () if state == BEFORE else segmentation.stented(scene)  # an error of the image cannot widen a stent
        found = segmentation.at_radius(lumen, values.get(segmentation.NAME, 0.0), held)
        return calibrated.network_loss(found, document, self.case.flow.expansion_loss)

    def ffr(self, state, values, other=None):
        """FFR of a state: the 3D answer's loss, times the network's loss at `values` over its loss as planned.

        other: (scene, lumen) of another procedure, as for `loss`.
        """
        if not self.planned[state] > 0:
            return self.solved[state]["ffr"]
        grown = self.loss(state, values, other) / self.planned[state]
        return max(0.0, 1 - (1 - self.solved[state]["ffr"]) * grown)

    def of_flow(self, values):
        """{(state, "ffr"): FFR} of both states with inputs of the flow at `values`.

        Empty if the narrowing cannot pass as much flow as was measured.
        """
        try:
            return {(state, FFR): self.ffr(state, values) for state in self.lumens}
        except InputError as error:
            return no_answer(values, error.what)


class Deployments:
    """FFR and area after procedures with other pressures, places and stiffnesses, each deployed by the engine."""

    def __init__(self, answers, folder):
        self.answers, self.case, self.folder, self.count = answers, answers.case, pathlib.Path(folder), 0
        self.planned = self.case.json("vci/deployment.json")

    def __call__(self, values):
        """{("vci", quantity): value} with inputs at `values`; empty if the engine has no answer."""
        own = {one.name for one in DEPLOYMENT} & set(values)
        flow = {name: value for name, value in values.items() if name not in own}
        deployment, other = self.planned, None
        if own:
            self.count += 1
            scene = varied(self.case.scene, values)
            try:
                deployment, anatomy = engine.deployed(self.case, scene, self.folder / str(self.count))
            except engine.Refused as error:
                return no_answer(values, error.reason)
            other = scene, self.case.lumen(anatomy)
        try:
            found = {(PLANNED, FFR): self.answers.ffr(PLANNED, flow, other)}
        except InputError as error:
            return no_answer(values, error.what)
        area = deployment.get(AREA)
        return found if area is None else found | {(PLANNED, AREA): area}


def no_answer(values, reason):
    """Empty answers {} for inputs `values` that the engine or the flow refuses; prints the reason.

    The planned case (no values) must have answers: raises ComputationError.
    """
    if not values:
        raise ComputationError("no answer as planned", "sensitivity", reason, "see the study's own answers")
    print(f"no answer at {values}: {reason}")
    return {}


def varied(scene, values):
    """The content of scene.json with inputs of DEPLOYMENT at `values`.

    Pressures stay within the balloon's chart and 1.5 times its rated burst pressure, which the engine accepts.
    """
    scene = copy.deepcopy(scene)
    for step in scene["procedure"]:
        for use in step["devices"]:
            device = scene["devices"][use["device"]]
            balloon = scene["devices"][device["balloon"]] if device["kind"] == "stent" else device
            most = min(balloon["chart"]["pressure_bar"][-1], 1.5 * balloon["rated_burst_pressure_bar"])
            wanted = use["pressure_bar"] * (1 + values.get("balloon_pressure", 0.0) / 100)
            use["pressure_bar"] = max(use["pressure_bar"], most) if wanted > most else wanted
            use["centre_s_mm"] += values.get("placement", 0.0)
    for key in ("s_start_mm", "s_end_mm"):
        scene["segment"][key] += values.get("placement", 0.0)
    scene["wall"]["youngs_modulus_mpa"] *= values.get("wall_stiffness", 1.0)
    for plaque in scene["wall"]["plaque"].values():
        plaque["youngs_modulus_mpa"] *= values.get("plaque_stiffness", 1.0)
    return scene


def of_flow(case, case_file):
    """Two DataFrames (see `sampling`), tornado and intervals: FFR in both states over the inputs of the flow.

    The states are before and after the planned procedure.
    """
    answers = Answers(case, case_file)
    table = sampling.tornado(answers.inputs, answers.of_flow)
    return table, sampling.intervals(answers.inputs, FLOW_SAMPLES, answers.of_flow)


def of_deployment(case, case_file):
    """Two DataFrames (see `sampling`), tornado and intervals: FFR and stent area after the procedure.

    The first varies one input of the deployment at a time, the second all inputs of deployment and flow at once.
    """
    answers = Answers(case, case_file)
    with tempfile.TemporaryDirectory(dir=case.folder, prefix=".sensitivity-") as folder:
        deployments = Deployments(answers, folder)
        table = sampling.tornado(DEPLOYMENT, deployments)
        spread = sampling.intervals([*DEPLOYMENT, *answers.inputs], DEPLOYMENT_SAMPLES, deployments)
    return table, spread

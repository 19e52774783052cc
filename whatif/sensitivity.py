"""How much FFR and areas depend on uncertain inputs: on those of the flow alone, and on those of flow and procedure."""

import copy
import pathlib
import tempfile

from common.documents import plan_reader
from common.errors import ComputationError, InputError
from whatif import calibrated, engine, sampling, segmentation
from whatif.case import BEFORE, PLANNED, read_patient
from whatif.flow_inputs import Input, boundary_with_inputs, uncertain_inputs

FFR, STENT_AREA = "ffr", "minimal_stent_area_mm2"
FLOW_SAMPLES, DEPLOYMENT_SAMPLES = 128, 16
DEPLOYMENT_INPUTS = (
    Input("balloon_pressure", "pressure in every balloon", -20.0, 0.0, 20.0, "%"),
    Input("placement", "place of every device", -2.0, 0.0, 2.0, "mm"),
    Input("wall_stiffness", "stiffness of the wall", 0.5, 1.0, 2.0, "times", "log"),
    Input("plaque_stiffness", "stiffness of the plaque", 0.5, 1.0, 2.0, "times", "log"),
)


class VariedFlow:
    """FFR with varied inputs of the flow, by the 1D network, whose losses are scaled to each state's 3D answer.

    states: names of the states with a 3D answer whose FFR is wanted.
    """

    def __init__(self, case, case_file, states=(BEFORE, PLANNED)):
        self.case = case
        self.patient, self.measured = read_patient(case_file)
        self.inputs = uncertain_inputs(self.patient, case.flow_settings, len(case.boundary["outlets"]))
        self.inputs.append(segmentation.radius_input())
        self.flow_results = {state: case.flow_result(state) for state in states}
        self.lumens = {state: case.lumen(case.anatomy(state)) for state in self.flow_results}
        document = self.boundary_at({})
        self.planned = {state: self.loss(state, document, {}) for state in self.lumens}

    def boundary_at(self, values):
        """The content of boundary.json with inputs of the flow at `values`.

        Raises InputError if the narrowing before PCI cannot pass as much flow as was measured.
        """
        document = boundary_with_inputs(self.case, self.patient, self.measured, values)
        # the probes stay at the study's places, whatever the inputs are
        document["probes"] = self.case.boundary["probes"]
        return document

    def loss(self, state, document, values, procedure=None):
        """The network's loss (1 - FFR) in a state's lumen. document: result of `boundary_at` the same `values`.

        procedure: (scene, lumen) of another procedure, in place of the state's own.
        """
        scene, lumen = procedure or (self.case.scene, self.lumens[state])
        stented = (
            () if state == BEFORE else segmentation.stented_spans(scene)
        )  # an error of the image cannot widen a stent
        changed_lumen = segmentation.with_radius_change(lumen, values.get(segmentation.RADIUS_INPUT, 0.0), stented)
        return calibrated.network_loss(changed_lumen, document, self.case.flow_settings.expansion_loss)

    def ffr(self, state, document, values, procedure=None):
        """FFR of a state: the 3D answer's loss, times the network's loss at `values` over its loss as planned.

        document, procedure: as for `loss`.
        """
        if not self.planned[state] > 0:
            return self.flow_results[state]["ffr"]
        loss_ratio = self.loss(state, document, values, procedure) / self.planned[state]
        return max(0.0, 1 - (1 - self.flow_results[state]["ffr"]) * loss_ratio)

    def ffr_of_states(self, values):
        """{(state, "ffr"): FFR} of all states with inputs of the flow at `values`; empty if there is no answer."""
        try:
            document = self.boundary_at(values)
            return {(state, FFR): self.ffr(state, document, values) for state in self.lumens}
        except InputError as error:
            return report_no_answer(values, error.what)


class VariedDeployments:
    """FFR and area after procedures with other pressures, places and stiffnesses, each deployed by the engine."""

    def __init__(self, flow, folder):
        self.flow, self.case, self.folder, self.count = flow, flow.case, pathlib.Path(folder), 0
        self.planned = self.case.json("vci/deployment.json")

    def __call__(self, values):
        """{("vci", quantity): value} with inputs at `values`; empty if the engine has no answer."""
        deployment_names = {one.name for one in DEPLOYMENT_INPUTS} & set(values)
        flow_values = {name: value for name, value in values.items() if name not in deployment_names}
        deployment, procedure = self.planned, None
        if deployment_names:
            self.count += 1
            scene = scene_with_inputs(self.case.scene, values)
            try:
                deployment, anatomy = engine.deploy_and_measure(self.case, scene, self.folder / str(self.count))
            except engine.ProcedureFailed as error:
                return report_no_answer(values, error.reason)
            procedure = scene, self.case.lumen(anatomy)
        try:
            document = self.flow.boundary_at(flow_values)
            answers = {(PLANNED, FFR): self.flow.ffr(PLANNED, document, flow_values, procedure)}
        except InputError as error:
            return report_no_answer(values, error.what)
        area = deployment.get(STENT_AREA)
        return answers if area is None else answers | {(PLANNED, STENT_AREA): area}


def report_no_answer(values, reason):
    """Prints why the engine or the flow refuses the inputs `values`, and returns empty answers {}.

    Without values it is the planned case, which must have answers: raises ComputationError.
    """
    if not values:
        raise ComputationError("no answer as planned", "sensitivity", reason, "see the study's own answers")
    print(f"no answer at {values}: {reason}")
    return {}


def scene_with_inputs(scene, values):
    """The content of scene.json with inputs of DEPLOYMENT_INPUTS at `values`.

    The engine accepts pressures up to the end of the balloon's chart and up to 1.5 times its rated burst pressure. So a
    pressure is raised no further than this.
    """
    scene = copy.deepcopy(scene)
    for step in scene["procedure"]:
        for use in step["devices"]:
            balloon = plan_reader.inflating_balloon(scene["devices"], use["device"])
            max_pressure_bar = min(balloon["chart"]["pressure_bar"][-1], 1.5 * balloon["rated_burst_pressure_bar"])
            pressure_bar = use["pressure_bar"] * (1 + values.get("balloon_pressure", 0.0) / 100)
            use["pressure_bar"] = (
                max(use["pressure_bar"], max_pressure_bar) if pressure_bar > max_pressure_bar else pressure_bar
            )
            use["centre_s_mm"] += values.get("placement", 0.0)
    for key in ("s_start_mm", "s_end_mm"):
        scene["segment"][key] += values.get("placement", 0.0)
    scene["wall"]["youngs_modulus_mpa"] *= values.get("wall_stiffness", 1.0)
    for plaque in scene["wall"]["plaque"].values():
        plaque["youngs_modulus_mpa"] *= values.get("plaque_stiffness", 1.0)
    return scene


def flow_sensitivity(case, case_file, states):
    """Two DataFrames (see `sampling`): FFR over the inputs of the flow.

    The first, the tornado, varies one input at a time, before and after the planned procedure. The second has the
    intervals with all inputs varied at once, in all of `states`, which have a 3D answer.
    """
    flow = VariedFlow(case, case_file)
    table = sampling.one_at_a_time(flow.inputs, flow.ffr_of_states)
    every = VariedFlow(case, case_file, states)
    return table, sampling.sample_intervals(every.inputs, FLOW_SAMPLES, every.ffr_of_states)


def deployment_sensitivity(case, case_file):
    """Two DataFrames (see `sampling`): FFR and stent area after the procedure, over uncertain inputs.

    The first, the tornado, varies one input of the deployment at a time. The second has the intervals with all inputs
    of deployment and flow varied at once.
    """
    flow = VariedFlow(case, case_file)
    with tempfile.TemporaryDirectory(dir=case.folder, prefix=".sensitivity-") as folder:
        deployments = VariedDeployments(flow, folder)
        table = sampling.one_at_a_time(DEPLOYMENT_INPUTS, deployments)
        intervals = sampling.sample_intervals([*DEPLOYMENT_INPUTS, *flow.inputs], DEPLOYMENT_SAMPLES, deployments)
    return table, intervals

"""After a change of a file Snakemake plans exactly the jobs that depend on this file."""

import os
import time

import pytest

from tests.workflow.conftest import RECORD
from workflow.cohort import prune_results

pytestmark = pytest.mark.slow

STUDY_RULES = {
    "study_figures",
    "agreement",
    "nearer",
    "contrast",
    "differences",
    "seconds",
    "cohort",
    "timings",
    "patients",
}
STUDY_RULES |= {"software", "provenance", "report", "numbers", "crate"}
CASE = "quick_focal"
OTHER_CASE = "quick_branch"
FROM_CT = ("ct_vci", "ct_rc")
STATES = ("pre", "vci", "rc", "reference", "ct", *FROM_CT)
STATES_WITH_START = ("rc", "reference", "ct", *FROM_CT)  # the flows of these states start from the flow of `vci`
ANATOMY_RULES = ("state_anatomy", "half_maximum_anatomy")  # of lumens found in CT


def whatif_jobs(case):
    """Jobs beside the metrics that follow a change of a case's lumens, procedure or flow."""
    jobs = {f"other_plans {case}", f"flow_sensitivity {case}", f"sensitivity_figure {case}"}
    return jobs | {f"half_maximum_ffr {case}"} | arm_metrics_jobs(case)


def arm_metrics_jobs(case):
    """Jobs that follow a change of the lumens at half maximum, or of the lumens that they are compared with."""
    return {f"half_maximum_metrics {case}", "half_maximum_agreement"}


def final_jobs(case):
    """Jobs that follow any change of a case's results."""
    return {f"metrics {case}", f"case_figures {case}", f"ct_figure {case}"} | STUDY_RULES


def flow_jobs(case, states=STATES):
    """Jobs that mesh and solve the states, with their what-if jobs.

    If `vci` is among the states, the flows that start from its flow are solved again too.
    """
    solved = {*states, *STATES_WITH_START} if "vci" in states else states
    meshed = {f"flow_mesh {case} {state}" for state in states}
    return meshed | {f"flow_solve {case} {state}" for state in solved} | whatif_jobs(case)


def ct_jobs(case, states=("pre", "reference")):
    """Jobs for the CT of the states.

    The lumen from the CT of `reference` is the state `ct`. From the CT of `pre` the whole prediction is made anew.
    """
    rules = ("ct_phantom", "ct_segment", "half_maximum_segment")
    jobs = {f"{rule} {case} {state}" for rule in rules for state in states}
    if "pre" in states:
        jobs |= {f"{rule} {case} ct_pre" for rule in ANATOMY_RULES} | ct_prediction_jobs(case)
    if "reference" in states:
        jobs |= {f"{rule} {case} ct" for rule in ANATOMY_RULES} | flow_jobs(case, ["ct"])
    return jobs


def ct_prediction_jobs(case):
    """Jobs that follow a new plan or a new lumen in the CT before the procedure."""
    rules = ("carry_plan", "ct_scene", "half_maximum_carry_plan", "half_maximum_scene")
    return {f"{rule} {case}" for rule in rules} | ct_deployment_jobs(case)


def ct_deployment_jobs(case):
    """Jobs that follow a new scene or program for the lumen of the CT before the procedure."""
    rules = ("ct_deploy", "ct_radius_correct", "half_maximum_deploy", "half_maximum_radius_correct")
    jobs = {f"{rule} {case}" for rule in rules} | flow_jobs(case, FROM_CT)
    return jobs | {f"{rule} {case} {state}" for rule in ANATOMY_RULES for state in FROM_CT}


def jobs_after_plan(case):
    """Jobs that follow a new plan."""
    after = ("vci", "rc", "reference")
    deformed = {
        f"plan_picture {case}",
        f"scene {case}",
        f"deploy {case}",
        f"procedure_figure {case}",
        f"radius_correct {case}",
        f"reference {case}",
    }
    return (
        deformed
        | {f"state_anatomy {case} {state}" for state in after}
        | flow_jobs(case, after)
        | ct_jobs(case, ["reference"])
        | ct_prediction_jobs(case)
        | final_jobs(case)
    )


def jobs_after_anatomy(case):
    """Jobs that follow a new lumen before the procedure."""
    first = {f"anatomy_picture {case}", f"plan {case}", f"boundary {case}"}
    return first | flow_jobs(case, ["pre"]) | ct_jobs(case) | jobs_after_plan(case)


def test_nothing_to_do(finished):
    assert finished.planned_rules() == set()


def test_a_touched_file_without_new_content_runs_nothing(finished):
    time.sleep(0.01)
    os.utime(finished.folder / "config" / "devices" / "des.yaml")
    os.utime(finished.folder / "flow" / "inputs" / "boundary.py")
    assert finished.planned_rules() == set()


def test_lumen_program(finished):
    finished.append("build/lumen", "changed\n")
    expected = {f"anatomy {case}" for case in (CASE, OTHER_CASE)} | {"software"}
    assert finished.planned_rules() == expected | jobs_after_anatomy(CASE) | jobs_after_anatomy(OTHER_CASE)


def test_vci_program(finished):
    finished.append("build/vci", "changed\n")
    expected = {"software"}
    for case in (CASE, OTHER_CASE):
        expected |= {f"deploy {case}", f"procedure_figure {case}", f"radius_correct {case}"}
        expected |= {f"state_anatomy {case} {state}" for state in ("vci", "rc")} | flow_jobs(case, ("vci", "rc"))
        expected |= ct_deployment_jobs(case) | final_jobs(case)
    assert finished.planned_rules() == expected


def test_module_of_the_reference(finished):
    finished.append("data_synthetic/reference/solid/materials.py", "# changed\n")
    expected = set()
    for case in (CASE, OTHER_CASE):
        expected |= {f"reference {case}", f"state_anatomy {case} reference"} | flow_jobs(case, ["reference"])
        expected |= ct_jobs(case, ["reference"]) | final_jobs(case)
    assert finished.planned_rules() == expected


def test_module_of_the_segmentation(finished):
    finished.append("anatomy/ct/rays/edges.py", "# changed\n")
    expected = set()
    for case in (CASE, OTHER_CASE):
        expected |= (ct_jobs(case) - {f"ct_phantom {case} {state}" for state in STATES}) | final_jobs(case)
    assert finished.planned_rules() == expected


def test_module_of_one_figure(finished):
    finished.append("reports/figures/lumen.py", "# changed\n")
    figures = {f"{figure} {case}" for figure in ("case_figures", "procedure_figure") for case in (CASE, OTHER_CASE)}
    assert finished.planned_rules() == figures | RECORD


def test_device_of_a_plan(finished):
    """The plans of both quick cases name the device."""
    finished.edit("config/devices/non_compliant.yaml", "shoulder_mm: 1.8", "shoulder_mm: 1.9")
    planned = finished.planned_rules()
    assert planned == {f"plan {CASE}", f"plan {OTHER_CASE}"} | jobs_after_plan(CASE) | jobs_after_plan(OTHER_CASE)


def test_description_of_a_case(finished):
    """The metrics quote a case's description for the report. No other result depends on it."""
    finished.edit(f"config/cases/{CASE}.yaml", "description: ", "description: Renamed. ")
    assert finished.planned_rules() == final_jobs(CASE)


def test_comment_in_a_case(finished):
    finished.append(f"config/cases/{CASE}.yaml", "# seen by nobody\n")
    assert finished.planned_rules() == set()


def test_patient_of_a_case(finished):
    finished.edit(f"config/cases/{CASE}.yaml", "lvm_g: 130", "lvm_g: 135")
    expected = {f"plan {CASE}", f"boundary {CASE}", f"flow_solve {CASE} pre"} | jobs_after_plan(CASE)
    assert finished.planned_rules() == expected


def test_vessel_of_a_case(finished):
    finished.edit(f"config/cases/{CASE}.yaml", "seed: 4", "seed: 5")
    assert finished.planned_rules() == {f"generate {CASE}", f"anatomy {CASE}"} | jobs_after_anatomy(CASE)


@pytest.mark.parametrize(
    "section, key, rules",
    [
        ("flow", "cells_per_radius: 3.6", ("settings {} flow", "boundary {}")),
        ("metrics", "margin_mm: 2.5", ()),
    ],
)
def test_section_of_a_case(finished, section, key, rules):
    """A change of one section of one case's settings."""
    finished.append(f"config/cases/{CASE}.yaml", f"  {section}:\n    {key}\n")
    expected = {rule.format(CASE) for rule in rules} | final_jobs(CASE)
    assert finished.planned_rules() == expected | (flow_jobs(CASE) if section == "flow" else arm_metrics_jobs(CASE))


def test_section_of_the_study(finished):
    finished.append("config/study.yaml", "reference:\n  radius_step_mm: 0.2\n")
    expected = set()
    for case in (CASE, OTHER_CASE):
        expected |= {f"settings {case} reference", f"reference {case}", f"state_anatomy {case} reference"}
        expected |= flow_jobs(case, ["reference"]) | ct_jobs(case, ["reference"]) | final_jobs(case)
    assert finished.planned_rules() == expected


def test_numerics_of_the_deployment_leave_the_reference_alone(finished):
    finished.append("config/study.yaml", "deployment:\n  numerics:\n    residual_tolerance: 0.002\n")
    planned = finished.planned_rules()
    assert {f"deploy {CASE}", f"ct_deploy {CASE}"} <= planned
    of_reference = {job for job in planned if "reference" in job.split()}
    assert of_reference == {
        f"flow_solve {case} reference" for case in (CASE, OTHER_CASE)
    }, "it starts from the prediction's"


def test_a_pruned_patient_runs_nothing_again(finished):
    """Pruning removes the surfaces and meshes of a finished patient. Its metrics must not be made again for that."""
    metrics = f"results/cases/{CASE}/metrics.json"
    assert (finished.folder / f"results/cases/{CASE}/flow/vci/mesh.msh").exists()
    prune_results(finished.folder / f"results/cases/{CASE}")
    assert not (finished.folder / f"results/cases/{CASE}/flow/vci/mesh.msh").exists()
    assert finished.planned_rules(metrics) == set()
    finished.append("build/vci", "changed\n")
    assert {f"anatomy {CASE}", f"deploy {CASE}", f"metrics {CASE}"} <= finished.planned_rules(metrics)

# The study: from the cases and devices in config/ to results/report/index.html. docs/workflow.md says how to use it.
import os
import sys

sys.path.insert(0, workflow.basedir)

from snakemake.common import Mode
from snakemake.exceptions import WorkflowError

from common.errors import UserError
from common.patient.states import CT_IMAGED_STATES
from workflow.configuration import COARSE_MESHES, Configuration
from workflow.failed import cases_of_failed_arms, without_failed
from workflow.half_maximum import ARM_STATES, HalfMaximum
from workflow.imports import code, command_code, flow_benchmark_code, module_code
from workflow.inputs import (
    ANATOMY_STATES,
    Inputs,
    anatomy_folder,
    benchmark_folder,
    benchmark_tables,
    case_folder,
    cohort_option,
    failed_option,
    procedure_sensitivity_tables,
    figures_folder,
    frames_option,
    output_folder,
    programs_folder,
    solved_plans,
    start_option,
    stent_options,
    stented_option,
    study_folder,
    test_results,
)
from workflow.rules.resources import WHOLE_NODE, fixed_resources, resources_by_size

try:
    STUDY = Configuration(config.get("folder", "config"), leave_out_bad_cases=True)
    COHORT = config.get("cohort", "nine")
    FAILED = config.get("failed")  # failed.json of `workflow failed`; the study leaves out the cases in it
    CASES = without_failed(STUDY.selected_cases(COHORT, config.get("cases")), FAILED)
    FAILED_ARMS = cases_of_failed_arms(FAILED)
except UserError as error:
    raise WorkflowError(str(error)) from None
if workflow.mode == Mode.default:  # not in the processes of the jobs
    for name, error in STUDY.refused.items():
        print(f"the case {name} cannot run: {error}", file=sys.stderr)

INPUTS = Inputs(STUDY)
HALF_MAXIMUM = HalfMaximum(INPUTS)
HALF_MAXIMUM_CASES = [case for case in HALF_MAXIMUM.arm_cases(CASES) if case not in FAILED_ARMS]
# Rules take a case's file as `ancient` (its date does not count) and the sections they use as parameters. So a change
# of the file re-runs only the rules that use the changed section.
CASE_FILE = str(STUDY.case_file("{case}"))
BUILD = config.get("build", "build")
VCI, LUMEN = os.path.join(BUILD, "vci"), os.path.join(BUILD, "lumen")
FLOW_FACTORS = os.path.join(BUILD, "python", "flow_factors.so")
os.environ.update(VCI_BUILD_DIR=os.path.abspath(BUILD))  # where the flow looks for FLOW_FACTORS


wildcard_constraints:
    case="|".join(STUDY.cases),
    state="|".join(ANATOMY_STATES),
    plan="shorter|longer|larger|smaller|pressure|predilatation|postdilatation",
    section="anatomy|deployment|flow|reference|ct|metrics",


localrules:
    all,
    benchmarks,
    best_plans,
    half_maximum_settings,
    settings,


rule all:
    default_target: True
    input:
        "results/report/index.html",
        "results/ro-crate-metadata.json",


include: "workflow/rules/geometry.smk"
include: "workflow/rules/deployment.smk"
include: "workflow/rules/ct.smk"
include: "workflow/rules/flow.smk"
include: "workflow/rules/whatif.smk"
include: "workflow/rules/study.smk"
include: "workflow/rules/half_maximum.smk"
include: "workflow/rules/benchmarks.smk"
include: "workflow/rules/flow_benchmarks.smk"

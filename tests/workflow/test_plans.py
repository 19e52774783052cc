"""The jobs that Snakemake plans for whole cohorts, single targets and single cases."""

import collections
import graphlib
import json
import os
import re

import pytest
import yaml

from tests.support.places import ROOT
from tests.workflow.conftest import RECORD
from whatif import alternatives

pytestmark = pytest.mark.slow

SEGMENTATIONS = ("ct_segment", "half_maximum_segment")


def test_dry_run_of_a_fresh_clone_plans_every_state(fresh):
    planned = fresh.planned_rules()
    for case in ("quick_focal", "quick_branch"):
        assert {f"flow_solve {case} {state}" for state in ("pre", "vci", "rc", "reference", "ct", "ct_vci")} <= planned
        found = {f"{rule} {case} {state}" for rule in SEGMENTATIONS for state in ("pre", "reference")}
        assert found | {f"half_maximum_metrics {case}"} <= planned
    assert "report" in planned


@pytest.mark.parametrize("cohort", ["three", "contrast"])
def test_no_product_of_two_jobs(fresh, cohort):
    makers = collections.Counter(
        name
        for job in fresh.planned_jobs(cohort=cohort)
        for name in [*job["output"], *job["log"], job["benchmark"]]
        if name
    )
    assert [name for name, count in makers.items() if count > 1] == []


def test_every_rule_keeps_a_log_and_a_benchmark(fresh):
    jobs = [job for job in fresh.planned_jobs(cohort="three") if job["name"] != "all"]
    assert [job["name"] for job in jobs if not job["log"]] == []
    without = {job["name"] for job in jobs if not job["benchmark"]}
    assert without == {"settings", "half_maximum_settings"}, "only writing down settings is not worth a benchmark"


def test_every_rule_has_its_code_or_program_among_its_inputs(fresh):
    for job in fresh.planned_jobs():
        if job["name"] in ("all", "settings", "half_maximum_settings"):
            continue
        programs = [name for name in job["input"] if name.endswith(".py") or name in ("build/vci", "build/lumen")]
        assert programs, f"{job['name']} would not run again after a change of its program"


def test_single_target(fresh):
    planned = fresh.planned_rules("results/cases/quick_focal/flow/vci/ffr.json")
    assert "flow_solve quick_focal vci" in planned
    assert not {job for job in planned if "quick_branch" in job or "reference" in job or "report" in job}


def test_an_audit_in_time_is_made_only_when_asked_for(fresh):
    assert not [job for job in fresh.planned_rules() if job.startswith("flow_audit")]
    planned = fresh.planned_rules("results/cases/quick_focal/flow/pre/audit.json")
    assert "flow_audit quick_focal pre" in planned and "flow_mesh quick_focal pre" in planned
    assert not [job for job in planned if job.startswith("flow_solve")]


@pytest.mark.parametrize(
    "target, words",
    [
        ("lad99/metrics.json", "No rule to produce results/cases/lad99/metrics.json"),
        ("real_artery/reference/lumen.vtp", "results/cases/real_artery/source/truth.json"),
    ],
)
def test_a_target_that_cannot_be_made_is_named(fresh, shared_data, target, words):
    """The targets are of an unknown case, and the reference of a user's own surface, which has no truth."""
    environment = {"VCI_DATA_DIR": str(shared_data("dfemtoolz_case4_artery.stl").parent)}.items()
    run = fresh.snakemake("--dry-run", f"results/cases/{target}", environment=environment)
    text = run.stdout + run.stderr
    assert run.returncode != 0 and words in text and "Traceback" not in text, text


def test_benchmarks_stand_apart_and_feed_the_report(finished):
    """The study plans no benchmark. After a benchmark only the report and the crate are made again."""
    names = {"deployment_speed", "deployment_baseline", "deployment_hard_cases", "deployment_sensitivity"}
    names |= {"deployment_against_published"}
    names |= {
        "flow_hard_cases",
        "anatomy_speed",
        "anatomy_campaign",
        "reference_against_solid",
        "reference_straightening",
        "reference_sensitivity",
        "benchmarks",
    }
    assert finished.planned_rules() == set()
    assert finished.planned_rules("benchmarks") == names
    by_name = ("flow_against_openfoam", "flow_growth", "flow_tolerance")
    by_name += ("flow_wall_shear", "flow_fda_jet", "flow_finer_mesh", "deployment_coarse_walls")
    by_name += ("deployment_calcium_strength", "flow_starts", "deployment_baseline_patients")
    for name in (*by_name, "reference_against_calculix"):
        assert finished.planned_rules(name) == {name}, "by its name only"
    patient = finished.planned_rules("flow_tree_against_openfoam") - {"flow_tree_against_openfoam"}
    assert "flow_solve lcx02 pre" in patient, "one state is that of a patient, whom this study does not have"
    assert all("lcx02" in rule for rule in patient), patient
    table = finished.folder / "results" / "benchmarks" / "flow_hard_cases" / "hard_cases.csv"
    table.parent.mkdir(parents=True)
    table.write_text("case,ffr\nsharp bend,0.89\n")
    assert finished.planned_rules() == {"report", "crate"}
    os.utime(table, (1e9, 1e9))  # now the table is older than the benchmark's code, as after an update
    assert finished.planned_rules() == {"report", "crate"}


def test_the_flow_of_another_plan_is_solved_only_when_asked_for(finished):
    ffr = "results/cases/quick_focal/plans/larger/flow/ffr.json"
    steps = ("plan_lumen", "plan_mesh", "plan_solve")
    assert finished.planned_rules(ffr) == {f"{step} quick_focal" for step in steps}
    (finished.folder / ffr).parent.mkdir(parents=True)
    (finished.folder / ffr).write_text("{}")
    assert finished.planned_rules() == RECORD, "which show it"


def test_every_other_plan_may_be_asked_for():
    constraint = re.search(r'plan="([^"]+)"', (ROOT / "Snakefile").read_text(encoding="utf-8"))
    assert constraint.group(1).split("|") == list(alternatives.all_alternatives([], {}))


def test_pressures_and_places_are_varied_only_when_asked_for(finished):
    table = "results/cases/quick_focal/sensitivity/deployment.csv"
    assert finished.planned_rules(table) == {"procedure_sensitivity quick_focal"}
    (finished.folder / table).write_text("input\n")
    assert finished.planned_rules() == {"sensitivity_figure quick_focal"} | RECORD, "which show it"


def test_forcerun(finished):
    planned = finished.planned_rules("--forcerun", "radius_correct")
    assert {"radius_correct quick_focal", "radius_correct quick_branch"} <= planned
    assert not {job for job in planned if job.startswith(("deploy", "reference", "plan"))}


def test_single_case(fresh):
    run = fresh.snakemake("--dry-run", cases="lad01")
    text = run.stdout + run.stderr
    assert run.returncode == 0, text
    assert "lad01: virtual deployment" in text and "rca01" not in text


def test_a_surface_case_has_no_reference(fresh):
    run = fresh.snakemake("--dry-run", cases="ivus_plaque")
    text = run.stdout + run.stderr
    assert run.returncode == 0, text
    assert "ivus_plaque: flow of vci" in text
    assert "reference" not in text


def test_a_case_without_ct_has_none(fresh):
    fresh.append("config/cases/quick_focal.yaml", "  ct: {enabled: false}\n")
    planned = fresh.planned_rules()
    of_ct = (" ct_", "ct_", "half_maximum")
    assert not {job for job in planned if "quick_focal" in job and (of_ct[0] in job or job.startswith(of_ct[1:]))}
    assert "half_maximum_metrics quick_branch" in planned
    assert "carry_plan quick_focal" not in planned
    assert "flow_solve quick_focal ct" not in planned and "flow_solve quick_branch ct" in planned


def test_lumens_at_half_maximum_only_where_the_study_finds_them_otherwise(fresh):
    """Lumens at half maximum are a second arm, unless the study's own method is half maximum. If a step of this arm
    failed for a case, only this arm is left out."""
    step = {"case": "quick_branch", "step": "half_maximum/deploy", "exit_code": 3, "message": "refused", "log": "a.log"}
    failed = {"failed": [step]}
    (fresh.folder / "failed.json").write_text(json.dumps(failed))
    planned = fresh.planned_rules(more=["failed=failed.json"])
    assert "half_maximum_metrics quick_focal" in planned and "metrics quick_branch" in planned
    assert not {job for job in planned if job.startswith("half_maximum") and "quick_branch" in job}
    fresh.append("config/cases/quick_focal.yaml", "  ct: {segmentation: {method: half_maximum}}\n")
    planned = fresh.planned_rules()
    assert not {job for job in planned if job.startswith("half_maximum") and "quick_focal" in job}
    assert "ct_segment quick_focal pre" in planned and "half_maximum_metrics quick_branch" in planned


def test_radius_correction_by_the_stents_alone_where_it_is_asked_for(fresh):
    assert not [job for job in fresh.planned_rules() if "rc_stent" in job or "stent_alone" in job]
    planned = fresh.planned_rules(cohort="contrast")
    for case in ("contrast_bend", "contrast_overlap"):
        assert {f"stent_alone {case}", f"stent_alone_radius_correct {case}", f"flow_solve {case} rc_stent"} <= planned


def test_a_plan_in_two_branches_has_no_reference(fresh):
    run = fresh.snakemake("--dry-run", cases="culotte_bench")
    text = run.stdout + run.stderr
    assert run.returncode == 0, text
    assert "culotte_bench: flow of vci" in text
    assert "reference lumen" not in text and "CT of" not in text


@pytest.mark.parametrize("cohort", ["nine", "three", "quick", "contrast", "hard"])
def test_shipped_cohorts_are_complete(fresh, cohort):
    assert fresh.planned_rules(cohort=cohort)


def test_a_real_patient_after_the_procedure_is_a_state(fresh, tmp_path):
    """The lumen after the procedure is read from a file and registered to the lumen before. Then it is processed and
    solved as the state `post`."""
    (tmp_path / "before.stl").write_text("solid")
    (tmp_path / "after.stl").write_text("solid")
    (fresh.folder / "config/cases/patient.yaml").write_text(
        "kind: surface\ndescription: a patient\npatient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80}\n"
        "lumen: {path: data/before.stl, units: mm}\n"
        "post: {path: data/after.stl, units: cm, inlet_point_mm: [1, 2, 3]}\n"
        "measured: {ffr_pre: 0.7, ffr_post: 0.9, probe: {branch: main, s_mm: 40}}\n"
    )
    run = fresh.snakemake(
        "--dry-run", "--printshellcmds", cases="patient", environment={"VCI_DATA_DIR": str(tmp_path)}.items()
    )
    text = run.stdout + run.stderr
    assert run.returncode == 0, text
    own = "--units cm --inlet 1,2,3 --edge 0.4 --spacing 0.5 --out results/cases/patient/post/own"
    assert f"lumen process {tmp_path}/after.stl {own}" in text
    assert "anatomy register config/cases/patient.yaml --pre results/cases/patient/anatomy" in text
    assert "process results/cases/patient/post/lumen.vtp --units mm --like results/cases/patient/post/like.json" in text
    assert "patient: flow of post" in text and "--states pre vci rc post" in text


def test_contours_after_the_procedure_are_compared_by_their_areas(fresh):
    run = fresh.snakemake("--dry-run", cases="ivus_stent")
    text = run.stdout + run.stderr
    assert run.returncode == 0, text
    assert "ivus_stent: lumen of the contours after the real procedure" in text
    assert "ivus_stent: flow of rc" in text and "flow of post" not in text


@pytest.mark.parametrize("cohort", ["nine", "hard", "real"])
def test_groups_of_the_slurm_profile_never_wait_for_their_own_steps(fresh, cohort):
    """If a step outside a group stood between two steps of the group, neither job could ever start."""
    profile = yaml.safe_load((fresh.folder / "config/profiles/slurm/config.yaml").read_text())
    groups = dict(entry.split("=") for entry in profile["groups"])
    jobs = fresh.planned_jobs(cohort=cohort)
    makers = {file: k for k, job in enumerate(jobs) for file in job["output"]}
    before = {k: {makers[file] for file in job["input"] if file in makers} for k, job in enumerate(jobs)}
    whole = {k: k for k in before}  # union-find: leads from a job to the job that stands for its group

    def first(k):
        return k if whole[k] == k else first(whole[k])

    for k, others in before.items():
        for other in others:
            group = groups.get(jobs[k]["name"])
            if group and group == groups.get(jobs[other]["name"]):
                whole[first(k)] = first(other)
    graph = {first(k): set() for k in before}
    for k, others in before.items():
        graph[first(k)] |= {first(other) for other in others} - {first(k)}
    assert list(graphlib.TopologicalSorter(graph).static_order())
    submitted = {
        first(k) for k, job in enumerate(jobs) if job["name"] not in ("all", "settings", "half_maximum_settings")
    }
    cases = {job["wildcards"]["case"] for job in jobs if "case" in job["wildcards"]}
    flows = sum(job["name"] == "flow_solve" for job in jobs)  # each is a job of its own
    assert len(submitted) <= 1 + 5 * len(cases) + flows, "most steps take seconds, less than to submit them"

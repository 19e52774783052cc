# Other plans for a case, and the sensitivity of FFR and areas. The 1D network, calibrated on 3D flow, gives FFR.
from whatif.best_plans import flows_of_best_plans

# VARIED: files of a finished case, the inputs of the rules that vary it.
VARIED = [
    INPUTS.files_of_states("flow/{state}/ffr.json", "{anatomy}/anatomy.json", "{anatomy}/sections.csv"),
    "results/cases/{case}/anatomy/lumen.vtp",
    "results/cases/{case}/anatomy/centreline.vtp",
    "results/cases/{case}/settings/flow.json",
    "results/cases/{case}/flow/boundary.json",
    "results/cases/{case}/vci/lumen.vtp",
    "results/cases/{case}/vci/deployment.json",
]
DEVICES = sorted(str(file) for file in (STUDY.folder / "devices").glob("*.yaml"))
STATE_FILES = ("lumen.vtp", "centreline.vtp", "sections.csv", "anatomy.json")  # the anatomy of a lumen, for its flow
PLAN_ANATOMY = {name.partition(".")[0]: f"results/cases/{{case}}/plans/{{plan}}/anatomy/{name}" for name in STATE_FILES}


rule other_plans:
    message:
        "{wildcards.case}: other plans, deployed and ranked"
    input:
        VARIED,
        scene="results/cases/{case}/vci/scene.json",
        programs=[VCI, LUMEN],
        devices=DEVICES,
        code=command_code("whatif", "run_plans"),
    output:
        ranking="results/cases/{case}/plans/ranking.csv",
        plans="results/cases/{case}/plans/plans.json",
    log:
        "results/cases/{case}/logs/whatif/other_plans.log",
    benchmark:
        "results/cases/{case}/benchmarks/whatif/other_plans.tsv"
    resources:
        **fixed_resources(1500, 15),
    params:
        case_dir=case_folder,
        states=lambda wildcards: " ".join(INPUTS.states_with_flow(wildcards.case)),
        build=programs_folder,
        edge=INPUTS.setting("anatomy", "edge_mm"),
        spacing=INPUTS.setting("anatomy", "section_spacing_mm"),
        devices=STUDY.folder / "devices",
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m whatif plans --case-dir {params.case_dir} --states {params.states}"
        " --programs {params.build} --edge {params.edge} --spacing {params.spacing} --devices {params.devices} --out {output.ranking}"


# The next three rules give the 3D flow of one plan. They run only if its file is asked for: few plans are worth the time.
rule plan_lumen:
    message:
        "{wildcards.case}: lumen after the plan {wildcards.plan}, by its own name only"
    input:
        plans="results/cases/{case}/plans/plans.json",
        scene="results/cases/{case}/vci/scene.json",
        before=[f"results/cases/{{case}}/anatomy/{name}" for name in ("lumen.vtp", "centreline.vtp", "anatomy.json")],
        devices=DEVICES,
        programs=[VCI, LUMEN],
        code=command_code("whatif", "run_deploy"),
    output:
        lumen="results/cases/{case}/plans/{plan}/lumen.vtp",
        deployment="results/cases/{case}/plans/{plan}/deployment.json",
        anatomy=[f"results/cases/{{case}}/plans/{{plan}}/anatomy/{name}" for name in STATE_FILES],
    log:
        "results/cases/{case}/logs/whatif/{plan}/lumen.log",
    benchmark:
        "results/cases/{case}/benchmarks/whatif/{plan}/lumen.tsv"
    params:
        case_dir=case_folder,
        out=output_folder,
        build=programs_folder,
        edge=INPUTS.setting("anatomy", "edge_mm"),
        spacing=INPUTS.setting("anatomy", "section_spacing_mm"),
        devices=STUDY.folder / "devices",
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m whatif deploy {wildcards.plan} --plans {input.plans}"
        " --case-dir {params.case_dir} --programs {params.build} --edge {params.edge} --spacing {params.spacing}"
        " --devices {params.devices} --out {params.out}"


use rule flow_mesh as plan_mesh with:
    message:
        "{wildcards.case}: volume mesh of the plan {wildcards.plan}"
    input:
        **PLAN_ANATOMY,
        settings="results/cases/{case}/settings/flow.json",
        code=command_code("flow", "mesh_command"),
    output:
        mesh="results/cases/{case}/plans/{plan}/flow/mesh.msh",
        coarse=[f"results/cases/{{case}}/plans/{{plan}}/flow/{name}" for name in COARSE_MESHES],
        summary="results/cases/{case}/plans/{plan}/flow/mesh.json",
    log:
        "results/cases/{case}/logs/whatif/{plan}/flow_mesh.log",
    benchmark:
        "results/cases/{case}/benchmarks/whatif/{plan}/flow_mesh.tsv"


use rule flow_solve as plan_solve with:
    message:
        "{wildcards.case}: flow of the plan {wildcards.plan}"
    input:
        **PLAN_ANATOMY,
        mesh="results/cases/{case}/plans/{plan}/flow/mesh.msh",
        coarse=[f"results/cases/{{case}}/plans/{{plan}}/flow/{name}" for name in COARSE_MESHES],
        summary="results/cases/{case}/plans/{plan}/flow/mesh.json",
        start=["results/cases/{case}/flow/vci/solution.vtu", "results/cases/{case}/flow/vci/ffr.json"],
        start_centreline="results/cases/{case}/vci/anatomy/centreline.vtp",
        boundary="results/cases/{case}/flow/boundary.json",
        settings="results/cases/{case}/settings/flow.json",
        code=command_code("flow", "solve_command"),
    output:
        solution="results/cases/{case}/plans/{plan}/flow/solution.vtu",
        ffr="results/cases/{case}/plans/{plan}/flow/ffr.json",
        pullback="results/cases/{case}/plans/{plan}/flow/pullback.csv",
    log:
        "results/cases/{case}/logs/whatif/{plan}/flow_solve.log",
    benchmark:
        "results/cases/{case}/benchmarks/whatif/{plan}/flow_solve.tsv"


rule best_plans:
    message:
        "flow in three dimensions of the two best plans of each case, by its own name only"
    input:
        lambda wildcards: flows_of_best_plans(CASES),


rule flow_sensitivity:
    message:
        "{wildcards.case}: FFR over the uncertain inputs of the flow"
    input:
        VARIED,
        scene="results/cases/{case}/vci/scene.json",
        case=ancient(CASE_FILE),
        code=command_code("whatif", "run_flow"),
    output:
        table="results/cases/{case}/sensitivity/flow.csv",
        intervals="results/cases/{case}/sensitivity/flow_intervals.csv",
    log:
        "results/cases/{case}/logs/whatif/flow_sensitivity.log",
    benchmark:
        "results/cases/{case}/benchmarks/whatif/flow_sensitivity.tsv"
    params:
        patient=INPUTS.section("patient"),
        case_dir=case_folder,
        states=lambda wildcards: " ".join(INPUTS.states_with_flow(wildcards.case)),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m whatif flow --case-dir {params.case_dir} --config {input.case}"
        " --states {params.states} --intervals {output.intervals} --out {output.table}"


# This rule deploys two dozen times for each case. So it is no part of the study and runs only if its file is asked for.
# The next report shows the result.
rule procedure_sensitivity:
    message:
        "{wildcards.case}: FFR and stent area over pressures, places and stiffnesses, by its own name only"
    input:
        VARIED,
        scene="results/cases/{case}/vci/scene.json",
        case=ancient(CASE_FILE),
        programs=[VCI, LUMEN],
        code=command_code("whatif", "run_deployment"),
    output:
        table="results/cases/{case}/sensitivity/deployment.csv",
        intervals="results/cases/{case}/sensitivity/deployment_intervals.csv",
    log:
        "results/cases/{case}/logs/whatif/procedure_sensitivity.log",
    benchmark:
        "results/cases/{case}/benchmarks/whatif/procedure_sensitivity.tsv"
    resources:
        **fixed_resources(1500, 120),
    params:
        patient=INPUTS.section("patient"),
        case_dir=case_folder,
        build=programs_folder,
        edge=INPUTS.setting("anatomy", "edge_mm"),
        spacing=INPUTS.setting("anatomy", "section_spacing_mm"),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m whatif deployment --case-dir {params.case_dir} --config {input.case}"
        " --programs {params.build} --edge {params.edge} --spacing {params.spacing} --intervals {output.intervals} --out {output.table}"


rule sensitivity_figure:
    message:
        "{wildcards.case}: what FFR and area hang on"
    input:
        table="results/cases/{case}/sensitivity/flow.csv",
        intervals="results/cases/{case}/sensitivity/flow_intervals.csv",
        deployment=lambda wildcards: procedure_sensitivity_tables([wildcards.case]),
        code=code("reports", "reports.whatif.tornado"),
    output:
        multiext("results/figures/{case}_sensitivity.", "svg", "png"),
    log:
        "results/cases/{case}/logs/sensitivity_figure.log",
    benchmark:
        "results/cases/{case}/benchmarks/sensitivity_figure.tsv"
    params:
        case_dir=lambda wildcards, input: os.path.dirname(os.path.dirname(input.table)),
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports sensitivity --case-dir {params.case_dir} --out-dir {params.out}"

# The lumen after the procedure by three methods: virtual deployment, radius correction, independent finite elements.


rule plan:
    message:
        "{wildcards.case}: devices and steps of the procedure"
    input:
        case=ancient(CASE_FILE),
        devices=INPUTS.device_files,
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        centreline="results/cases/{case}/anatomy/centreline.vtp",
        sections="results/cases/{case}/anatomy/sections.csv",
        anatomy="results/cases/{case}/anatomy/anatomy.json",
        code=code("anatomy", "anatomy.planning.plan"),
    output:
        "results/cases/{case}/vci/plan.json",
    priority: 2  # early, so that a device that does not fit is refused before any flow is computed
    log:
        "results/cases/{case}/logs/plan.log",
    benchmark:
        "results/cases/{case}/benchmarks/plan.tsv"
    params:
        plan=INPUTS.section("plan"),
        patient=INPUTS.section("patient"),
        anatomy=anatomy_folder,
        devices=STUDY.folder / "devices",
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy plan {input.case} --anatomy {params.anatomy}"
        " --devices {params.devices} --out {output}"


rule plan_picture:
    message:
        "{wildcards.case}: picture of the plan"
    input:
        plan="results/cases/{case}/vci/plan.json",
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        sections="results/cases/{case}/anatomy/sections.csv",
        anatomy="results/cases/{case}/anatomy/anatomy.json",
        code=code("anatomy", "anatomy.planning.plan_picture"),
    output:
        "results/cases/{case}/vci/plan.png",
    log:
        "results/cases/{case}/logs/plan_picture.log",
    benchmark:
        "results/cases/{case}/benchmarks/plan_picture.tsv"
    params:
        anatomy=anatomy_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy plan-picture {input.plan} --anatomy {params.anatomy} --out {output}"


rule scene:
    message:
        "{wildcards.case}: scene for the virtual deployment"
    input:
        # The reference reads the plan alone, so that new settings of the engine (wall, numerics) do not re-run it.
        plan="results/cases/{case}/vci/plan.json",
        settings="results/cases/{case}/settings/deployment.json",
        code=command_code("workflow", "run_scene"),
    output:
        "results/cases/{case}/vci/scene.json",
    log:
        "results/cases/{case}/logs/scene.log",
    benchmark:
        "results/cases/{case}/benchmarks/scene.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m workflow scene {input.plan} --settings {input.settings} --out {output}"


rule deploy:
    message:
        "{wildcards.case}: virtual deployment"
    input:
        scene="results/cases/{case}/vci/scene.json",
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        centreline="results/cases/{case}/anatomy/centreline.vtp",
        binary=VCI,
    output:
        lumen="results/cases/{case}/vci/lumen.vtp",
        stl="results/cases/{case}/vci/lumen.stl",
        deployment="results/cases/{case}/vci/deployment.json",
        devices=directory("results/cases/{case}/vci/devices"),
        frames=directory("results/cases/{case}/vci/frames"),
    log:
        "results/cases/{case}/logs/vci/deploy.log",
    benchmark:
        "results/cases/{case}/benchmarks/vci/deploy.tsv"
    params:
        out=output_folder,
        frames=frames_option,
    shell:
        "workflow/run.sh {log} {input.binary} deploy {input.scene} --out {params.out} {params.frames}"


rule radius_correct:
    message:
        "{wildcards.case}: radius-correction baseline"
    input:
        scene="results/cases/{case}/vci/plan.json",
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        centreline="results/cases/{case}/anatomy/centreline.vtp",
        binary=VCI,
    output:
        lumen="results/cases/{case}/rc/lumen.vtp",
        stl="results/cases/{case}/rc/lumen.stl",
        deployment="results/cases/{case}/rc/deployment.json",
    log:
        "results/cases/{case}/logs/rc/radius_correct.log",
    benchmark:
        "results/cases/{case}/benchmarks/rc/radius_correct.tsv"
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} {input.binary} radius-correct {input.scene} --out {params.out}"


rule reference:
    message:
        "{wildcards.case}: reference lumen by finite elements"
    input:
        scene="results/cases/{case}/vci/plan.json",
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        truth="results/cases/{case}/source/truth.json",
        settings="results/cases/{case}/settings/reference.json",
        code=code("data_synthetic", "data_synthetic.reference.run"),
    output:
        lumen="results/cases/{case}/reference/lumen.vtp",
        stl="results/cases/{case}/reference/lumen.stl",
        reference="results/cases/{case}/reference/reference.json",
    log:
        "results/cases/{case}/logs/reference/finite_elements.log",
    benchmark:
        "results/cases/{case}/benchmarks/reference/finite_elements.tsv"
    resources:
        **fixed_resources(1500, 10),
    params:
        anatomy=anatomy_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m data_synthetic reference --scene {input.scene} --anatomy {params.anatomy}"
        " --truth {input.truth} --settings {input.settings} --out {params.out}"


# Radius correction by the stents alone: no further balloon widens the lumen. Lyu et al. 2025 correct the radius in this
# way in their example (figure 8).
rule stent_alone:
    message:
        "{wildcards.case}: the plan's stents alone"
    input:
        plan="results/cases/{case}/vci/plan.json",
        code=command_code("workflow", "run_stent_alone"),
    output:
        "results/cases/{case}/rc_stent/plan.json",
    log:
        "results/cases/{case}/logs/rc_stent/plan.log",
    benchmark:
        "results/cases/{case}/benchmarks/rc_stent/plan.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m workflow stent-alone {input.plan} --out {output}"


use rule radius_correct as stent_alone_radius_correct with:
    message:
        "{wildcards.case}: radius correction by the stents alone"
    input:
        scene="results/cases/{case}/rc_stent/plan.json",
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        centreline="results/cases/{case}/anatomy/centreline.vtp",
        binary=VCI,
    output:
        lumen="results/cases/{case}/rc_stent/lumen.vtp",
        stl="results/cases/{case}/rc_stent/lumen.stl",
        deployment="results/cases/{case}/rc_stent/deployment.json",
    log:
        "results/cases/{case}/logs/rc_stent/radius_correct.log",
    benchmark:
        "results/cases/{case}/benchmarks/rc_stent/radius_correct.tsv"


# These rules predict the same procedure from the lumen found in the CT before it. A clinic has no other lumen.
rule carry_plan:
    message:
        "{wildcards.case}: the plan in the lumen of the CT before the procedure"
    input:
        plan="results/cases/{case}/vci/plan.json",
        before="results/cases/{case}/anatomy/sections.csv",
        after="results/cases/{case}/ct_pre/anatomy/sections.csv",
        code=code("anatomy", "anatomy.planning.carry_plan"),
    output:
        "results/cases/{case}/ct_vci/plan.json",
    log:
        "results/cases/{case}/logs/ct_vci/carry_plan.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct_vci/carry_plan.tsv"
    params:
        before=lambda wildcards, input: os.path.dirname(input.before),
        after=lambda wildcards, input: os.path.dirname(input.after),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy carry-plan {input.plan} --from {params.before}"
        " --to {params.after} --out {output}"


use rule scene as ct_scene with:
    message:
        "{wildcards.case}: scene in the lumen of the CT before the procedure"
    input:
        plan="results/cases/{case}/ct_vci/plan.json",
        settings="results/cases/{case}/settings/deployment.json",
        code=command_code("workflow", "run_scene"),
    output:
        "results/cases/{case}/ct_vci/scene.json",
    log:
        "results/cases/{case}/logs/ct_vci/scene.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct_vci/scene.tsv"


use rule deploy as ct_deploy with:
    message:
        "{wildcards.case}: virtual deployment in the lumen of the CT"
    input:
        scene="results/cases/{case}/ct_vci/scene.json",
        lumen="results/cases/{case}/ct_pre/anatomy/lumen.vtp",
        centreline="results/cases/{case}/ct_pre/anatomy/centreline.vtp",
        binary=VCI,
    output:
        lumen="results/cases/{case}/ct_vci/lumen.vtp",
        stl="results/cases/{case}/ct_vci/lumen.stl",
        deployment="results/cases/{case}/ct_vci/deployment.json",
        devices=directory("results/cases/{case}/ct_vci/devices"),
    log:
        "results/cases/{case}/logs/ct_vci/deploy.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct_vci/deploy.tsv"


use rule radius_correct as ct_radius_correct with:
    message:
        "{wildcards.case}: radius correction in the lumen of the CT"
    input:
        scene="results/cases/{case}/ct_vci/plan.json",
        lumen="results/cases/{case}/ct_pre/anatomy/lumen.vtp",
        centreline="results/cases/{case}/ct_pre/anatomy/centreline.vtp",
        binary=VCI,
    output:
        lumen="results/cases/{case}/ct_rc/lumen.vtp",
        stl="results/cases/{case}/ct_rc/lumen.stl",
        deployment="results/cases/{case}/ct_rc/deployment.json",
    log:
        "results/cases/{case}/logs/ct_rc/radius_correct.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct_rc/radius_correct.tsv"

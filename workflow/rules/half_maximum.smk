# Makes the comparison in CT again, with lumens segmented at half maximum, the simplest way to read the image.
# Area and curvature are measured as for any state. FFR is computed by the calibrated 1D network, which takes seconds.
ARM = "results/cases/{case}/half_maximum"
ARM_LOGS = "results/cases/{case}/logs/half_maximum"
ARM_BENCHMARKS = "results/cases/{case}/benchmarks/half_maximum"


rule half_maximum_settings:
    message:
        "{wildcards.case}: settings of the segmentation at half maximum"
    output:
        f"{ARM}/settings.json",
    log:
        f"{ARM_LOGS}/settings.log",
    params:
        text=HALF_MAXIMUM.ct_settings,
    shell:
        "printf '%s\\n' {params.text:q} >{output} 2>{log}"


use rule ct_segment as half_maximum_segment with:
    message:
        "{wildcards.case}: lumen in the CT of {wildcards.state}, at half maximum"
    input:
        image="results/cases/{case}/ct/{state}/ct.nii.gz",
        ends=INPUTS.end_points_file,
        settings=f"{ARM}/settings.json",
        code=command_code("anatomy", "_ct"),
    output:
        lumen=f"{ARM}/ct/{{state}}/lumen.vtp",
        segmentation=f"{ARM}/ct/{{state}}/segmentation.json",
    log:
        f"{ARM_LOGS}/{{state}}_segment.log",
    benchmark:
        f"{ARM_BENCHMARKS}/{{state}}_segment.tsv"


use rule state_anatomy as half_maximum_anatomy with:
    message:
        "{wildcards.case}: lumen, centreline, sections of {wildcards.state}, at half maximum"
    input:
        lumen=HALF_MAXIMUM.lumen_file,
        like=INPUTS.end_names_file,
        binary=LUMEN,
    output:
        lumen=f"{ARM}/{{state}}/anatomy/lumen.vtp",
        centreline=f"{ARM}/{{state}}/anatomy/centreline.vtp",
        sections=f"{ARM}/{{state}}/anatomy/sections.csv",
        anatomy=f"{ARM}/{{state}}/anatomy/anatomy.json",
    wildcard_constraints:
        state="|".join(ARM_STATES),
    log:
        f"{ARM_LOGS}/{{state}}_anatomy.log",
    benchmark:
        f"{ARM_BENCHMARKS}/{{state}}_anatomy.tsv"


use rule carry_plan as half_maximum_carry_plan with:
    message:
        "{wildcards.case}: the plan in the lumen at half maximum"
    input:
        plan="results/cases/{case}/vci/plan.json",
        before="results/cases/{case}/anatomy/sections.csv",
        after=f"{ARM}/ct_pre/anatomy/sections.csv",
        code=code("anatomy", "anatomy.planning.carry_plan"),
    output:
        f"{ARM}/ct_vci/plan.json",
    log:
        f"{ARM_LOGS}/carry_plan.log",
    benchmark:
        f"{ARM_BENCHMARKS}/carry_plan.tsv"


use rule scene as half_maximum_scene with:
    message:
        "{wildcards.case}: scene in the lumen at half maximum"
    input:
        plan=f"{ARM}/ct_vci/plan.json",
        settings="results/cases/{case}/settings/deployment.json",
        code=command_code("workflow", "run_scene"),
    output:
        f"{ARM}/ct_vci/scene.json",
    log:
        f"{ARM_LOGS}/scene.log",
    benchmark:
        f"{ARM_BENCHMARKS}/scene.tsv"


use rule deploy as half_maximum_deploy with:
    message:
        "{wildcards.case}: virtual deployment in the lumen at half maximum"
    input:
        scene=f"{ARM}/ct_vci/scene.json",
        lumen=f"{ARM}/ct_pre/anatomy/lumen.vtp",
        centreline=f"{ARM}/ct_pre/anatomy/centreline.vtp",
        binary=VCI,
    output:
        lumen=f"{ARM}/ct_vci/lumen.vtp",
        stl=f"{ARM}/ct_vci/lumen.stl",
        deployment=f"{ARM}/ct_vci/deployment.json",
        devices=directory(f"{ARM}/ct_vci/devices"),
    log:
        f"{ARM_LOGS}/deploy.log",
    benchmark:
        f"{ARM_BENCHMARKS}/deploy.tsv"


use rule radius_correct as half_maximum_radius_correct with:
    message:
        "{wildcards.case}: radius correction in the lumen at half maximum"
    input:
        scene=f"{ARM}/ct_vci/plan.json",
        lumen=f"{ARM}/ct_pre/anatomy/lumen.vtp",
        centreline=f"{ARM}/ct_pre/anatomy/centreline.vtp",
        binary=VCI,
    output:
        lumen=f"{ARM}/ct_rc/lumen.vtp",
        stl=f"{ARM}/ct_rc/lumen.stl",
        deployment=f"{ARM}/ct_rc/deployment.json",
    log:
        f"{ARM_LOGS}/radius_correct.log",
    benchmark:
        f"{ARM_BENCHMARKS}/radius_correct.tsv"


rule half_maximum_ffr:
    message:
        "{wildcards.case}: FFR of the lumens at half maximum, by the calibrated network"
    input:
        VARIED,
        expand(f"{ARM}/{{state}}/anatomy/{{name}}", state=ARM_STATES, name=["sections.csv", "anatomy.json"], allow_missing=True),
        scene="results/cases/{case}/vci/scene.json",
        code=command_code("whatif", "run_lumens"),
    output:
        f"{ARM}/ffr.json",
    log:
        f"{ARM_LOGS}/ffr.log",
    benchmark:
        f"{ARM_BENCHMARKS}/ffr.tsv"
    params:
        case_dir=case_folder,
        states=lambda wildcards: " ".join(INPUTS.states_with_flow(wildcards.case)),
        lumens=" ".join(f"half_maximum/{state}" for state in ARM_STATES),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m whatif lumens {params.lumens} --case-dir {params.case_dir}"
        " --states {params.states} --out {output}"


rule half_maximum_metrics:
    message:
        "{wildcards.case}: area, curvature and FFR of the lumens at half maximum"
    input:
        HALF_MAXIMUM.compared_files,
        f"{ARM}/ffr.json",
        expand(f"{ARM}/ct/{{state}}/segmentation.json", state=CT_IMAGED_STATES, allow_missing=True),
        expand(
            f"{ARM}/{{state}}/anatomy/{{name}}",
            state=ARM_STATES,
            name=["centreline.vtp", "sections.csv", "anatomy.json"],
            allow_missing=True,
        ),
        scene="results/cases/{case}/vci/scene.json",
        deployment="results/cases/{case}/vci/deployment.json",
        deployed="results/cases/{case}/vci/lumen.vtp",
        devices="results/cases/{case}/vci/devices",
        boundary="results/cases/{case}/flow/boundary.json",
        code=command_code("reports", "run_metrics"),
    output:
        f"{ARM}/metrics.json",
    log:
        f"{ARM_LOGS}/metrics.log",
    benchmark:
        f"{ARM_BENCHMARKS}/metrics.tsv"
    params:
        margin=INPUTS.setting("metrics", "margin_mm"),
        states=lambda wildcards: " ".join(INPUTS.states(wildcards.case)),
        case_dir=case_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports metrics --case {wildcards.case} --case-dir {params.case_dir}"
        " --margin-mm {params.margin} --states {params.states} --segmentation half_maximum --out {output}"


use rule agreement as half_maximum_agreement with:
    message:
        "agreement of the lumens at half maximum"
    input:
        metrics=expand(f"{ARM}/metrics.json", case=HALF_MAXIMUM_CASES),
        code=code("reports", "reports.study.agreement") + ["reports/study/published.json"],
    output:
        "results/study/half_maximum.csv",
    log:
        "results/study/logs/half_maximum.log",
    benchmark:
        "results/study/benchmarks/half_maximum.tsv"

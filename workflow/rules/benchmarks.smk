# Benchmarks of each part: speed against error, and hard cases. They take minutes to hours and are no part of the study.
# The report shows those that were run. They measure time, so they run one at a time: `threads` takes every core of this
# machine, and a cluster gives each benchmark a whole node (WHOLE_NODE).
ALL_CORES = workflow.global_resources["_cores"] or 1
BENCHMARKS = {
    "deployment_speed": "benchmark.csv",
    "deployment_baseline": "baseline.csv",
    "deployment_hard_cases": "hard_cases.csv",
    "deployment_sensitivity": "sensitivity.csv",
    "deployment_against_published": "published.csv",
    "flow_hard_cases": "hard_cases.csv",
    "anatomy_speed": "benchmark.csv",
    "anatomy_campaign": "campaign.csv",
    "reference_against_solid": "benchmark.csv",
    "reference_straightening": "benchmark.csv",
    "reference_sensitivity": "sensitivity.csv",
}


rule benchmarks:
    input:
        [f"results/benchmarks/{name}/{table}" for name, table in BENCHMARKS.items()],


rule deployment_speed:
    message:
        "benchmark: speed against error of the deployment"
    input:
        programs=[VCI, LUMEN],
        code=module_code("vci.benchmarks.benchmark"),
        bifurcation="config/cases/culotte_bench.yaml",
    output:
        "results/benchmarks/deployment_speed/benchmark.csv",
        "results/benchmarks/deployment_speed/medians.csv",
        "results/benchmarks/deployment_speed/benchmark.png",
    log:
        "results/benchmarks/logs/deployment_speed.log",
    benchmark:
        "results/benchmarks/logs/deployment_speed.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.benchmark --build {params.build} --out {params.out}"


rule deployment_baseline:
    message:
        "benchmark: the deployment beside the textbook scheme"
    input:
        programs=[VCI, LUMEN],
        code=module_code("vci.benchmarks.baseline"),
    output:
        "results/benchmarks/deployment_baseline/baseline.csv",
        "results/benchmarks/deployment_baseline/levels.csv",
        "results/benchmarks/deployment_baseline/baseline.png",
    log:
        "results/benchmarks/logs/deployment_baseline.log",
    benchmark:
        "results/benchmarks/logs/deployment_baseline.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.baseline --build {params.build} --out {params.out}"


rule deployment_baseline_patients:
    message:
        "benchmark: the cohort's procedures by the textbook scheme, up to 400 CPU s a run"
    input:
        programs=[VCI],
        code=module_code("vci.benchmarks.baseline"),
        scenes=expand("results/cases/{case}/vci/scene.json", case=CASES),
        anatomies=expand("results/cases/{case}/anatomy/anatomy.json", case=CASES),
    output:
        "results/benchmarks/deployment_baseline_patients/patients.csv",
    log:
        "results/benchmarks/logs/deployment_baseline_patients.log",
    benchmark:
        "results/benchmarks/logs/deployment_baseline_patients.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        cases=expand("results/cases/{case}", case=CASES),
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.baseline {params.cases} --build {params.build}"
        " --out {params.out} --budget 400"


rule deployment_hard_cases:
    message:
        "benchmark: hard cases of the deployment"
    input:
        programs=[VCI, LUMEN],
        code=module_code("vci.benchmarks.hard_cases"),
        bifurcation="config/cases/culotte_bench.yaml",
    output:
        "results/benchmarks/deployment_hard_cases/hard_cases.csv",
        "results/benchmarks/deployment_hard_cases/first_steps.csv",
    log:
        "results/benchmarks/logs/deployment_hard_cases.log",
    benchmark:
        "results/benchmarks/logs/deployment_hard_cases.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.hard_cases --build {params.build} --out {params.out} "
        "--first-steps 0.27 0.29 0.30 0.31 0.34"


rule deployment_sensitivity:
    message:
        "benchmark: what contact distance and margin of the region are worth"
    input:
        programs=[VCI],
        code=module_code("vci.benchmarks.sensitivity"),
    output:
        "results/benchmarks/deployment_sensitivity/sensitivity.csv",
    log:
        "results/benchmarks/logs/deployment_sensitivity.log",
    benchmark:
        "results/benchmarks/logs/deployment_sensitivity.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.sensitivity --build {params.build} --out {params.out}"


rule deployment_coarse_walls:
    message:
        "benchmark: the cohort's deployments on longer edges"
    input:
        programs=[VCI, LUMEN],
        code=module_code("vci.benchmarks.coarse_walls"),
        scenes=expand("results/cases/{case}/vci/scene.json", case=CASES),
        anatomies=expand("results/cases/{case}/anatomy/anatomy.json", case=CASES),
    output:
        "results/benchmarks/deployment_coarse_walls/coarse_walls.csv",
        "results/benchmarks/deployment_coarse_walls/summary.csv",
    log:
        "results/benchmarks/logs/deployment_coarse_walls.log",
    benchmark:
        "results/benchmarks/logs/deployment_coarse_walls.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        cases=expand("results/cases/{case}", case=CASES),
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.coarse_walls {params.cases} --build {params.build}"
        " --out {params.out}"


rule deployment_calcium_strength:
    message:
        "benchmark: a stent's expansion in calcium of several strengths"
    input:
        programs=[VCI, LUMEN],
        code=module_code("vci.benchmarks.calcium_strength"),
        vessels=code("data_synthetic", "data_synthetic.generate"),
        plan=code("anatomy", "anatomy.planning.plan"),
        devices=DEVICES,
    output:
        "results/benchmarks/deployment_calcium_strength/strength.csv",
    log:
        "results/benchmarks/logs/deployment_calcium_strength.log",
    benchmark:
        "results/benchmarks/logs/deployment_calcium_strength.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.calcium_strength --build {params.build}"
        " --out {params.out}"


rule deployment_against_published:
    message:
        "benchmark: engine and reference beside benches, cadavers and patients"
    input:
        programs=[VCI, LUMEN],
        code=module_code("vci.benchmarks.published"),
        vessels=code("data_synthetic", "data_synthetic.draw", "data_synthetic.generate"),
        truth=code("data_synthetic", "data_synthetic.reference.run"),
        plan=code("anatomy", "anatomy.planning.plan"),
        devices=DEVICES,
    output:
        "results/benchmarks/deployment_against_published/published.csv",
    log:
        "results/benchmarks/logs/deployment_against_published.log",
    benchmark:
        "results/benchmarks/logs/deployment_against_published.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m vci.benchmarks.published --build {params.build} --out {params.out}"


rule anatomy_speed:
    message:
        "benchmark: seconds of the anatomy against input size"
    input:
        program=LUMEN,
        script="tests/verification/anatomy/benchmark.py",
        shared="tests/support/places.py",
    output:
        "results/benchmarks/anatomy_speed/benchmark.csv",
    log:
        "results/benchmarks/logs/anatomy_speed.log",
    benchmark:
        "results/benchmarks/logs/anatomy_speed.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {output}"


rule anatomy_campaign:
    message:
        "benchmark: drawn patients, reconstructed in many ways, through the anatomy"
    input:
        programs=[LUMEN, VCI],
        script="tests/verification/anatomy/campaign.py",
        shared=[
            f"tests/verification/anatomy/{name}.py"
            for name in (
                *("campaign_steps", "campaign_styles", "campaign_truth"),
                *("drawn_patient", "lofts", "masks", "surfaces"),
            )
        ]
        + ["tests/support/places.py"],
        settings=["config/study.yaml", "config/cases/real_artery.yaml"],
        code=code("data_synthetic", "data_synthetic.draw", "data_synthetic.generate"),
        picture=code("anatomy", "anatomy.ends_picture"),
    output:
        "results/benchmarks/anatomy_campaign/campaign.csv",
    log:
        "results/benchmarks/logs/anatomy_campaign.log",
    benchmark:
        "results/benchmarks/logs/anatomy_campaign.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        build=programs_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --build {params.build} --patients 200 --out {params.out}"


rule reference_against_solid:
    message:
        "benchmark: the reference's slices against a solid in three dimensions"
    input:
        program=LUMEN,
        code=code("data_synthetic", "data_synthetic.generate", "data_synthetic.reference.checks.against_solid"),
        script="tests/verification/data_synthetic/solid_benchmark.py",
        shared=["tests/verification/data_synthetic/benchmark_case.py", "tests/support/places.py"],
        plan=code("anatomy", "anatomy.planning.plan"),
        devices=DEVICES,
        cases=[f"config/cases/{name}.yaml" for name in ("quick_focal", "long_plaque_bench")],
    output:
        "results/benchmarks/reference_against_solid/benchmark.csv",
    log:
        "results/benchmarks/logs/reference_against_solid.log",
    benchmark:
        "results/benchmarks/logs/reference_against_solid.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --cases {input.cases} --out {params.out}"


rule reference_straightening:
    message:
        "benchmark: straightening by the beams of the reference against a solid in three dimensions"
    input:
        program=LUMEN,
        code=code("data_synthetic", "data_synthetic.generate", "data_synthetic.reference.checks.straightening_in_solid"),
        script="tests/verification/data_synthetic/straightening_benchmark.py",
        shared=["tests/verification/data_synthetic/benchmark_case.py", "tests/support/places.py"],
        plan=code("anatomy", "anatomy.planning.plan"),
        devices=DEVICES,
        cases=[f"config/cases/{name}.yaml" for name in ("quick_focal", "contrast_bend", "lcx02")],
    output:
        "results/benchmarks/reference_straightening/benchmark.csv",
    log:
        "results/benchmarks/logs/reference_straightening.log",
    benchmark:
        "results/benchmarks/logs/reference_straightening.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --cases {input.cases} --out {params.out}"


rule reference_sensitivity:
    message:
        "benchmark: how much the reference depends on its constants"
    input:
        program=LUMEN,
        code=code("data_synthetic", "data_synthetic.generate", "data_synthetic.reference.checks.sensitivity"),
        script="tests/verification/data_synthetic/sensitivity_benchmark.py",
        shared=["tests/verification/data_synthetic/benchmark_case.py", "tests/support/places.py"],
        plan=code("anatomy", "anatomy.planning.plan"),
        devices=DEVICES,
        case="config/cases/lad01.yaml",
    output:
        "results/benchmarks/reference_sensitivity/sensitivity.csv",
    log:
        "results/benchmarks/logs/reference_sensitivity.log",
    benchmark:
        "results/benchmarks/logs/reference_sensitivity.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --case {input.case} --out {params.out}"


rule reference_against_calculix:
    message:
        "benchmark: the reference's slices against CalculiX (package calculix-ccx), by its own name only"
    input:
        program=LUMEN,
        code=code(
            "data_synthetic",
            "data_synthetic.generate",
            "data_synthetic.reference.checks.against_calculix",
            "data_synthetic.reference.checks.calculix_case",
        ),
        script="tests/verification/data_synthetic/calculix_benchmark.py",
        shared=["tests/verification/data_synthetic/benchmark_case.py", "tests/support/places.py"],
        plan=code("anatomy", "anatomy.planning.plan"),
        devices=DEVICES,
        case="config/cases/lad01.yaml",
    output:
        "results/benchmarks/reference_against_calculix/ring.csv",
        "results/benchmarks/reference_against_calculix/case.csv",
    log:
        "results/benchmarks/logs/reference_against_calculix.log",
    benchmark:
        "results/benchmarks/logs/reference_against_calculix.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --case {input.case} --out {params.out}"

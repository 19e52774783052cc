# Benchmarks of the flow. benchmarks.smk says how benchmarks run, and which of them `snakemake benchmarks` runs.
TREE_STATES = ["quick_branch/flow/pre", "quick_branch/flow/vci", "lcx02/flow/pre"]  # lcx02: one of the nine patients
SOLVED_TREES = [f"results/cases/{state}" for state in TREE_STATES]
STATES_ON_FINER_MESH = expand("results/cases/{case}/flow/{state}", case=CASES, state=["pre", "vci"])
STATES_OF_STARTS = expand("results/cases/{case}/flow/{state}", case=CASES, state=["vci", "reference"])
STRAIGHT_TUBES = (*(f"single_{percent}" for percent in (62, 75, 80, 85, 90)), "tandem_60", "throat_re_1500")


rule flow_hard_cases:
    message:
        "benchmark: hard cases of the flow"
    input:
        code=flow_benchmark_code("hard_cases"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/hard_cases.py",
        boundary="results/cases/quick_focal/flow/boundary.json",
        deployed=multiext("results/cases/quick_focal/vci/anatomy/", *STATE_FILES),
    output:
        "results/benchmarks/flow_hard_cases/hard_cases.csv",
    log:
        "results/benchmarks/logs/flow_hard_cases.log",
    benchmark:
        "results/benchmarks/logs/flow_hard_cases.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} all"
        " --state results/cases/quick_focal/vci"


rule flow_growth:
    message:
        "benchmark: cost and error of the flow solver by mesh, by its own name only"
    input:
        code=flow_benchmark_code("growth"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/growth.py",
    output:
        "results/benchmarks/flow_growth/growth.csv",
        "results/benchmarks/flow_growth/exponents.csv",
    log:
        "results/benchmarks/logs/flow_growth.log",
    benchmark:
        "results/benchmarks/logs/flow_growth.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} 4:3 5:4 6:4"


rule flow_tolerance:
    message:
        "benchmark: FFR to a tolerance, its cost and error, by its own name only"
    input:
        code=flow_benchmark_code("tolerance"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/tolerance.py",
    output:
        "results/benchmarks/flow_tolerance/tolerance.csv",
    log:
        "results/benchmarks/logs/flow_tolerance.log",
    benchmark:
        "results/benchmarks/logs/flow_tolerance.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
        cases=" ".join(f"{case}:{tolerance}" for case in STRAIGHT_TUBES for tolerance in (0.005, 0.002)),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} {params.cases}"


rule flow_wall_shear:
    message:
        "benchmark: wall shear stress by boundary layers, by its own name only"
    input:
        code=flow_benchmark_code("wall_shear"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/wall_shear.py",
    output:
        "results/benchmarks/flow_wall_shear/wall_shear.csv",
    log:
        "results/benchmarks/logs/flow_wall_shear.log",
    benchmark:
        "results/benchmarks/logs/flow_wall_shear.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} 3:1 3:2 3:3 4:1 4:2"


rule flow_against_openfoam:
    message:
        "benchmark: the flow beside OpenFOAM's simpleFoam (package openfoam), by its own name only"
    input:
        code=flow_benchmark_code("against_openfoam"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/against_openfoam.py",
    output:
        "results/benchmarks/flow_against_openfoam/benchmark.csv",
        "results/benchmarks/flow_against_openfoam/benchmark.png",
    log:
        "results/benchmarks/logs/flow_against_openfoam.log",
    benchmark:
        "results/benchmarks/logs/flow_against_openfoam.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out}"


rule flow_tree_against_openfoam:
    message:
        "benchmark: trees before and after PCI beside OpenFOAM's simpleFoam (package openfoam), by its own name only"
    input:
        code=flow_benchmark_code("against_openfoam_tree"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/against_openfoam_tree.py",
        boundaries=[f"results/cases/{case}/flow/boundary.json" for case in ("quick_branch", "lcx02")],
        meshes=expand("{state}/{file}", state=SOLVED_TREES, file=["mesh_coarse.msh", "mesh.msh", "mesh.json"]),
        answers=expand("{state}/ffr.json", state=SOLVED_TREES),
    output:
        "results/benchmarks/flow_tree_against_openfoam/tree.csv",
    log:
        "results/benchmarks/logs/flow_tree_against_openfoam.log",
    benchmark:
        "results/benchmarks/logs/flow_tree_against_openfoam.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
        states=SOLVED_TREES,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} {params.states}"


rule flow_finer_mesh:
    message:
        "benchmark: estimates of the answers beside the next finer mesh, by its own name only"
    input:
        code=flow_benchmark_code("finer_mesh"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/finer_mesh.py",
        boundaries=expand("results/cases/{case}/flow/boundary.json", case=CASES),
        meshes=expand("{state}/{file}", state=STATES_ON_FINER_MESH, file=["mesh.msh", "mesh.json", *COARSE_MESHES]),
        answers=expand("{state}/{file}", state=STATES_ON_FINER_MESH, file=["ffr.json", "solution.vtu"]),
    output:
        "results/benchmarks/flow_finer_mesh/finer_mesh.csv",
    log:
        "results/benchmarks/logs/flow_finer_mesh.log",
    benchmark:
        "results/benchmarks/logs/flow_finer_mesh.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
        states=STATES_ON_FINER_MESH,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} {params.states}"


rule flow_starts:
    message:
        "benchmark: what a first guess of the flow saves, by its own name only"
    input:
        code=flow_benchmark_code("starts"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/starts.py",
        boundaries=expand("results/cases/{case}/flow/boundary.json", case=CASES),
        meshes=expand("{state}/{file}", state=STATES_OF_STARTS, file=["mesh.msh", "mesh.json", *COARSE_MESHES]),
        starts=expand("results/cases/{case}/flow/vci/{file}", case=CASES, file=["ffr.json", "solution.vtu"]),
    output:
        "results/benchmarks/flow_starts/starts.csv",
    log:
        "results/benchmarks/logs/flow_starts.log",
    benchmark:
        "results/benchmarks/logs/flow_starts.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
        states=STATES_OF_STARTS,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} {params.states}"


rule flow_speed_error:
    message:
        "benchmark: FFR's error against CPU seconds over the mesh sequence, beside OpenFOAM, by its own name only"
    input:
        code=flow_benchmark_code("speed_error"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/speed_error.py",
        tube="results/benchmarks/flow_against_openfoam/benchmark.csv",
        tree="results/benchmarks/flow_tree_against_openfoam/tree.csv",
        boundary="results/cases/quick_branch/flow/boundary.json",
        lumens=["results/cases/quick_branch/anatomy/lumen.vtp", "results/cases/quick_branch/vci/anatomy/lumen.vtp"],
    output:
        "results/benchmarks/flow_speed_error/speed_error.csv",
        "results/benchmarks/flow_speed_error/speed_error.png",
    log:
        "results/benchmarks/logs/flow_speed_error.log",
    benchmark:
        "results/benchmarks/logs/flow_speed_error.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
        states="results/cases/quick_branch/pre results/cases/quick_branch/vci",
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out} {params.states}"
        " --openfoam-tube {input.tube} --openfoam-tree {input.tree}"


rule flow_fda_jet:
    message:
        "benchmark: the jet of the FDA's nozzle by laboratories, axisymmetric solution and default settings, by its own name only"
    input:
        code=flow_benchmark_code("fda_jet"),
        factors=FLOW_FACTORS,
        script="tests/verification/flow/fda_jet.py",
    output:
        "results/benchmarks/flow_fda_jet/jet.csv",
    log:
        "results/benchmarks/logs/flow_fda_jet.log",
    benchmark:
        "results/benchmarks/logs/flow_fda_jet.tsv"
    threads: ALL_CORES
    resources:
        **WHOLE_NODE,
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 {input.script} --out {params.out}"

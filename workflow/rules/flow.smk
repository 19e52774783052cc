# FFR of every state. All states of a patient have the same boundary values.
# Flows take the longest. Priority 1 starts them early, so that short steps can fill idle cores while the last flows run.

COARSE_FILES = [f"results/cases/{{case}}/flow/{{state}}/{name}" for name in COARSE_MESHES]


rule boundary:
    message:
        "{wildcards.case}: outlet resistances and probes"
    input:
        case=ancient(CASE_FILE),
        centreline="results/cases/{case}/anatomy/centreline.vtp",
        anatomy="results/cases/{case}/anatomy/anatomy.json",
        sections="results/cases/{case}/anatomy/sections.csv",
        settings="results/cases/{case}/settings/flow.json",
        code=command_code("flow", "boundary_command"),
    output:
        "results/cases/{case}/flow/boundary.json",
    log:
        "results/cases/{case}/logs/boundary.log",
    benchmark:
        "results/cases/{case}/benchmarks/boundary.tsv"
    params:
        patient=INPUTS.section("patient"),
        measured=INPUTS.section("measured"),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m flow boundary --case {input.case} --anatomy {input.anatomy}"
        " --centreline {input.centreline} --settings {input.settings} --out {output}"


rule flow_mesh:
    message:
        "{wildcards.case}: volume mesh of {wildcards.state}"
    input:
        unpack(INPUTS.anatomy_files),
        settings="results/cases/{case}/settings/flow.json",
        code=command_code("flow", "mesh_command"),
    output:
        mesh="results/cases/{case}/flow/{state}/mesh.msh",
        coarse=COARSE_FILES,
        summary="results/cases/{case}/flow/{state}/mesh.json",
    priority: 1
    log:
        "results/cases/{case}/logs/{state}/flow_mesh.log",
    benchmark:
        "results/cases/{case}/benchmarks/{state}/flow_mesh.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m flow mesh {input.lumen} --centreline {input.centreline}"
        " --settings {input.settings} --out {output.mesh} --coarse {output.coarse} --json {output.summary}"


rule flow_solve:
    message:
        "{wildcards.case}: flow of {wildcards.state}"
    input:
        unpack(INPUTS.anatomy_files),
        unpack(INPUTS.start_files),
        mesh="results/cases/{case}/flow/{state}/mesh.msh",
        coarse=COARSE_FILES,
        summary="results/cases/{case}/flow/{state}/mesh.json",
        boundary="results/cases/{case}/flow/boundary.json",
        settings="results/cases/{case}/settings/flow.json",
        code=command_code("flow", "solve_command"),
        factors=FLOW_FACTORS,
    output:
        solution="results/cases/{case}/flow/{state}/solution.vtu",
        ffr="results/cases/{case}/flow/{state}/ffr.json",
        pullback="results/cases/{case}/flow/{state}/pullback.csv",
    priority: 1
    log:
        "results/cases/{case}/logs/{state}/flow_solve.log",
    benchmark:
        "results/cases/{case}/benchmarks/{state}/flow_solve.tsv"
    resources:
        **resources_by_size((1000, 600), (5, 2), "mesh"),
    params:
        out=output_folder,
        start=start_option,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m flow solve {input.mesh} --coarse {input.coarse}"
        " --boundary {input.boundary} --centreline {input.centreline} --anatomy {input.anatomy}"
        " --sections {input.sections} --lumen {input.lumen} --mesh-report {input.summary} --settings {input.settings}"
        " {params.start} --out {params.out}"


rule flow_audit:
    message:
        "{wildcards.case}: march in time of {wildcards.state}, to audit its steady flow"
    input:
        unpack(INPUTS.anatomy_files),
        mesh="results/cases/{case}/flow/{state}/mesh.msh",
        coarse=COARSE_FILES,
        summary="results/cases/{case}/flow/{state}/mesh.json",
        boundary="results/cases/{case}/flow/boundary.json",
        settings="results/cases/{case}/settings/flow.json",
        code=command_code("flow", "audit_command"),
        factors=FLOW_FACTORS,
    output:
        audit="results/cases/{case}/flow/{state}/audit.json",
        series="results/cases/{case}/flow/{state}/audit.csv",
    log:
        "results/cases/{case}/logs/{state}/flow_audit.log",
    benchmark:
        "results/cases/{case}/benchmarks/{state}/flow_audit.tsv"
    resources:
        **resources_by_size((1000, 600), (30, 20), "mesh"),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m flow audit {input.mesh} --coarse {input.coarse}"
        " --boundary {input.boundary} --centreline {input.centreline} --anatomy {input.anatomy}"
        " --sections {input.sections} --lumen {input.lumen} --mesh-report {input.summary} --settings {input.settings}"
        " --out {output.audit}"

# Tables, figures and pages that compare the states of a case, and the cases of the study.
CASE_FIGURES = ["lumen", "pullback", "stations", "area", "curvature"]
STUDY_FIGURES = ["ffr_before_after"] + (["agreement"] if INPUTS.any_truth(CASES) else [])
STUDY_FIGURES += ["differences"] if INPUTS.any_lumen_after(CASES) else []
# The tables that the report shows or hands out.
STUDY_TABLES = ["agreement", "half_maximum", "nearer", "contrast", "differences", "differences_stations", "seconds"]
STUDY_TABLES += ["timings", "cohort", "patients", "inclusion"]
# All steps of all cases have ended once these files are made. The files of the last line are made by their own names only.
MADE_OF_CASES = expand("results/cases/{case}/metrics.json", case=CASES)
MADE_OF_CASES += expand("results/cases/{case}/half_maximum/metrics.json", case=HALF_MAXIMUM_CASES)
MADE_OF_CASES += expand("results/cases/{case}/{picture}.png", case=CASES, picture=["anatomy/tree", "vci/plan"])
MADE_OF_CASES += expand("results/cases/{case}/plans/ranking.csv", case=CASES)
MADE_OF_CASES += expand("results/cases/{case}/sensitivity/flow_intervals.csv", case=CASES)
MADE_OF_CASES += expand("results/figures/{case}_{name}.png", case=CASES, name=[*CASE_FIGURES, "procedure", "sensitivity"])
MADE_OF_CASES += expand("results/figures/{case}_ct.png", case=[case for case in CASES if "ct" in INPUTS.states(case)])
MADE_OF_CASES += solved_plans(CASES) + procedure_sensitivity_tables(CASES)


rule metrics:
    message:
        "{wildcards.case}: area, curvature and FFR over the treated segment"
    input:
        INPUTS.files_of_states(
            "{anatomy}/lumen.vtp",
            "{anatomy}/centreline.vtp",
            "{anatomy}/sections.csv",
            "{anatomy}/anatomy.json",
            "flow/{state}/ffr.json",
            "flow/{state}/pullback.csv",
        ),
        INPUTS.segmentation_files,
        INPUTS.registration_files,
        case=ancient(CASE_FILE),
        scene="results/cases/{case}/vci/scene.json",
        deployment="results/cases/{case}/vci/deployment.json",
        deployed="results/cases/{case}/vci/lumen.vtp",
        devices="results/cases/{case}/vci/devices",
        boundary="results/cases/{case}/flow/boundary.json",
        code=command_code("reports", "run_metrics"),
    output:
        "results/cases/{case}/metrics.json",
    log:
        "results/cases/{case}/logs/metrics.log",
    benchmark:
        "results/cases/{case}/benchmarks/metrics.tsv"
    params:
        patient=INPUTS.section("patient"),
        description=INPUTS.section("description"),
        measured=INPUTS.section("measured"),
        margin=INPUTS.setting("metrics", "margin_mm"),
        states=lambda wildcards: " ".join(INPUTS.states(wildcards.case)),
        case_dir=case_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports metrics --case {wildcards.case} --case-dir {params.case_dir}"
        " --margin-mm {params.margin} --states {params.states} --config {input.case} --out {output}"


rule case_figures:
    message:
        "{wildcards.case}: figures"
    input:
        INPUTS.files_of_states("{anatomy}/lumen.vtp", "flow/{state}/pullback.csv"),
        metrics="results/cases/{case}/metrics.json",
        devices="results/cases/{case}/vci/devices",
        code=code("reports", "reports.figures.case"),
    output:
        expand("results/figures/{{case}}_{name}.{format}", name=CASE_FIGURES, format=["svg", "png"]),
    log:
        "results/cases/{case}/logs/figures.log",
    benchmark:
        "results/cases/{case}/benchmarks/figures.tsv"
    params:
        case_dir=case_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports figures --case-dir {params.case_dir} --out-dir {params.out}"


rule procedure_figure:
    message:
        "{wildcards.case}: the procedure stage by stage"
    input:
        deployment="results/cases/{case}/vci/deployment.json",
        frames="results/cases/{case}/vci/frames",
        code=command_code("reports", "run_procedure"),
    output:
        multiext("results/figures/{case}_procedure.", "svg", "png"),
    log:
        "results/cases/{case}/logs/procedure_figure.log",
    benchmark:
        "results/cases/{case}/benchmarks/procedure_figure.tsv"
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports procedure --case {wildcards.case} --deployment {input.deployment}"
        " --frames {input.frames} --out-dir {params.out}"


rule ct_figure:
    message:
        "{wildcards.case}: slices of its CT"
    input:
        expand("results/cases/{{case}}/ct/{state}/ct.nii.gz", state=CT_IMAGED_STATES),
        expand(
            "results/cases/{{case}}/{anatomy}/{file}.vtp",
            anatomy=["anatomy", "reference/anatomy", "ct_pre/anatomy", "ct/anatomy"],
            file=["lumen", "centreline"],
        ),
        metrics="results/cases/{case}/metrics.json",
        code=command_code("reports", "run_ct"),
    output:
        multiext("results/figures/{case}_ct.", "svg", "png"),
    log:
        "results/cases/{case}/logs/ct_figure.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct_figure.tsv"
    params:
        case_dir=case_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports ct --case-dir {params.case_dir} --out-dir {params.out}"


rule study_figures:
    message:
        "figures of the study"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        code=code("reports", "reports.figures.study") + ["reports/study/published.json"],
    output:
        expand("results/figures/{name}.{format}", name=STUDY_FIGURES, format=["svg", "png"]),
    log:
        "results/study/logs/figures.log",
    benchmark:
        "results/study/benchmarks/figures.tsv"
    params:
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports figures --metrics {input.metrics} --out-dir {params.out}"


rule agreement:
    message:
        "agreement with what is known to be true"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        code=code("reports", "reports.study.agreement") + ["reports/study/published.json"],
    output:
        "results/study/agreement.csv",
    log:
        "results/study/logs/agreement.log",
    benchmark:
        "results/study/benchmarks/agreement.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports agreement --metrics {input.metrics} --out {output}"


rule nearer:
    message:
        "VCI or radius correction: which is nearer"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        code=code("reports", "reports.study.nearer"),
    output:
        "results/study/nearer.csv",
    log:
        "results/study/logs/nearer.log",
    benchmark:
        "results/study/benchmarks/nearer.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports nearer --metrics {input.metrics} --out {output}"


rule contrast:
    message:
        "VCI and radius correction, case by case"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        code=code("reports", "reports.study.contrast"),
    output:
        "results/study/contrast.csv",
    log:
        "results/study/logs/contrast.log",
    benchmark:
        "results/study/benchmarks/contrast.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports contrast --metrics {input.metrics} --out {output}"


rule differences:
    message:
        "Diff^A and Diff^C against the lumen after PCI"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        code=command_code("reports", "run_differences"),
    output:
        patients="results/study/differences.csv",
        stations="results/study/differences_stations.csv",
    log:
        "results/study/logs/differences.log",
    benchmark:
        "results/study/benchmarks/differences.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports differences --metrics {input.metrics}"
        " --stations {output.stations} --out {output.patients}"


rule cohort:
    message:
        "table of the cohort"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        code=code("reports", "reports.study.cohort"),
    output:
        "results/study/cohort.csv",
    log:
        "results/study/logs/cohort.log",
    benchmark:
        "results/study/benchmarks/cohort.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports cohort --metrics {input.metrics} --out {output}"


rule patients:
    message:
        "the patients on one page, and who is included"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        cases=[ancient(str(STUDY.case_file(case))) for case in CASES],
        failed=FAILED or [],
        code=command_code("reports", "run_patients"),
    output:
        table="results/study/patients.csv",
        inclusion="results/study/inclusion.csv",
        figure=multiext("results/figures/inclusion.", "svg", "png"),
    log:
        "results/study/logs/patients.log",
    benchmark:
        "results/study/benchmarks/patients.tsv"
    params:
        vessels=[STUDY.section(case, "vessel") for case in CASES],
        figures=lambda wildcards, output: os.path.dirname(output.figure[0]),
        failed=failed_option,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports patients --metrics {input.metrics} --configs {input.cases}"
        " --inclusion {output.inclusion} --figures-dir {params.figures} {params.failed} --out {output.table}"


rule timings:
    message:
        "table of timings"
    input:
        MADE_OF_CASES,  # each step has then written its seconds
        code=command_code("reports", "run_timings"),
    output:
        "results/study/timings.csv",
    log:
        "results/study/logs/timings.log",
    benchmark:
        "results/study/benchmarks/timings.tsv"
    params:
        case_dirs=expand("results/cases/{case}", case=CASES),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports timings --case-dir {params.case_dirs} --out {output}"


rule seconds:
    message:
        "seconds of the virtual procedure by stage and step"
    input:
        timings="results/study/timings.csv",
        code=command_code("reports", "run_seconds") + ["reports/study/published.json"],
    output:
        table="results/study/seconds.csv",
        figure=multiext("results/figures/seconds.", "svg", "png"),
    log:
        "results/study/logs/seconds.log",
    benchmark:
        "results/study/benchmarks/seconds.tsv"
    params:
        figures=lambda wildcards, output: os.path.dirname(output.figure[0]),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports seconds --timings {input.timings} --out {output.table}"
        " --figures-dir {params.figures}"


rule software:
    message:
        "versions of the software"
    input:
        MADE_OF_CASES,  # written anew with any result, since the revision may have changed since
        programs=[VCI, LUMEN, FLOW_FACTORS],
        code=command_code("reports", "run_software") + ["reports/page/three/package.json"],
    output:
        "results/study/software.json",
    log:
        "results/study/logs/software.log",
    benchmark:
        "results/study/benchmarks/software.tsv"
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports software --out {output}"


rule provenance:
    message:
        "provenance: hashes, versions, seeds and commands"
    input:
        MADE_OF_CASES,  # each product and each log is then written
        software="results/study/software.json",
        programs=[VCI, LUMEN, FLOW_FACTORS],
        code=command_code("workflow", "run_provenance"),
    output:
        "results/study/provenance.json",
    log:
        "results/study/logs/provenance.log",
    benchmark:
        "results/study/benchmarks/provenance.tsv"
    params:
        folder=STUDY.folder,
        cases=CASES,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m workflow provenance --folder {params.folder} --cases {params.cases}"
        " --programs {input.programs} --software {input.software} --out {output}"


rule report:
    message:
        "report"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        figures=expand(
            "results/figures/{case}_{name}.{format}", case=CASES, name=[*CASE_FIGURES, "procedure"], format=["svg", "png"]
        ),
        ct=expand("results/figures/{case}_ct.png", case=[case for case in CASES if "ct" in INPUTS.states(case)]),
        plans=expand("results/cases/{case}/plans/ranking.csv", case=CASES),
        sensitivity=expand("results/figures/{case}_sensitivity.{format}", case=CASES, format=["svg", "png"]),
        study_figures=expand("results/figures/{name}.{format}", name=STUDY_FIGURES, format=["svg", "png"]),
        pictures=expand("results/cases/{case}/{picture}.png", case=CASES, picture=["anatomy/tree", "vci/plan"]),
        tables=expand("results/study/{table}.csv", table=STUDY_TABLES),
        inclusion="results/figures/inclusion.svg",
        software="results/study/software.json",
        provenance="results/study/provenance.json",
        code=command_code("reports", "run_report") + ["reports/study/published.json"],
        claims=["reports/page/claims.yaml", "config/schemas/claims.schema.yaml"],
        source_map=["reports/page/source_map.yaml", "config/schemas/source_map.schema.yaml"],
        templates=INPUTS.page_templates(),
        three=os.path.join(BUILD, "three.min.js"),
        solved=solved_plans(CASES),
        tests=test_results(),
        failed=FAILED or [],
        benchmarks=benchmark_tables(),
    output:
        "results/report/index.html",
        "results/report/benchmarks.html",
        [directory(f"results/report/{name}") for name in ("assets", "cases", "data", "figures")],
    log:
        "results/study/logs/report.log",
    benchmark:
        "results/study/benchmarks/report.tsv"
    params:
        case_dirs=expand("results/cases/{case}", case=CASES),
        cohort=cohort_option(COHORT, config.get("cases")),
        study=study_folder,
        failed=failed_option,
        figures=figures_folder,
        benchmarks=benchmark_folder,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports report --case-dir {params.case_dirs} --study-dir {params.study}"
        " --figures-dir {params.figures} --software {input.software} --provenance {input.provenance} {params.cohort} {params.failed} {params.benchmarks}"
        " --junit {input.tests} --three {input.three} --out {params.out}"


rule numbers:
    message:
        "the study's numbers in one file"
    input:
        metrics=expand("results/cases/{case}/metrics.json", case=CASES),
        plans=expand("results/cases/{case}/plans/ranking.csv", case=CASES),
        intervals=expand("results/cases/{case}/sensitivity/flow_intervals.csv", case=CASES),
        tables=expand(
            "results/study/{table}.csv",
            table=["agreement", "half_maximum", "nearer", "contrast", "differences", "cohort", "patients", "inclusion"],
        ),
        provenance="results/study/provenance.json",
        code=command_code("reports", "run_numbers") + ["reports/study/published.json"],
        solved=solved_plans(CASES) + procedure_sensitivity_tables(CASES),
        tests=test_results(),
        failed=FAILED or [],
    output:
        "results/report/report.json",
    log:
        "results/study/logs/numbers.log",
    benchmark:
        "results/study/benchmarks/numbers.tsv"
    params:
        case_dirs=expand("results/cases/{case}", case=CASES),
        cohort=cohort_option(COHORT, config.get("cases")),
        study=study_folder,
        failed=failed_option,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports numbers --case-dir {params.case_dirs} --study-dir {params.study}"
        " {params.cohort} {params.failed} --junit {input.tests} --out {output}"


rule crate:
    message:
        "the study as a research object"
    input:
        page="results/report/index.html",
        numbers="results/report/report.json",
        provenance="results/study/provenance.json",
        citation="CITATION.cff",
        code=command_code("reports", "run_crate"),
    output:
        "results/ro-crate-metadata.json",
    log:
        "results/study/logs/crate.log",
    benchmark:
        "results/study/benchmarks/crate.tsv"
    params:
        cases=CASES,
        cohort=cohort_option(COHORT, config.get("cases")),
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m reports crate --cases {params.cases} {params.cohort} --out {output}"

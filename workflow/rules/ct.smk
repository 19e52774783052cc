# Simulated CT of the lumen before the procedure and of the reference after it, and the lumens segmented from it.


rule ct_phantom:
    message:
        "{wildcards.case}: CT of {wildcards.state}"
    input:
        unpack(INPUTS.phantom_inputs),
        settings="results/cases/{case}/settings/ct.json",
        code=code("data_synthetic", "data_synthetic.ct.scan"),
    output:
        image="results/cases/{case}/ct/{state}/ct.nii.gz",
        sidecar="results/cases/{case}/ct/{state}/ct.json",
    wildcard_constraints:
        state="|".join(CT_IMAGED_STATES),
    log:
        "results/cases/{case}/logs/ct/{state}_phantom.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct/{state}_phantom.tsv"
    params:
        stents=stent_options,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m data_synthetic phantom {input.lumen} --settings {input.settings}"
        " {params.stents} --out {params.out}"


rule ct_segment:
    message:
        "{wildcards.case}: lumen in the CT of {wildcards.state}"
    input:
        image="results/cases/{case}/ct/{state}/ct.nii.gz",
        ends=INPUTS.end_points_file,
        settings="results/cases/{case}/settings/ct.json",
        code=command_code("anatomy", "_ct"),
    output:
        lumen="results/cases/{case}/ct/{state}/lumen.vtp",
        segmentation="results/cases/{case}/ct/{state}/segmentation.json",
    wildcard_constraints:
        state="|".join(CT_IMAGED_STATES),
    log:
        "results/cases/{case}/logs/ct/{state}_segment.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct/{state}_segment.tsv"
    params:
        stented=stented_option,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy ct {input.image} --ends {input.ends}"
        " --settings {input.settings} {params.stented} --out {params.out}"

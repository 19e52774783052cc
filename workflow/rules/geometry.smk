# From a case's surface to its checked lumen, centreline, sections and lesions. Every later state takes the same steps.
# The steps before a plan have priority 2, so that unusable input is refused before any flow is computed.


rule settings:
    message:
        "{wildcards.case}: settings of {wildcards.section}"
    output:
        "results/cases/{case}/settings/{section}.json",
    priority: 2
    log:
        "results/cases/{case}/logs/settings/{section}.log",
    params:
        text=lambda wildcards: STUDY.section(wildcards.case, wildcards.section),
    shell:
        "printf '%s\\n' {params.text:q} >{output} 2>{log}"


rule generate:
    message:
        "{wildcards.case}: generating the vessel"
    input:
        case=ancient(CASE_FILE),
        code=code("data_synthetic", "data_synthetic.generate"),
    output:
        lumen="results/cases/{case}/source/lumen.vtp",
        truth="results/cases/{case}/source/truth.json",
    wildcard_constraints:
        case="|".join(STUDY.cases_of_kind("synthetic")) or "(?!)",
    priority: 2
    log:
        "results/cases/{case}/logs/generate.log",
    benchmark:
        "results/cases/{case}/benchmarks/generate.tsv"
    params:
        vessel=INPUTS.section("vessel"),
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m data_synthetic generate {input.case} --out {params.out}"


rule contours:
    message:
        "{wildcards.case}: lumen and plaque of the contours"
    input:
        unpack(INPUTS.contour_files),
        code=command_code("anatomy", "_contours"),
    output:
        surface="results/cases/{case}/source/lumen.vtp",
        contours="results/cases/{case}/source/contours.json",
        picture="results/cases/{case}/source/contours.png",
    wildcard_constraints:
        case="|".join(INPUTS.cases_from_contours()) or "(?!)",
    priority: 2
    log:
        "results/cases/{case}/logs/contours.log",
    benchmark:
        "results/cases/{case}/benchmarks/contours.tsv"
    params:
        options=INPUTS.contour_options,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy contours {params.options} --out {params.out}"


rule ct_lumen:
    message:
        "{wildcards.case}: lumen in the CT"
    input:
        unpack(INPUTS.ct_files),
        settings="results/cases/{case}/settings/ct.json",
        code=command_code("anatomy", "_ct"),
    output:
        surface="results/cases/{case}/source/lumen.vtp",
        segmentation="results/cases/{case}/source/segmentation.json",
    wildcard_constraints:
        case="|".join(INPUTS.cases_from_ct()) or "(?!)",
    priority: 2
    log:
        "results/cases/{case}/logs/ct_lumen.log",
    benchmark:
        "results/cases/{case}/benchmarks/ct_lumen.tsv"
    resources:
        **resources_by_size((1500, 20), (10, 0.2), "volume"),
    params:
        options=INPUTS.ct_options,
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy ct {params.options} --settings {input.settings} --out {params.out}"


rule anatomy:
    message:
        "{wildcards.case}: lumen, centreline, sections, lesions"
    input:
        lumen=INPUTS.lumen_file,
        caps=INPUTS.cap_files,
        binary=LUMEN,
    output:
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        centreline="results/cases/{case}/anatomy/centreline.vtp",
        sections="results/cases/{case}/anatomy/sections.csv",
        anatomy="results/cases/{case}/anatomy/anatomy.json",
    priority: 2
    log:
        "results/cases/{case}/logs/anatomy.log",
    benchmark:
        "results/cases/{case}/benchmarks/pre/anatomy.tsv"
    resources:
        **resources_by_size((1500, 25), (4, 0.1), "lumen"),
    params:
        surface=INPUTS.lumen_options,
        edge=INPUTS.setting("anatomy", "edge_mm"),
        spacing=INPUTS.setting("anatomy", "section_spacing_mm"),
        out=output_folder,
    shell:
        "workflow/run.sh {log} {input.binary} process {input.lumen:q} {params.surface} --edge {params.edge}"
        " --spacing {params.spacing} --out {params.out}"


rule state_anatomy:
    message:
        "{wildcards.case}: lumen, centreline, sections after {wildcards.state}"
    input:
        lumen=INPUTS.state_lumen,
        like=INPUTS.end_names_file,
        binary=LUMEN,
    output:
        lumen="results/cases/{case}/{state}/anatomy/lumen.vtp",
        centreline="results/cases/{case}/{state}/anatomy/centreline.vtp",
        sections="results/cases/{case}/{state}/anatomy/sections.csv",
        anatomy="results/cases/{case}/{state}/anatomy/anatomy.json",
    wildcard_constraints:
        state="|".join(state for state in ANATOMY_STATES if state != "pre"),
    log:
        "results/cases/{case}/logs/{state}/anatomy.log",
    benchmark:
        "results/cases/{case}/benchmarks/{state}/anatomy.tsv"
    params:
        edge=INPUTS.setting("anatomy", "edge_mm"),
        spacing=INPUTS.setting("anatomy", "section_spacing_mm"),
        out=output_folder,
    shell:
        "workflow/run.sh {log} {input.binary} process {input.lumen} --units mm --like {input.like} --edge {params.edge}"
        " --spacing {params.spacing} --out {params.out}"


use rule contours as post_contours with:
    message:
        "{wildcards.case}: lumen of the contours after the real procedure"
    input:
        unpack(INPUTS.for_post(INPUTS.contour_files)),
        code=command_code("anatomy", "_contours"),
    output:
        surface="results/cases/{case}/post/source/lumen.vtp",
        contours="results/cases/{case}/post/source/contours.json",
        picture="results/cases/{case}/post/source/contours.png",
    wildcard_constraints:
        case="|".join(INPUTS.cases_from_contours("post")) or "(?!)",
    log:
        "results/cases/{case}/logs/post/contours.log",
    benchmark:
        "results/cases/{case}/benchmarks/post/contours.tsv"
    params:
        options=INPUTS.for_post(INPUTS.contour_options),
        out=output_folder,


use rule ct_lumen as post_ct_lumen with:
    message:
        "{wildcards.case}: lumen in the CT after the real procedure"
    input:
        unpack(INPUTS.for_post(INPUTS.ct_files)),
        settings="results/cases/{case}/settings/ct.json",
        code=command_code("anatomy", "_ct"),
    output:
        surface="results/cases/{case}/post/source/lumen.vtp",
        segmentation="results/cases/{case}/post/source/segmentation.json",
    wildcard_constraints:
        case="|".join(INPUTS.cases_from_ct("post")) or "(?!)",
    log:
        "results/cases/{case}/logs/post/ct_lumen.log",
    benchmark:
        "results/cases/{case}/benchmarks/post/ct_lumen.tsv"
    params:
        options=INPUTS.for_post(INPUTS.ct_options),
        out=output_folder,


rule post_anatomy:
    message:
        "{wildcards.case}: lumen, centreline, sections after the real procedure, in their own frame"
    input:
        lumen=INPUTS.for_post(INPUTS.lumen_file),
        caps=INPUTS.for_post(INPUTS.cap_files),
        binary=LUMEN,
    output:
        lumen="results/cases/{case}/post/own/lumen.vtp",
        centreline="results/cases/{case}/post/own/centreline.vtp",
        sections="results/cases/{case}/post/own/sections.csv",
        anatomy="results/cases/{case}/post/own/anatomy.json",
    wildcard_constraints:
        case="|".join(STUDY.cases_with_key("post")) or "(?!)",
    log:
        "results/cases/{case}/logs/post/own.log",
    benchmark:
        "results/cases/{case}/benchmarks/post/own.tsv"
    resources:
        **resources_by_size((1500, 25), (4, 0.1), "lumen"),
    params:
        surface=INPUTS.for_post(INPUTS.lumen_options),
        edge=INPUTS.setting("anatomy", "edge_mm"),
        spacing=INPUTS.setting("anatomy", "section_spacing_mm"),
        out=output_folder,
    shell:
        "workflow/run.sh {log} {input.binary} process {input.lumen:q} {params.surface} --edge {params.edge}"
        " --spacing {params.spacing} --out {params.out}"


rule register:
    message:
        "{wildcards.case}: the lumen after the real procedure in the frame of the one before"
    input:
        case=ancient(CASE_FILE),
        pre="results/cases/{case}/anatomy/centreline.vtp",
        anatomy="results/cases/{case}/anatomy/anatomy.json",
        lumen="results/cases/{case}/post/own/lumen.vtp",
        post="results/cases/{case}/post/own/centreline.vtp",
        post_anatomy="results/cases/{case}/post/own/anatomy.json",
        code=code("anatomy", "anatomy.register.run"),
    output:
        lumen="results/cases/{case}/post/lumen.vtp",
        like="results/cases/{case}/post/like.json",
        registration="results/cases/{case}/post/registration.json",
    wildcard_constraints:
        case="|".join(STUDY.cases_with_key("post")) or "(?!)",
    log:
        "results/cases/{case}/logs/post/register.log",
    benchmark:
        "results/cases/{case}/benchmarks/post/register.tsv"
    params:
        registration=INPUTS.section("registration"),
        pre=lambda wildcards, input: os.path.dirname(input.anatomy),
        post=lambda wildcards, input: os.path.dirname(input.lumen),
        out=output_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy register {input.case} --pre {params.pre} --post {params.post}"
        " --out {params.out}"


rule anatomy_picture:
    message:
        "{wildcards.case}: picture of the tree"
    input:
        lumen="results/cases/{case}/anatomy/lumen.vtp",
        centreline="results/cases/{case}/anatomy/centreline.vtp",
        sections="results/cases/{case}/anatomy/sections.csv",
        anatomy="results/cases/{case}/anatomy/anatomy.json",
        code=code("anatomy", "anatomy.picture"),
    output:
        "results/cases/{case}/anatomy/tree.png",
    log:
        "results/cases/{case}/logs/anatomy_picture.log",
    benchmark:
        "results/cases/{case}/benchmarks/pre/anatomy_picture.tsv"
    params:
        anatomy=anatomy_folder,
    shell:
        "workflow/run.sh {log} /usr/bin/python3 -m anatomy picture --anatomy {params.anatomy} --out {output}"

"""Target `what_changed`: real flights with a known change against the vehicle's healthy ones. On request only."""

from infotraj.experiment.real.what_changed import read_study

WHAT_CHANGED = "config/studies/what_changed.yaml"
CHANGED_GROUPS = checked(read_study, WHAT_CHANGED).groups


rule what_changed_group:
    input:
        study=WHAT_CHANGED,
        vehicle=lambda wildcards: CHANGED_GROUPS[wildcards.group],
    output:
        answers="results/what_changed/{group}.json",
    log:
        "results/logs/what_changed/{group}.log",
    benchmark:
        "results/benchmarks/what_changed/{group}.tsv"
    wildcard_constraints:
        group="|".join(CHANGED_GROUPS),
    resources:
        mem_mb=1500,
    params:
        code=code("real.what_changed"),
        settings=settings("data_dir"),
    script:
        "../scripts/real/what_changed_group.py"


rule what_changed:
    input:
        study=WHAT_CHANGED,
        answers=expand("results/what_changed/{group}.json", group=list(CHANGED_GROUPS)),
    output:
        table="results/what_changed/table.csv",
        markdown="results/what_changed/table.md",
        pdf="results/what_changed/confusion.pdf",
        png=report(
            "results/what_changed/confusion.png",
            category="Real flights",
            caption="../report/what_changed.rst",
            labels={"data set": "CrazyPAD", "what": "what changed"},
        ),
    log:
        "results/logs/what_changed/table.log",
    benchmark:
        "results/benchmarks/what_changed/table.tsv"
    params:
        code=code("real.what_changed"),
    script:
        "../scripts/real/what_changed.py"


rule publish_what_changed:
    input:
        table=rules.what_changed.output.markdown,
        png=rules.what_changed.output.png,
    output:
        table="docs/results/what_changed.md",
        png="docs/results/what_changed.png",
    log:
        "results/logs/publish_what_changed.log",
    benchmark:
        "results/benchmarks/publish_what_changed.tsv"
    shell:
        "(cp {input.table} {output.table} && cp {input.png} {output.png}) 2> {log}"

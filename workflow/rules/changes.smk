"""Target `changes`: plants before and after a change, diagnosed with their healthy flights and without. On request only.

Flights and truth lie in folders of their own; only the scoring reads both. `changes_so_far` summarises what is there.
"""

from infotraj.experiment.changes.cases import batches as change_batches
from infotraj.experiment.changes.cases import read_changes

CHANGES = "config/studies/changes.yaml"
CHANGES_FOLDER = "results/changes"
CHANGE_BATCHES = change_batches(*checked(read_changes, CHANGES))


rule changes_fly:
    input:
        study=CHANGES,
    output:
        flights=temp(directory(f"{CHANGES_FOLDER}/{{key}}/flights")),
        truth=temp(directory(f"{CHANGES_FOLDER}/{{key}}/truth")),
    log:
        f"{CHANGES_FOLDER}/{{key}}/logs/fly.log",
    benchmark:
        f"{CHANGES_FOLDER}/{{key}}/benchmarks/fly.tsv"
    resources:
        mem_mb=800,
    params:
        code=code("changes.flying"),
    script:
        "../scripts/changes/fly.py"


rule changes_answer:
    input:
        flights=f"{CHANGES_FOLDER}/{{key}}/flights",
    output:
        answers=temp(directory(f"{CHANGES_FOLDER}/{{key}}/answers")),
    log:
        f"{CHANGES_FOLDER}/{{key}}/logs/answer.log",
    benchmark:
        f"{CHANGES_FOLDER}/{{key}}/benchmarks/answer.tsv"
    priority: 1
    resources:
        mem_mb=1500,
    params:
        code=code("changes.answering"),
    script:
        "../scripts/changes/answer.py"


rule changes_score:
    input:
        flights=f"{CHANGES_FOLDER}/{{key}}/flights",
        truth=f"{CHANGES_FOLDER}/{{key}}/truth",
        answers=f"{CHANGES_FOLDER}/{{key}}/answers",
    output:
        scores=f"{CHANGES_FOLDER}/{{key}}/scores.json",
    log:
        f"{CHANGES_FOLDER}/{{key}}/logs/score.log",
    benchmark:
        f"{CHANGES_FOLDER}/{{key}}/benchmarks/score.tsv"
    priority: 2
    params:
        code=code("changes.scoring"),
    script:
        "../scripts/changes/score.py"


rule changes:
    input:
        scores=expand(f"{CHANGES_FOLDER}/{{key}}/scores.json", key=CHANGE_BATCHES),
    output:
        table=f"{CHANGES_FOLDER}/table.csv",
        markdown=report(
            f"{CHANGES_FOLDER}/table.md",
            category="Hidden effects",
            caption="../report/changes.rst",
            labels={"table": "what changed"},
        ),
    log:
        "results/logs/changes.log",
    benchmark:
        "results/benchmarks/changes.tsv"
    params:
        code=code("changes.table"),
        planned=sum(map(len, CHANGE_BATCHES.values())),
    script:
        "../scripts/changes/table.py"


rule changes_so_far:
    log:
        "results/logs/changes_so_far.log",
    params:
        folder=f"{CHANGES_FOLDER}/so_far",
        scores=rules.changes.input.scores,
        planned=sum(map(len, CHANGE_BATCHES.values())),
    script:
        "../scripts/changes/so_far.py"


# What `changes_so_far` made, of the whole study or of a part of it.
rule publish_changes:
    input:
        markdown=f"{CHANGES_FOLDER}/so_far/table.md",
    output:
        markdown="docs/results/changes.md",
    log:
        "results/logs/publish_changes.log",
    benchmark:
        "results/benchmarks/publish_changes.tsv"
    shell:
        "cp {input.markdown} {output.markdown} 2> {log}"

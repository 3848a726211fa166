"""Which of two effects, told by a designed flight or by random ones, in a wide and in a narrow room. On request only.

A run is a line that is appended; one that is there is not made again, so it may be stopped and gone on with.
"""

from infotraj.experiment.separating.cases import read_separating

SEPARATING = {room: f"config/studies/separating_{room}.yaml" for room in ("wide", "narrow")}
SEPARATING_SCORES = {
    room: f"results/separating/{room}_{checked(read_separating, study)[0].base_seed}.jsonl"
    for room, study in SEPARATING.items()
}


rule separating:
    log:
        "results/logs/separating.log",
    params:
        studies=SEPARATING,
        scores=SEPARATING_SCORES,
    script:
        "../scripts/separating/run.py"


# Of what is there, of the whole study or of a part of it.
rule publish_separating_room:
    input:
        scores="results/separating/{room}_{seed}.jsonl",
        study="config/studies/separating_{room}.yaml",
    output:
        table="docs/results/separating_{room}_{seed}.csv",
        markdown="docs/results/separating_{room}_{seed}.md",
    log:
        "results/logs/publish_separating_{room}_{seed}.log",
    benchmark:
        "results/benchmarks/publish_separating_{room}_{seed}.tsv"
    params:
        code=code("separating.table"),
    script:
        "../scripts/separating/table.py"


rule publish_separating:
    input:
        [
            path.replace("results/separating/", "docs/results/separating_").replace(".jsonl", ".md")
            for path in SEPARATING_SCORES.values()
        ],

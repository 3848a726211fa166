"""Fly, diagnose, design, fly until what is hidden has its names: designed flights against others. On request only.

A run is a line that is appended; one that is there is not made again, so it may be stopped and gone on with.
"""

from infotraj.experiment.iterated.cases import read_iterated

ITERATED = "config/studies/iterated.yaml"
ITERATED_SCORES = f"results/iterated/{checked(read_iterated, ITERATED)[0].base_seed}.jsonl"


rule iterated:
    log:
        "results/logs/iterated.log",
    params:
        study=ITERATED,
        scores=ITERATED_SCORES,
    script:
        "../scripts/iterated/run.py"


# Of what is there, of the whole study or of a part of it.
rule publish_iterated_seed:
    input:
        scores="results/iterated/{seed}.jsonl",
        study=ITERATED,
    output:
        table="docs/results/iterated_{seed}.csv",
        markdown="docs/results/iterated_{seed}.md",
    log:
        "results/logs/publish_iterated_{seed}.log",
    benchmark:
        "results/benchmarks/publish_iterated_{seed}.tsv"
    params:
        code=code("iterated.table"),
    script:
        "../scripts/iterated/table.py"


rule publish_iterated:
    input:
        ITERATED_SCORES.replace("results/iterated/", "docs/results/iterated_").replace(".jsonl", ".md"),

"""Target `check_corpus`: how often `check` errs on simulated and real logs of all kinds. On request only."""


rule check_corpus:
    input:
        real=CONFIG.check_corpus.real,
        vehicle=CONFIG.vehicle,
    output:
        numbers="results/check_corpus/numbers.json",
        table="results/check_corpus/table.md",
        pdf="results/check_corpus/errors.pdf",
        png=report(
            "results/check_corpus/errors.png",
            category="Checks",
            caption="../report/check_corpus.rst",
            labels={"what": "errors of check"},
        ),
    log:
        "results/logs/check_corpus.log",
    benchmark:
        "results/benchmarks/check_corpus.tsv"
    threads: workflow.cores
    resources:
        mem_mb=2000,
    params:
        code=code("corpus.measuring"),
        settings=settings("check_corpus", "data_dir"),
    script:
        "../scripts/corpus/measure.py"


rule publish_check_corpus:
    input:
        table=rules.check_corpus.output.table,
        png=rules.check_corpus.output.png,
    output:
        table="docs/results/check_corpus.md",
        png="docs/results/check_corpus.png",
    log:
        "results/logs/publish_check_corpus.log",
    benchmark:
        "results/benchmarks/publish_check_corpus.tsv"
    shell:
        "(cp {input.table} {output.table} && cp {input.png} {output.png}) 2> {log}"

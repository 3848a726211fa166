"""Scenario `pool`: the choice among recorded real flights (skipped with a line where the data are absent)."""


rule judge_pool:
    output:
        table="results/pool/seed{seed}/flights.csv",
    log:
        "results/logs/judge_pool/seed{seed}.log",
    benchmark:
        "results/benchmarks/judge_pool/seed{seed}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=code("pool"),
        settings=settings("data_dir"),
        flights=data_fingerprint("nanobench"),
    script:
        "../scripts/judge_pool.py"


rule gather_pool:
    input:
        tables=expand(rules.judge_pool.output.table, seed=range(CONFIG.pool.seeds)),
    output:
        table="results/pool/flights.csv",
    log:
        "results/logs/gather_pool.log",
    benchmark:
        "results/benchmarks/gather_pool.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code("tables"),
    script:
        "../scripts/gather.py"


rule summarise_pool:
    input:
        table=rules.gather_pool.output.table,
    output:
        summary="results/pool/summary.csv",
        markdown=report(
            "results/pool/summary.md",
            category="Real flights",
            caption="../report/pool.rst",
            labels={"table": "choice against median and random"},
        ),
    log:
        "results/logs/summarise_pool.log",
    benchmark:
        "results/benchmarks/summarise_pool.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code("pool"),
    script:
        "../scripts/summarise_pool.py"

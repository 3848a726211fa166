"""Scenario `pool`: the choice among recorded real flights (skipped with a line where the data are absent)."""


rule judge_pool:
    output:
        table="results/pool/seed{seed}/flights.csv",
    log:
        "results/logs/judge_pool/seed{seed}.log",
    benchmark:
        "results/benchmarks/judge_pool/seed{seed}.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("real.pool"),
        settings=settings("data_dir"),
        flights=data_fingerprint("nanobench"),
    script:
        "../scripts/real/judge_pool.py"


rule gather_pool:
    input:
        tables=expand(rules.judge_pool.output.table, seed=range(CONFIG.pool.seeds)),
    output:
        table="results/pool/flights.csv",
    log:
        "results/logs/gather_pool.log",
    benchmark:
        "results/benchmarks/gather_pool.tsv"
    params:
        code=code("common.tables"),
    script:
        "../scripts/common/gather.py"


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
    params:
        code=code("real.pool"),
    script:
        "../scripts/real/summarise_pool.py"

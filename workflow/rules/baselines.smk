"""Target `baselines`: what users do today, on the flights of the closed loop; without PySINDy its row is left out."""


rule baselines:
    input:
        "results/baselines/score.md",


rule baselines_name:
    input:
        vehicle=CONFIG.vehicle,
        flights=LOOP_FLIGHTS,
    output:
        table=f"{LOOP}/baselines.csv",
    log:
        f"{LOOP_LOG}/baselines.log",
    benchmark:
        f"{LOOP_BENCHMARK}/baselines.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=code("baselines_scoring"),
    script:
        "../scripts/baselines_name.py"


rule baselines_score:
    input:
        tables=expand(f"{LOOP}/baselines.csv", case=CONFIG.closed_loop.cases, seed=range(CONFIG.closed_loop.seeds)),
        truths=f"{CONFIG.closed_loop.folder}/truths.csv",
    output:
        table="results/baselines/score.csv",
        markdown=report(
            "results/baselines/score.md",
            category="Hidden effects",
            caption="../report/baselines.rst",
            labels={"what": "what users do today"},
        ),
    log:
        "results/logs/baselines/score.log",
    benchmark:
        "results/benchmarks/baselines/score.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code("baselines_scoring"),
    script:
        "../scripts/baselines_score.py"

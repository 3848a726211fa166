"""All candidates in hindsight, and which cost would have chosen well. On request only: `snakemake --cores 2 hindsight`."""


rule hindsight_run:
    input:
        vehicle=CONFIG.vehicle,
        plant=plant_file,
        task=TASK,
        model=f"{RUN}/prior.npz",
    output:
        table=f"{RUN}/hindsight.csv",
    log:
        f"{RUN_LOG}/hindsight.log",
    benchmark:
        f"{RUN_BENCHMARK}/hindsight.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=code("hindsight"),
        settings=settings("vehicle", "base_seed", "deviations", "selection", "learning", "gains", "added_points"),
    script:
        "../scripts/hindsight.py"


rule costs_run:
    input:
        vehicle=CONFIG.vehicle,
        task=TASK,
        model=f"{RUN}/prior.npz",
    output:
        table=f"{RUN}/costs.csv",
    log:
        f"{RUN_LOG}/costs.log",
    benchmark:
        f"{RUN_BENCHMARK}/costs.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=code("costs"),
        settings=settings(
            "vehicle",
            "base_seed",
            "deviations",
            "selection",
            "learning",
            "gains",
            "added_points",
            "hindsight",
        ),
    script:
        "../scripts/hold_costs.py"


rule hindsight:
    input:
        hindsight=every_run(rules.hindsight_run.output.table),
        costs=every_run(rules.costs_run.output.table),
    output:
        table="results/hindsight.csv",
        markdown="results/hindsight.md",
    log:
        "results/logs/hindsight.log",
    benchmark:
        "results/benchmarks/hindsight.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code("costs_summary"),
    script:
        "../scripts/summarise_costs.py"

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
    resources:
        mem_mb=1000,
    params:
        code=code("paper.hindsight"),
        settings=settings("vehicle", "base_seed", "deviations", "selection", "learning", "gains", "added_points"),
    script:
        "../scripts/paper/hindsight.py"


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
    resources:
        mem_mb=1500,
    params:
        code=code("paper.costs"),
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
        "../scripts/paper/hold_costs.py"


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
    params:
        code=code("paper.costs_summary"),
    script:
        "../scripts/paper/summarise_costs.py"

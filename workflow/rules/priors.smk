"""A residual that knows the catalogue's effects against one that does not. On request only: `snakemake --cores 2 priors`."""


rule priors_run:
    input:
        vehicle=CONFIG.vehicle,
        plant=plant_file,
        task=TASK,
        modified=MODIFIED,
        flight=flight("prior"),
    output:
        table=f"{RUN}/priors.csv",
    log:
        f"{RUN_LOG}/priors.log",
    benchmark:
        f"{RUN_BENCHMARK}/priors.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("paper.priors"),
        settings=settings(
            "vehicle",
            "base_seed",
            "deviations",
            "selection",
            "learning",
            "gains",
            "prior_points",
            "added_points",
        ),
    script:
        "../scripts/paper/compare_priors.py"


rule priors:
    input:
        tables=every_run(rules.priors_run.output.table),
    output:
        table="results/priors.csv",
        markdown="results/priors.md",
    log:
        "results/logs/priors.log",
    benchmark:
        "results/benchmarks/priors.tsv"
    params:
        code=code("paper.priors_summary"),
    script:
        "../scripts/paper/summarise_priors.py"

"""When does the cost predict the error? Made on request only: `snakemake --cores 2 study`."""


rule study_run:
    input:
        vehicle=CONFIG.vehicle,
        plant=plant_file,
        reference=PITCH,
    output:
        table=f"{RUN}/study.csv",
    log:
        f"{RUN_LOG}/study.log",
    benchmark:
        f"{RUN_BENCHMARK}/study.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=code("studying"),
        settings=settings(
            "vehicle",
            "base_seed",
            "prior_points",
            "correlation",
            "deviations",
            "selection",
            "learning",
            "gains",
        ),
    script:
        "../scripts/study.py"


rule study:
    input:
        tables=expand(rules.study_run.output.table, plant=PLANTS, seed=SEEDS),
    output:
        markdown="results/study.md",
    log:
        "results/logs/study.log",
    benchmark:
        "results/benchmarks/study.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code("studying"),
    script:
        "../scripts/summarise_study.py"

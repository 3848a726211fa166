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

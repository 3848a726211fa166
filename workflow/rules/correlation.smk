"""Fig. 2: whether the cost predicts the error."""


rule correlate:
    input:
        vehicle=CONFIG.vehicle,
        plant=plant_file,
        reference=PITCH,
    output:
        table=f"{RUN}/correlation.csv",
    log:
        f"{RUN_LOG}/correlate.log",
    benchmark:
        f"{RUN_BENCHMARK}/correlate.tsv"
    resources:
        mem_mb=1500,
    params:
        code=code("paper.correlating"),
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
        "../scripts/paper/correlate.py"

"""Every flight of a run as a rerun recording."""


rule record:
    input:
        vehicle=CONFIG.vehicle,
        flights=list(recorded()),
        models=list(recorded().values()),
    output:
        recordings=[recording(flight) for flight in recorded()],
    log:
        f"{RUN_LOG}/record.log",
    benchmark:
        f"{RUN_BENCHMARK}/record.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("paper.recordings"),
        settings=settings("vehicle", "learning"),
    script:
        "../scripts/paper/record.py"

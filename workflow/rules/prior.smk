"""The tasks, and the prior model from one flight of the task."""


rule write_references:
    output:
        task=TASK,
        modified=MODIFIED,
        pitch=PITCH,
    log:
        "results/logs/write_references.log",
    benchmark:
        "results/benchmarks/write_references.tsv"
    params:
        code=code("paper.references"),
        settings=settings("task", "modified", "pitch", "sample_time"),
    script:
        "../scripts/paper/write_references.py"


rule learn_prior:
    input:
        vehicle=CONFIG.vehicle,
        flight=flight("prior"),
    output:
        model=f"{RUN}/prior.npz",
    log:
        f"{RUN_LOG}/learn_prior.log",
    benchmark:
        f"{RUN_BENCHMARK}/learn_prior.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.models"),
        settings=settings("vehicle", "base_seed", "learning", "prior_points"),
    script:
        "../scripts/paper/learn_prior.py"

"""Models from the flights of a round, with all hyperparameters optimised anew (eq. 6, 7)."""


rule learn:
    input:
        vehicle=CONFIG.vehicle,
        start=lambda wildcards: start_model(RUN, wildcards.source, wildcards.round),
        flight=flight("{source}_{round}"),
    output:
        models=expand(f"{ROUND}/models/{{source}}_plus{{added}}.npz", added=CONFIG.added_points, allow_missing=True),
    log:
        f"{RUN_LOG}/round{{round}}/learn_{{source}}.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/learn_{{source}}.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.models"),
        settings=settings("vehicle", "base_seed", "learning", "added_points"),
    script:
        "../scripts/paper/learn.py"

"""The task and the modified task flown with every model, and what the models leave of a flight that none has learned."""


rule validate_start:
    input:
        vehicle=CONFIG.vehicle,
        plant=plant_file,
        task=TASK,
        modified=MODIFIED,
        models=[f"{RUN}/prior.npz"],
    output:
        flights=expand(f"{RUN}/validation/{{key}}.parquet", key=START, allow_missing=True),
    log:
        f"{RUN_LOG}/validate_start.log",
    benchmark:
        f"{RUN_BENCHMARK}/validate_start.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.evaluating"),
        settings=settings("vehicle", "base_seed", "gains"),
        flight_names=START,
        model_names=[PRIOR],
    script:
        "../scripts/paper/validate.py"


rule validate:
    input:
        vehicle=CONFIG.vehicle,
        plant=plant_file,
        task=TASK,
        modified=MODIFIED,
        models=expand(f"{ROUND}/models/{{model}}.npz", model=MODELS, allow_missing=True),
    output:
        flights=expand(f"{ROUND}/validation/{{key}}.parquet", key=VALIDATED, allow_missing=True),
    log:
        f"{RUN_LOG}/round{{round}}/validate.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/validate.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.evaluating"),
        settings=settings("vehicle", "base_seed", "gains"),
        flight_names=lambda wildcards: [in_all(key, wildcards.round) for key in VALIDATED],
        model_names=lambda wildcards: [in_all(model, wildcards.round) for model in MODELS],
    script:
        "../scripts/paper/validate.py"


rule tracking_errors:
    input:
        vehicle=CONFIG.vehicle,
        flights=[
            *expand(f"{RUN}/validation/{{key}}.parquet", key=START, allow_missing=True),
            *expand(f"{ROUND}/validation/{{key}}.parquet", round=ROUNDS, key=VALIDATED, allow_missing=True),
        ],
    output:
        table=f"{RUN}/tracking.csv",
    log:
        f"{RUN_LOG}/tracking_errors.log",
    benchmark:
        f"{RUN_BENCHMARK}/tracking_errors.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.evaluating"),
        settings=settings("vehicle", "learning"),
        flight_names=[*START, *(in_all(key, round) for round in ROUNDS for key in VALIDATED)],
    script:
        "../scripts/paper/tracking_errors.py"


rule prediction_errors:
    input:
        vehicle=CONFIG.vehicle,
        flight=flight("test"),
        models=[
            f"{RUN}/prior.npz",
            *expand(f"{ROUND}/models/{{model}}.npz", round=ROUNDS, model=MODELS, allow_missing=True),
        ],
    output:
        table=f"{RUN}/prediction.csv",
    log:
        f"{RUN_LOG}/prediction_errors.log",
    benchmark:
        f"{RUN_BENCHMARK}/prediction_errors.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.evaluating"),
        settings=settings("vehicle", "learning"),
        model_names=[PRIOR, *(in_all(model, round) for round in ROUNDS for model in MODELS)],
    script:
        "../scripts/paper/prediction_errors.py"


rule gather_errors:
    input:
        tables=every_run(f"{RUN}/{{kind}}.csv", allow_missing=True),
    output:
        table="results/{kind}.csv",
    log:
        "results/logs/gather_{kind}.log",
    benchmark:
        "results/benchmarks/gather_{kind}.tsv"
    wildcard_constraints:
        kind="tracking|prediction|correlation",
    params:
        code=code("common.tables"),
    script:
        "../scripts/common/gather.py"

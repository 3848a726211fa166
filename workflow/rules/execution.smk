"""Who flies a reference: the MuJoCo plant, or a vehicle of your own whose flight tables you put in a folder.

Flights of a run: `prior`, the task with the first-principles model; `test`, the task with the prior model, from which
nothing is learned; `task_1` and `informative_1`, what the first round learns from; and so on for further rounds.
"""


rule fly:
    input:
        vehicle=CONFIG.vehicle,
        plant=plant_file,
        reference=flown_reference,
        model=flown_model,
    output:
        flight=f"{RUN}/flown/{{flight}}.parquet",
    log:
        f"{RUN_LOG}/fly/{{flight}}.log",
    benchmark:
        f"{RUN_BENCHMARK}/fly/{{flight}}.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.flying"),
        settings=settings("vehicle", "base_seed", "gains"),
    script:
        "../scripts/paper/fly.py"


rule receive:
    input:
        reference=flown_reference,
        model=flown_model,
        delivered=lambda wildcards: delivered(Path(CONFIG.flights) / f"seed{wildcards.seed}", wildcards.flight),
    output:
        flight=f"{RUN}/received/{{flight}}.parquet",
    log:
        f"{RUN_LOG}/receive/{{flight}}.log",
    benchmark:
        f"{RUN_BENCHMARK}/receive/{{flight}}.tsv"
    params:
        code=code("paper.receiving"),
        settings=settings("flights"),
    script:
        "../scripts/paper/receive.py"

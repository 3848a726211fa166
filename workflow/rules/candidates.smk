"""Candidates, simulation, region, cost and choice (eq. 12 to 18); the controls choose among the same candidates."""


rule choose:
    input:
        vehicle=CONFIG.vehicle,
        task=TASK,
        model=lambda wildcards: start_model(RUN, wildcards.source, wildcards.round),
    output:
        reference=f"{ROUND}/{{source}}.csv",
        costs=f"{ROUND}/costs_{{source}}.csv",
        region=f"{ROUND}/region_{{source}}.npz",
    log:
        f"{RUN_LOG}/round{{round}}/choose_{{source}}.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/choose_{{source}}.tsv"
    wildcard_constraints:
        source="informative|paper",
    resources:
        mem_mb=1500,
    params:
        code=code("paper.choosing"),
        settings=settings("vehicle", "base_seed", "deviations", "selection", "gains", "added_points"),
    script:
        "../scripts/paper/choose.py"


rule choose_random:
    input:
        vehicle=CONFIG.vehicle,
        task=TASK,
    output:
        reference=f"{ROUND}/random.csv",
    log:
        f"{RUN_LOG}/round{{round}}/choose_random.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/choose_random.tsv"
    params:
        code=code("paper.choosing"),
        settings=settings("vehicle", "base_seed", "deviations", "selection"),
    script:
        "../scripts/paper/choose_random.py"


rule simulate_chosen:
    input:
        vehicle=CONFIG.vehicle,
        reference=f"{ROUND}/informative.csv",
        model=lambda wildcards: start_model(RUN, "informative", wildcards.round),
    output:
        rollout=f"{ROUND}/rollout.parquet",
    log:
        f"{RUN_LOG}/round{{round}}/simulate_chosen.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/simulate_chosen.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("paper.rollouts"),
        settings=settings("vehicle", "base_seed", "gains", "selection"),
    script:
        "../scripts/paper/simulate_chosen.py"

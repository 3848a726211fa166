"""Candidates, simulation, region, cost and choice (eq. 12 to 18)."""


rule choose_informative:
    input:
        vehicle=CONFIG.vehicle,
        task=TASK,
        model=lambda wildcards: start_model(RUN, "informative", wildcards.round),
    output:
        reference=f"{ROUND}/informative.csv",
        costs=f"{ROUND}/costs.csv",
        region=f"{ROUND}/region.npz",
    log:
        f"{RUN_LOG}/round{{round}}/choose_informative.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/choose_informative.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=code("choosing"),
        settings=settings("vehicle", "base_seed", "deviations", "selection", "learning", "gains", "added_points"),
    script:
        "../scripts/choose_informative.py"


rule simulate_chosen:
    input:
        vehicle=CONFIG.vehicle,
        reference=rules.choose_informative.output.reference,
        model=lambda wildcards: start_model(RUN, "informative", wildcards.round),
    output:
        rollout=f"{ROUND}/rollout.parquet",
    log:
        f"{RUN_LOG}/round{{round}}/simulate_chosen.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/simulate_chosen.tsv"
    threads: 1
    resources:
        mem_mb=700,
    params:
        code=code("rollouts"),
        settings=settings("vehicle", "base_seed", "gains", "selection"),
    script:
        "../scripts/simulate_chosen.py"

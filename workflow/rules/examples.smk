"""Target `example_flights`: what ships in examples/quad. On request only: the files stand in the repository."""

EXAMPLE_STUDY = "config/studies/example_flights.yaml"
EXAMPLE_RUNS = {"changed": "--effects rotor_effectiveness --seed 0", "healthy": "--seed 1"}


rule fly_examples:
    input:
        study=EXAMPLE_STUDY,
        vehicle="config/vehicles/quadrotor.yaml",
    output:
        flights=directory("results/examples/{run}/shown"),
        truth=directory("results/examples/{run}/truth"),
    log:
        "results/logs/examples/{run}.log",
    benchmark:
        "results/benchmarks/examples/{run}.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("hidden.once"),
        what=lambda wildcards: EXAMPLE_RUNS[wildcards.run],
    shell:
        "python -m infotraj.experiment.hidden.once {output.flights} {output.truth} --study {input.study}"
        " --vehicle quadrotor {params.what} > {log} 2>&1"


rule example_flights:
    input:
        changed="results/examples/changed/shown",
        healthy="results/examples/healthy/shown",
        truth="results/examples/changed/truth",
    output:
        changed=[f"examples/quad/flight_{k}.parquet" for k in range(3)],
        healthy=[f"examples/quad/healthy/flight_{k}.parquet" for k in range(3)],
        log="examples/quad/log/board.csv",
        truth="examples/quad/truth.sealed",
    log:
        "results/logs/examples/pack.log",
    benchmark:
        "results/benchmarks/examples/pack.tsv"
    resources:
        mem_mb=1000,
    params:
        code=fingerprint("infotraj.examples.packing"),
    script:
        "../scripts/examples/pack.py"

"""Target `real_flights`: public real flights through import, check, compare and locate.

Data sets that are not on this machine are skipped with a line that says how to get them.
"""


rule real_flights:
    input:
        real_results,


rule real_receive:
    output:
        flights=directory(f"{REAL}/flights"),
        table=report(
            f"{REAL}/checks.csv",
            category="Real flights",
            caption="../report/real_flights.rst",
            labels={"data set": "{dataset}", "what": "checks"},
        ),
    log:
        f"{REAL_LOG}/receive.log",
    benchmark:
        f"{REAL_BENCHMARK}/receive.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=code("real_flights"),
        settings=settings("data_dir"),
        flights=lambda wildcards: data_fingerprint(wildcards.dataset),
    script:
        "../scripts/real_receive.py"


rule real_compare:
    input:
        flights=f"{REAL}/flights",
        models=real_model_files,
    output:
        numbers=f"{REAL}/comparison.json",
        text=f"{REAL}/comparison.txt",
        figures=report(
            directory(f"{REAL}/comparison"),
            patterns=["{name}.png"],
            category="Real flights",
            caption="../report/real_flights.rst",
            labels={"data set": "{dataset}", "what": "comparison"},
        ),
    log:
        f"{REAL_LOG}/compare.log",
    benchmark:
        f"{REAL_BENCHMARK}/compare.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        code=code("real_flights"),
    script:
        "../scripts/real_compare.py"


rule real_locate:
    input:
        flights=f"{REAL}/flights",
        models=real_model_files,
    output:
        numbers=f"{REAL}/{{model}}/places.json",
        text=f"{REAL}/{{model}}/places.txt",
        figures=report(
            directory(f"{REAL}/{{model}}/figures"),
            patterns=["{name}.png"],
            category="Real flights",
            caption="../report/real_flights.rst",
            labels={"data set": "{dataset}", "what": "where {model} fails"},
        ),
    log:
        f"{REAL_LOG}/{{model}}/locate.log",
    benchmark:
        f"{REAL_BENCHMARK}/{{model}}/locate.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        code=code("real_flights"),
    script:
        "../scripts/real_locate.py"


rule real_summary:
    input:
        comparisons=lambda _: [p for p in real_results(_) if p.endswith("comparison.json")],
        places=lambda _: [p for p in real_results(_) if p.endswith("places.json")],
    output:
        table="results/real_flights/summary.csv",
        markdown=report(
            "results/real_flights/summary.md",
            category="Real flights",
            caption="../report/real_flights.rst",
            labels={"data set": "all", "what": "summary"},
        ),
    log:
        "results/logs/real_flights/summary.log",
    benchmark:
        "results/benchmarks/real_flights/summary.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code("real_flights"),
    script:
        "../scripts/real_summary.py"

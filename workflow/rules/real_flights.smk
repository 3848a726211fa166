"""Target `real_flights`: public real flights through import, check, compare, locate, diagnose and add.

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
    resources:
        mem_mb=1000,
    params:
        code=code("real.flights"),
        settings=settings("data_dir"),
        flights=lambda wildcards: data_fingerprint(wildcards.dataset),
    script:
        "../scripts/real/receive.py"


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
    resources:
        mem_mb=2000,
    params:
        code=code("real.flights"),
    script:
        "../scripts/real/compare.py"


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
    resources:
        mem_mb=2000,
    params:
        code=code("real.flights"),
    script:
        "../scripts/real/locate.py"


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
    params:
        code=code("real.flights"),
    script:
        "../scripts/real/summary.py"


rule real_cut:
    output:
        flights=directory(f"{REAL_DIAGNOSIS}/windows"),
    log:
        f"{REAL_LOG}/cut.log",
    benchmark:
        f"{REAL_BENCHMARK}/cut.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("real.windows"),
        settings=settings("data_dir", "real_flights"),
        logs=real_logs,
    script:
        "../scripts/real/cut.py"


rule real_diagnose:
    input:
        flights=f"{REAL_DIAGNOSIS}/windows",
        models=real_model_files,
    output:
        numbers=f"{REAL_DIAGNOSIS}/diagnosis.json",
        text=f"{REAL_DIAGNOSIS}/diagnosis.txt",
        table=f"{REAL_DIAGNOSIS}/verdicts.csv",
        model=f"{REAL_DIAGNOSIS}/model.yaml",
        png=report(
            f"{REAL_DIAGNOSIS}/waterfall.png",
            category="Real flights",
            caption="../report/real_diagnosis.rst",
            labels={"data set": "{dataset}", "what": "held-out error, effect by effect"},
        ),
        pdf=f"{REAL_DIAGNOSIS}/waterfall.pdf",
    log:
        f"{REAL_LOG}/diagnose.log",
    benchmark:
        f"{REAL_BENCHMARK}/diagnose.tsv"
    resources:
        mem_mb=3000,
    params:
        code=code("real.diagnosis"),
        settings=settings("real_flights"),
    script:
        "../scripts/real/diagnose.py"


rule real_held_out:
    input:
        flights=f"{REAL_DIAGNOSIS}/windows",
        models=real_model_files,
        model=f"{REAL_DIAGNOSIS}/model.yaml",
    output:
        table=f"{REAL_DIAGNOSIS}/held_out.csv",
    log:
        f"{REAL_LOG}/held_out.log",
    benchmark:
        f"{REAL_BENCHMARK}/held_out.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("real.diagnosis"),
        settings=settings("real_flights"),
    script:
        "../scripts/real/held_out.py"


rule real_add:
    input:
        flights=f"{REAL_DIAGNOSIS}/windows",
        models=real_model_files,
    output:
        table=f"{REAL_DIAGNOSIS}/added.csv",
    log:
        f"{REAL_LOG}/add.log",
    benchmark:
        f"{REAL_BENCHMARK}/add.tsv"
    resources:
        mem_mb=3000,
    params:
        code=code("real.diagnosis"),
        settings=settings("real_flights"),
    script:
        "../scripts/real/add.py"


rule real_verdicts:
    input:
        verdicts=real_diagnoses("verdicts.csv"),
        numbers=real_diagnoses("diagnosis.json"),
        held_out=real_diagnoses("held_out.csv", "held_out"),
        added=real_diagnoses("added.csv", "add"),
    output:
        table="results/real_flights/verdicts.csv",
        held_out_table="results/real_flights/held_out.csv",
        added_table="results/real_flights/added.csv",
        markdown=report(
            "results/real_flights/diagnosis.md",
            category="Real flights",
            caption="../report/real_diagnosis.rst",
            labels={"data set": "all", "what": "verdicts, held-out error, named effects"},
        ),
    log:
        "results/logs/real_flights/verdicts.log",
    benchmark:
        "results/benchmarks/real_flights/verdicts.tsv"
    params:
        code=code("real.verdicts"),
    script:
        "../scripts/real/verdicts.py"

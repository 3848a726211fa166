"""Target `real_table`: public real flights of known vehicles, from raw logs to a table of what is answered. On request only.

Cases whose data are not on this machine are skipped, with the reason on standard error and in the table.
"""


rule real_case_flights:
    output:
        flights=directory(f"{REAL_CASE}/flights"),
    log:
        "results/logs/real_table/{case}/flights.log",
    benchmark:
        "results/benchmarks/real_table/{case}/flights.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("real.cases"),
        settings=settings("data_dir"),
        cases=CONFIG.real_table.cases,
        logs=real_case_logs,
    script:
        "../scripts/real/case_flights.py"


rule real_case:
    input:
        flights=f"{REAL_CASE}/flights",
        models=real_model_files,
    output:
        numbers=f"{REAL_CASE}/answer.json",
        text=f"{REAL_CASE}/answer.txt",
        model=f"{REAL_CASE}/model.yaml",
    log:
        "results/logs/real_table/{case}/answer.log",
    benchmark:
        "results/benchmarks/real_table/{case}/answer.tsv"
    resources:
        mem_mb=3000,
    params:
        code=code("real.answering"),
        cases=CONFIG.real_table.cases,
        asked=real_case_asked,
    script:
        "../scripts/real/case.py"


rule real_table:
    input:
        answers=real_answers,
        cases=CONFIG.real_table.cases,
    output:
        table="results/real_table/table.csv",
        markdown=report(
            "results/real_table/table.md",
            category="Real flights",
            caption="../report/real_table.rst",
            labels={"data set": "all", "what": "known and answered"},
        ),
    log:
        "results/logs/real_table/table.log",
    benchmark:
        "results/benchmarks/real_table/table.tsv"
    params:
        code=code("real.table"),
        settings=settings("data_dir", "real_table"),
    script:
        "../scripts/real/table.py"


rule publish_real_table:
    input:
        rules.real_table.output.markdown,
    output:
        "docs/results/real_flights.md",
    log:
        "results/logs/publish_real_table.log",
    benchmark:
        "results/benchmarks/publish_real_table.tsv"
    shell:
        "cp {input} {output} 2> {log}"

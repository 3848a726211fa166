"""The paper's figures, Table I and its claims, as PDF, PNG and text."""


rule figure_2:
    input:
        table="results/correlation.csv",
    output:
        pdf=report(
            "results/figures/figure_2.pdf",
            category="Figures",
            caption="../report/figure_2.rst",
            labels={"figure": "2: cost against error"},
        ),
        png="results/figures/figure_2.png",
    log:
        "results/logs/figure_2.log",
    benchmark:
        "results/benchmarks/figure_2.tsv"
    params:
        code=code("paper.figures"),
        function="figure_2",
    script:
        "../scripts/paper/figure.py"


rule figure_3:
    input:
        **{source: f"{SHOWN}/validation/task/{source}_plus{LARGEST}.parquet" for source in SOURCES},
        reference=TASK,
    output:
        pdf=report(
            "results/figures/figure_3.pdf",
            category="Figures",
            caption="../report/figure_3.rst",
            labels={"figure": "3: the task on the sphere"},
        ),
        png="results/figures/figure_3.png",
    log:
        "results/logs/figure_3.log",
    benchmark:
        "results/benchmarks/figure_3.tsv"
    params:
        code=code("paper.figures"),
        function="figure_3",
    script:
        "../scripts/paper/figure.py"


rule figure_4:
    input:
        table="results/tracking.csv",
    output:
        pdf=report(
            "results/figures/figure_4.pdf",
            category="Figures",
            caption="../report/figure_4.rst",
            labels={"figure": "4: error against data"},
        ),
        png="results/figures/figure_4.png",
    log:
        "results/logs/figure_4.log",
    benchmark:
        "results/benchmarks/figure_4.tsv"
    params:
        code=code("paper.figures"),
        function="figure_4",
    script:
        "../scripts/paper/figure.py"


rule figure_5:
    input:
        task=f"{SHOWN}/validation/task/informative_plus{LARGEST}.parquet",
        modified=f"{SHOWN}/validation/modified/informative_plus{LARGEST}.parquet",
    output:
        pdf=report(
            "results/figures/figure_5.pdf",
            category="Figures",
            caption="../report/figure_5.rst",
            labels={"figure": "5: task and modified task"},
        ),
        png="results/figures/figure_5.png",
    log:
        "results/logs/figure_5.log",
    benchmark:
        "results/benchmarks/figure_5.tsv"
    params:
        code=code("paper.figures"),
        function="figure_5",
    script:
        "../scripts/paper/figure.py"


rule figure_costs:
    input:
        table=f"{ROUND}/costs_informative.csv",
    output:
        pdf=f"{ROUND}/figure_costs.pdf",
        png=report(
            f"{ROUND}/figure_costs.png",
            category="Costs of all candidates",
            caption="../report/figure_costs.rst",
            labels={"plant": "{plant}", "seed": "{seed}", "round": "{round}"},
        ),
    log:
        f"{RUN_LOG}/round{{round}}/figure_costs.log",
    benchmark:
        f"{RUN_BENCHMARK}/round{{round}}/figure_costs.tsv"
    params:
        code=code("paper.figures"),
        function="figure_costs",
    script:
        "../scripts/paper/figure.py"


rule figure_pool:
    input:
        table="results/pool/flights.csv",
    output:
        pdf=report(
            "results/figures/figure_pool.pdf",
            category="Real flights",
            caption="../report/pool.rst",
            labels={"figure": "cost against error"},
        ),
        png="results/figures/figure_pool.png",
    log:
        "results/logs/figure_pool.log",
    benchmark:
        "results/benchmarks/figure_pool.tsv"
    params:
        code=code("paper.figures"),
        function="figure_pool",
    script:
        "../scripts/paper/figure.py"


rule table_1:
    input:
        table="results/tracking.csv",
    output:
        csv="results/table_1.csv",
        markdown="results/table_1.md",
        tex="results/table_1.tex",
        png=report(
            "results/table_1.png",
            category="Figures",
            caption="../report/table_1.rst",
            labels={"figure": "Table I"},
        ),
    log:
        "results/logs/table_1.log",
    benchmark:
        "results/benchmarks/table_1.tsv"
    params:
        code=code("paper.figures"),
        points=CONFIG.prior_points + LARGEST,
    script:
        "../scripts/paper/table_1.py"


rule claims:
    input:
        tracking="results/tracking.csv",
        correlation="results/correlation.csv",
        pool="results/pool/summary.csv" if HAS_POOL else [],
    output:
        table="results/claims.csv",
        markdown="results/claims.md",
        png=report(
            "results/claims.png",
            category="Claims",
            caption="../report/claims.rst",
            labels={"table": "claims"},
        ),
    log:
        "results/logs/claims.log",
    benchmark:
        "results/benchmarks/claims.tsv"
    params:
        code=code("paper.claiming"),
        points=CONFIG.prior_points + LARGEST,
    script:
        "../scripts/paper/claims.py"

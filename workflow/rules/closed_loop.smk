"""Target `closed_loop`: hidden effects are flown, named, and flown again with what was named; the story's figure."""

LOOP = "results/closed_loop/{case}/seed{seed}"
LOOP_LOG = "results/logs/closed_loop/{case}/seed{seed}"
LOOP_BENCHMARK = "results/benchmarks/closed_loop/{case}/seed{seed}"
LOOP_CASE = f"{CONFIG.closed_loop.folder}/{{case}}"
LOOP_FLIGHTS = [f"{LOOP}/flights/fit_{k}.parquet" for k in range(CONFIG.closed_loop.fit_flights)]
LOOP_SHOWN = f"results/closed_loop/{CONFIG.closed_loop.shown}/seed0"


wildcard_constraints:
    case=r"[A-Za-z0-9_-]+",


rule closed_loop:
    input:
        "results/closed_loop/summary.md",
        "results/figures/story.png",
        "results/figures/points_needed.png",


rule closed_loop_fly:
    input:
        vehicle=CONFIG.vehicle,
        truth=f"{LOOP_CASE}/truth.yaml",
    output:
        flights=LOOP_FLIGHTS,
        test=f"{LOOP}/nominal.parquet",
    log:
        f"{LOOP_LOG}/fly.log",
    benchmark:
        f"{LOOP_BENCHMARK}/fly.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("closed_loop.stages"),
        settings=settings("vehicle", "base_seed", "sample_time", "gains", "closed_loop"),
    script:
        "../scripts/closed_loop/fly.py"


rule closed_loop_name:
    input:
        vehicle=CONFIG.vehicle,
        flights=LOOP_FLIGHTS,
    output:
        right=f"{LOOP}/right.yaml",
        wrong=directory(f"{LOOP}/wrong"),
        numbers=f"{LOOP}/diagnosis.json",
        fall=f"{LOOP}/fall.csv",
    log:
        f"{LOOP_LOG}/name.log",
    benchmark:
        f"{LOOP_BENCHMARK}/name.tsv"
    resources:
        mem_mb=1500,
    params:
        code=code("closed_loop.stages"),
        settings=settings("vehicle", "base_seed", "closed_loop"),
    script:
        "../scripts/closed_loop/name.py"


rule closed_loop_again:
    input:
        vehicle=CONFIG.vehicle,
        truth=f"{LOOP_CASE}/truth.yaml",
        oracle=f"{LOOP_CASE}/oracle.yaml",
        flights=LOOP_FLIGHTS,
        test=f"{LOOP}/nominal.parquet",
        right=f"{LOOP}/right.yaml",
        wrong=f"{LOOP}/wrong",
    output:
        table=f"{LOOP}/table.csv",
    log:
        f"{LOOP_LOG}/again.log",
    benchmark:
        f"{LOOP_BENCHMARK}/again.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("closed_loop.stages"),
        settings=settings("vehicle", "base_seed", "sample_time", "gains", "learning", "closed_loop"),
    script:
        "../scripts/closed_loop/again.py"


rule closed_loop_summary:
    input:
        tables=expand(f"{LOOP}/table.csv", case=CONFIG.closed_loop.cases, seed=range(CONFIG.closed_loop.seeds)),
    output:
        runs="results/closed_loop/runs.csv",
        table="results/closed_loop/summary.csv",
        markdown=report(
            "results/closed_loop/summary.md",
            category="Hidden effects",
            caption="../report/closed_loop.rst",
            labels={"what": "the flight with each model"},
        ),
    log:
        "results/logs/closed_loop/summary.log",
    benchmark:
        "results/benchmarks/closed_loop/summary.tsv"
    params:
        code=code("closed_loop.summary"),
    script:
        "../scripts/closed_loop/summary.py"


rule story:
    input:
        flight=f"{LOOP_SHOWN}/nominal.parquet",
        flights=[f"{LOOP_SHOWN}/flights/fit_{k}.parquet" for k in range(CONFIG.closed_loop.fit_flights)],
        model=f"{LOOP_SHOWN}/right.yaml",
        numbers=f"{LOOP_SHOWN}/diagnosis.json",
        fall=f"{LOOP_SHOWN}/fall.csv",
        runs="results/closed_loop/runs.csv",
    output:
        png=report(
            "results/figures/story.png",
            category="Hidden effects",
            caption="../report/closed_loop.rst",
            labels={"what": "from the flight to the name, and back to the flight"},
        ),
        pdf="results/figures/story.pdf",
    log:
        "results/logs/closed_loop/story.log",
    benchmark:
        "results/benchmarks/closed_loop/story.tsv"
    resources:
        mem_mb=1000,
    params:
        code=code("closed_loop.story"),
        settings=settings("closed_loop"),
    script:
        "../scripts/closed_loop/story.py"


rule closed_loop_points:
    input:
        vehicle=CONFIG.vehicle,
        flights=LOOP_FLIGHTS,
        test=f"{LOOP}/nominal.parquet",
        right=f"{LOOP}/right.yaml",
    output:
        table=f"{LOOP}/points.csv",
    log:
        f"{LOOP_LOG}/points.log",
    benchmark:
        f"{LOOP_BENCHMARK}/points.tsv"
    resources:
        mem_mb=700,
    params:
        code=code("closed_loop.stages"),
        settings=settings("vehicle", "base_seed", "learning", "closed_loop"),
    script:
        "../scripts/closed_loop/points.py"


rule points_needed:
    input:
        tables=expand(f"{LOOP}/points.csv", case=CONFIG.closed_loop.cases, seed=range(CONFIG.closed_loop.curve_seeds)),
    output:
        table="results/closed_loop/points.csv",
        png=report(
            "results/figures/points_needed.png",
            category="Hidden effects",
            caption="../report/closed_loop.rst",
            labels={"what": "points that a Gaussian process needs"},
        ),
        pdf="results/figures/points_needed.pdf",
    log:
        "results/logs/closed_loop/points_needed.log",
    benchmark:
        "results/benchmarks/closed_loop/points_needed.tsv"
    params:
        code=code("closed_loop.story"),
    script:
        "../scripts/closed_loop/points_needed.py"

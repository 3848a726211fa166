"""Target `hidden_effects`: flights of plants that hide something, diagnosed by the public command, scored apart.

Flights and truth lie in folders of their own; only the scoring reads both. Lower waves run first, and a batch that has
been begun is finished first. `hidden_effects_so_far` summarises what is there of a run that was stopped.
"""


rule hidden_effects:
    input:
        hidden_results,


for wave in HIDDEN_WAVES:

    rule:
        name:
            f"hidden_fly_{wave}"
        output:
            flights=temp(directory(f"{hidden_of(wave)}/flights")),
            truth=temp(directory(f"{hidden_of(wave)}/truth")),
        log:
            f"{hidden_of(wave)}/logs/fly.log",
        benchmark:
            f"{hidden_of(wave)}/benchmarks/fly.tsv"
        priority: 60 - 10 * wave
        resources:
            mem_mb=800,
        params:
            code=code("hidden.flying"),
            case=hidden_case,
            seeds=hidden_seeds,
            study=hidden_study,
        script:
            "../scripts/hidden/fly.py"

    rule:
        name:
            f"hidden_diagnose_{wave}"
        input:
            flights=f"{hidden_of(wave)}/flights",
        output:
            answers=temp(directory(f"{hidden_of(wave)}/answers")),
        log:
            f"{hidden_of(wave)}/logs/diagnose.log",
        benchmark:
            f"{hidden_of(wave)}/benchmarks/diagnose.tsv"
        priority: 61 - 10 * wave
        resources:
            mem_mb=1500,
        params:
            code=code("hidden.diagnosing"),
        script:
            "../scripts/hidden/diagnose.py"

    rule:
        name:
            f"hidden_today_{wave}"
        input:
            flights=f"{hidden_of(wave)}/flights",
        output:
            named=temp(directory(f"{hidden_of(wave)}/named")),
        log:
            f"{hidden_of(wave)}/logs/today.log",
        benchmark:
            f"{hidden_of(wave)}/benchmarks/today.tsv"
        priority: 61 - 10 * wave
        resources:
            mem_mb=800,
        params:
            code=code("hidden.today"),
            ways=list(methods()),
        script:
            "../scripts/hidden/today.py"

    rule:
        name:
            f"hidden_score_{wave}"
        input:
            flights=f"{hidden_of(wave)}/flights",
            truth=f"{hidden_of(wave)}/truth",
            answers=f"{hidden_of(wave)}/answers",
            named=f"{hidden_of(wave)}/named",
        output:
            scores=f"{hidden_of(wave)}/scores.json",
        log:
            f"{hidden_of(wave)}/logs/score.log",
        benchmark:
            f"{hidden_of(wave)}/benchmarks/score.tsv"
        priority: 62 - 10 * wave
        resources:
            mem_mb=1500,
        params:
            code=code("hidden.scoring"),
        script:
            "../scripts/hidden/score.py"


rule hidden_summary:
    input:
        scores=hidden_scores,
    output:
        markdown=report(
            f"{HIDDEN_FOLDER}/summary.md",
            category="Hidden effects",
            caption="../report/hidden_effects.rst",
            labels={"table": "targets, runs made, wrong answers"},
        ),
        tables=directory(f"{HIDDEN_FOLDER}/tables"),
        figures=report(
            directory(f"{HIDDEN_FOLDER}/figures"),
            patterns=["{name}.png"],
            category="Hidden effects",
            caption="../report/hidden_effects.rst",
            labels={"figure": "{name}"},
        ),
    log:
        "results/logs/hidden_effects/summary.log",
    benchmark:
        "results/benchmarks/hidden_effects/summary.tsv"
    resources:
        mem_mb=800,
    params:
        code=code("hidden.summary"),
        settings=settings("hidden_effects"),
    script:
        "../scripts/hidden/summary.py"


rule hidden_effects_so_far:
    log:
        "results/logs/hidden_effects/so_far.log",
    params:
        folder=f"{HIDDEN_FOLDER}/so_far",
        scores=hidden_scores,
        settings=settings("hidden_effects"),
    script:
        "../scripts/hidden/so_far.py"

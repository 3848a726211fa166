"""What the README and docs/ quote, copied from the results: `snakemake --cores 2 publish`, on request only."""

PUBLISHED = [
    "results/claims.md",
    "results/table_1.md",
    *[figure.replace(".pdf", ".png") for figure in FIGURES],
    *(POOL[:1] if HAS_POOL else []),
    "results/figures/story.png",
    "results/figures/points_needed.png",
]


rule publish:
    input:
        named=PUBLISHED,
        loop="results/closed_loop/summary.md",
    output:
        [f"docs/results/{Path(path).name}" for path in PUBLISHED],
        "docs/results/closed_loop.md",
    log:
        "results/logs/publish.log",
    benchmark:
        "results/benchmarks/publish.tsv"
    shell:
        "(cp {input.named} docs/results/ && cp {input.loop} docs/results/closed_loop.md) 2> {log}"


# Of a run on plants that no setting has seen, config/studies/unseen.yaml.
rule publish_unseen:
    input:
        claims="results/claims.md",
        figure="results/figures/figure_4.png",
    output:
        claims="docs/results/claims_unseen.md",
        figure="docs/results/figure_4_unseen.png",
    log:
        "results/logs/publish_unseen.log",
    benchmark:
        "results/benchmarks/publish_unseen.tsv"
    shell:
        "(cp {input.claims} {output.claims} && cp {input.figure} {output.figure}) 2> {log}"


rule publish_hindsight:
    input:
        markdown="results/hindsight.md",
    output:
        markdown=f"docs/results/hindsight_base_seed_{CONFIG.base_seed}.md",
    log:
        "results/logs/publish_hindsight.log",
    benchmark:
        "results/benchmarks/publish_hindsight.tsv"
    shell:
        "cp {input.markdown} {output.markdown} 2> {log}"


rule publish_priors:
    input:
        markdown="results/priors.md",
    output:
        markdown=f"docs/results/priors_base_seed_{CONFIG.base_seed}.md",
    log:
        "results/logs/publish_priors.log",
    benchmark:
        "results/benchmarks/publish_priors.tsv"
    shell:
        "cp {input.markdown} {output.markdown} 2> {log}"


# What `hidden_effects_so_far` made, of a whole study or of a part of one.
rule publish_hidden_effects:
    input:
        markdown=f"{HIDDEN_FOLDER}/so_far/summary.md",
        tables=multiext(
            f"{HIDDEN_FOLDER}/so_far/tables/", "cases.csv", "confusion.csv", "coverage.csv", "curves.csv", "ways.csv"
        ),
        figures=f"{HIDDEN_FOLDER}/so_far/figures",
    output:
        folder=directory(f"docs/results/hidden_effects_seeds_{HIDDEN_STUDY.base_seed}"),
    log:
        "results/logs/publish_hidden_effects.log",
    benchmark:
        "results/benchmarks/publish_hidden_effects.tsv"
    shell:
        "(mkdir -p {output.folder} && cp {input.markdown} {input.tables} {input.figures}/*.png {output.folder}/) 2> {log}"


# The README's numbers to trust, from published runs on seeds that the present version had not seen, and from real flights.
rule readme_numbers:
    input:
        runs=expand("docs/results/hidden_effects_seeds_{seed}/runs.csv", seed=[57, 58, 60, 64]),
        changed="docs/results/what_changed.md",
    log:
        "results/logs/readme_numbers.log",
    benchmark:
        "results/benchmarks/readme_numbers.tsv"
    params:
        code=code("hidden.trusted"),
    script:
        "../scripts/hidden/readme_numbers.py"

"""What the README and docs/ quote, copied from the results: `snakemake --cores 2 publish`, on request only."""


rule publish:
    input:
        claims="results/claims.md",
        table_1="results/table_1.md",
        figures=[figure.replace(".pdf", ".png") for figure in FIGURES],
        pool=POOL[0] if HAS_POOL else [],
        story="results/figures/story.png",
        points="results/figures/points_needed.png",
        loop="results/closed_loop/summary.md",
    output:
        folder=directory("docs/results"),
    log:
        "results/logs/publish.log",
    benchmark:
        "results/benchmarks/publish.tsv"
    threads: 1
    resources:
        mem_mb=100,
    shell:
        "(mkdir -p {output.folder} && cp {input.loop} {output.folder}/closed_loop.md"
        " && cp {input.claims} {input.table_1} {input.figures} {input.pool} {input.story} {input.points} {output.folder}/)"
        " 2> {log}"


rule publish_hidden_effects:
    input:
        markdown=rules.hidden_summary.output.markdown,
        tables=rules.hidden_summary.output.tables,
        figures=rules.hidden_summary.output.figures,
    output:
        folder=directory("docs/results/hidden_effects"),
    log:
        "results/logs/publish_hidden_effects.log",
    benchmark:
        "results/benchmarks/publish_hidden_effects.tsv"
    threads: 1
    resources:
        mem_mb=100,
    shell:
        "(mkdir -p {output.folder} && cp {input.markdown} {input.figures}/*.png {output.folder}/"
        " && cd {input.tables} && cp cases.csv confusion.csv coverage.csv curves.csv ways.csv $OLDPWD/{output.folder}/) 2> {log}"

"""What the README and docs/ quote, copied from the results: `snakemake --cores 2 publish`, on request only."""


rule publish:
    input:
        claims="results/claims.md",
        table_1="results/table_1.md",
        figures=[figure.replace(".pdf", ".png") for figure in FIGURES],
        pool=POOL[0] if HAS_POOL else [],
        story="results/figures/story.png",
        points="results/figures/points_needed.png",
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
        "mkdir -p {output.folder} && cp {input} {output.folder}/ 2> {log}"

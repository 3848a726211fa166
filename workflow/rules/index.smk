"""One page over all results that are there: `snakemake --cores 2 index`. It makes none of them."""


# Results are no inputs: the page shows them as they are, whatever else the present configuration would make.
rule index:
    log:
        "results/logs/index.log",
    params:
        page="results/index.html",
        entries=entries_there,
        recordings=recordings_there,
        points=CONFIG.prior_points + LARGEST,
    script:
        "../scripts/index.py"

"""One page over all results: `snakemake --cores 2 index`. Studies that were not run are left out of it."""


rule index:
    input:
        shown=[path for _, _, path, _ in SHOWN_THERE],
        recordings=every_run([recording(flight) for flight in recorded()]),
        captions=sorted({entry["caption"] for entry in entries(SHOWN_THERE)}),
    output:
        page="results/index.html",
    log:
        "results/logs/index.log",
    benchmark:
        "results/benchmarks/index.tsv"
    threads: 1
    resources:
        mem_mb=300,
    params:
        code=fingerprint("infotraj.report.results_index"),
        look=sha256(Path(report_room.__file__).parent / "assets/index.html"),
        entries=entries(SHOWN_THERE),
        points=CONFIG.prior_points + LARGEST,
    script:
        "../scripts/index.py"

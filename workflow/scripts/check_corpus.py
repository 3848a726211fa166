"""How often `check` errs over the corpus, by source: numbers, tables, figure."""

from infotraj.experiment.check_corpus import measure, write
from infotraj.experiment.job import job
from infotraj.plots.check_corpus import errors_of_check

with job(snakemake.log[0], snakemake.params.settings) as settings:
    result = measure(settings.check_corpus, settings.data_dir, snakemake.threads)
    write(result, snakemake.output.numbers, snakemake.output.table)
    errors_of_check(result["sources"], snakemake.output.pdf, snakemake.output.png)

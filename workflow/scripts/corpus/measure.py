"""How often `check` errs over the corpus, by source: numbers, tables, figure."""

from infotraj.experiment.common.job import job
from infotraj.experiment.corpus.measuring import measure, write

with job(snakemake.log[0], snakemake.params.settings) as settings:
    result, out = measure(settings.check_corpus, settings.data_dir, snakemake.threads), snakemake.output
    write(result, out.numbers, out.table, out.pdf, out.png)

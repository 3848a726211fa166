# The whole experiment: `snakemake --cores 2`. Stages in workflow/rules, what they call in src/infotraj/experiment.


include: "workflow/rules/common.smk"
include: "workflow/rules/pool.smk"


rule all:
    default_target: True
    input:
        targets(),

# The whole experiment: `snakemake --cores 2`. Stages in workflow/rules, what they call in src/infotraj/experiment.


include: "workflow/rules/common.smk"
include: "workflow/rules/runs.smk"
include: "workflow/rules/prior.smk"
include: "workflow/rules/execution.smk"
include: "workflow/rules/candidates.smk"
include: "workflow/rules/learning.smk"
include: "workflow/rules/evaluation.smk"
include: "workflow/rules/correlation.smk"
include: "workflow/rules/hindsight.smk"
include: "workflow/rules/priors.smk"
include: "workflow/rules/pool.smk"
include: "workflow/rules/real_names.smk"
include: "workflow/rules/real_flights.smk"
include: "workflow/rules/real_table_names.smk"
include: "workflow/rules/real_table.smk"
include: "workflow/rules/what_changed.smk"
include: "workflow/rules/changes.smk"
include: "workflow/rules/separating.smk"
include: "workflow/rules/iterated.smk"
include: "workflow/rules/hidden_names.smk"
include: "workflow/rules/hidden_effects.smk"
include: "workflow/rules/closed_loop.smk"
include: "workflow/rules/examples.smk"
include: "workflow/rules/check_corpus.smk"
include: "workflow/rules/recordings.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/publish.smk"
include: "workflow/rules/index_names.smk"
include: "workflow/rules/index.smk"


rule all:
    default_target: True
    input:
        results(),
        hidden_results() if CONFIG.hidden_effects.with_all else [],
        rules.closed_loop.input if CONFIG.closed_loop.with_all else [],


onstart:
    forget_awaited()


onerror:
    awaited()

"""The names of what is made from real flights, and which of it is wanted."""

from infotraj.experiment.real.flights import DATA_SETS
from infotraj.experiment.real.windows import chosen, logs

REAL = "results/real_flights/{dataset}"
REAL_LOG = "results/logs/real_flights/{dataset}"
REAL_BENCHMARK = "results/benchmarks/real_flights/{dataset}"
REAL_DIAGNOSIS = "results/real_flights/{dataset}/diagnosis"


def real_present():
    """The data sets that are here; the others are named on standard error."""
    present = [name for name in DATA_SETS if location.find_dataset(name, CONFIG.data_dir)]
    for name in DATA_SETS:
        if name not in present:
            print(f"Skipped: {location.how_to_get(name)}", file=sys.stderr)
    return present


def real_models(dataset):
    """Names of the models that a data set's flights are compared with."""
    return [Path(path).stem for path in DATA_SETS[dataset].models]


def real_model_files(wildcards):
    """All files below config that the data set's models are made of."""
    return [str(path) for folder in ("models", "vehicles") for path in sorted(Path("config", folder).glob("*.yaml"))]


def real_logs(wildcards):
    """Name and size of the logs that are diagnosed: others rerun what reads them."""
    folder = location.find_dataset(wildcards.dataset, CONFIG.data_dir)
    named = checked(logs, CONFIG, wildcards.dataset, folder) if folder else {}
    return [(p.name, p.stat().st_size) for p in named.values()]


def real_diagnoses(what, part=None):
    """That file of the diagnosis of each data set that is here; only of those whose configuration has `part`."""
    with_it = [name for name in DATA_SETS if part is None or getattr(chosen(CONFIG, name), part)]
    present = [name for name in with_it if location.find_dataset(name, CONFIG.data_dir)]
    return [f"{REAL_DIAGNOSIS.format(dataset=name)}/{what}" for name in present]


def real_results(_):
    """Everything that the target makes."""
    present = real_present()
    wanted = [f"results/real_flights/{name}/comparison.json" for name in present]
    wanted += [f"results/real_flights/{name}/{model}/places.json" for name in present for model in real_models(name)]
    summaries = ["results/real_flights/summary.md", "results/real_flights/diagnosis.md"]
    return wanted + (summaries if present else [])

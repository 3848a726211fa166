"""The names of what is made from real flights, and which of it is wanted."""

from infotraj.experiment.real_flights import DATA_SETS

REAL = "results/real_flights/{dataset}"
REAL_LOG = "results/logs/real_flights/{dataset}"
REAL_BENCHMARK = "results/benchmarks/real_flights/{dataset}"


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


def real_results(_):
    """Everything that the target makes."""
    present = real_present()
    wanted = [f"results/real_flights/{name}/comparison.json" for name in present]
    wanted += [f"results/real_flights/{name}/{model}/places.json" for name in present for model in real_models(name)]
    return wanted + (["results/real_flights/summary.md"] if present else [])

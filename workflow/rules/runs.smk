"""The names of runs, flights and models, and which of them are wanted."""

from infotraj.experiment.paper.delivery import delivered

OWN_VEHICLE = CONFIG.execution == "log"
PLANTS = ["own"] if OWN_VEHICLE else list(CONFIG.plants)
SEEDS = list(range(CONFIG.seeds))
ROUNDS = list(range(1, CONFIG.iterations + 1))
# Who chooses the flight that is learned from: nobody (the task again), chance, the paper's cost word for word, ours. A
# vehicle of your own flies no controls.
SOURCES = ["task", "informative"] if OWN_VEHICLE else ["task", "random", "paper", "informative"]
TASK, MODIFIED, PITCH = (f"results/references/{name}.csv" for name in ("task", "modified", "pitch"))

# One run of the experiment: one plant, one seed; and one round of it: choose, fly, learn.
RUN = "results/{plant}/seed{seed}"
ROUND = f"{RUN}/round{{round}}"
RUN_LOG = "results/logs/{plant}/seed{seed}"
RUN_BENCHMARK = "results/benchmarks/{plant}/seed{seed}"

LARGEST = max(CONFIG.added_points)
PRIOR = f"prior_{CONFIG.prior_points}"

# REFERENCE/MODEL of the validation flights: before any round, and of each round (the largest models also fly the
# modified task). Files carry the points added in their round, tables the points in all.
START = ["task/none", "modified/none", f"task/{PRIOR}"]
MODELS = [f"{source}_plus{added}" for source in SOURCES for added in CONFIG.added_points]
POOL = ["results/pool/summary.md", "results/figures/figure_pool.pdf"]
HAS_POOL = location.find_dataset("nanobench", CONFIG.data_dir) is not None
# The run whose flights Fig. 3 and 5 show: the first plant and seed, fixed before any was looked at.
SHOWN = f"results/{PLANTS[0]}/seed{SEEDS[0]}/round1"
FIGURES = [f"results/figures/figure_{number}.pdf" for number in (2, 3, 4, 5)]
VALIDATED = [f"task/{model}" for model in MODELS] + [f"modified/{source}_plus{LARGEST}" for source in SOURCES]


wildcard_constraints:
    plant=r"[A-Za-z0-9_-]+",
    seed=r"\d+",
    round=r"[1-9]\d*",
    source="|".join(SOURCES),
    flight=r"prior|test|(" + "|".join(SOURCES) + r")_[1-9]\d*",


def plant_file(wildcards):
    """The truth of the plant, beside the vehicle's folder."""
    return str(plant_path(CONFIG.vehicle, wildcards.plant))


def flight(name):
    """The flight table of a run: flown by the plant or put there by you, as `execution` says."""
    return branch(
        lookup(dpath="execution", within=config),
        cases={
            "plant": f"{RUN}/flown/{name}.parquet",
            "log": f"{RUN}/received/{name}.parquet",
            "pool": f"{RUN}/flown/{name}.parquet",  # never asked for: the pool has a chain of its own
        },
    )


def start_model(run, source, round):
    """The model that a round starts from, for what it learns from `source` (eq. 6, 7)."""
    before = int(round) - 1
    return f"{run}/round{before}/models/{source}_plus{LARGEST}.npz" if before else f"{run}/prior.npz"


def every_run(pattern, **more):
    """A pattern of a run, for all plants and seeds."""
    return expand(pattern, plant=PLANTS, seed=SEEDS, **more)


def flown_reference(wildcards):
    """The task, or the reference that was chosen for the flight's round."""
    source, _, round = wildcards.flight.partition("_")
    return TASK if source in ("prior", "test", "task") else f"{RUN}/round{round}/{source}.csv"


def flown_model(wildcards):
    """The model in the controller: none for the prior flight, else the one that the round starts from."""
    if wildcards.flight == "prior":
        return []
    source, _, round = wildcards.flight.partition("_")
    return start_model(RUN, source, round or 1)


def recorded():
    """What is recorded of a run, {flight table: model whose residual is shown along it}."""
    folder = "received" if OWN_VEHICLE else "flown"
    shown = {f"{RUN}/{folder}/{name}.parquet": f"{RUN}/prior.npz" for name in ("prior", "test")}
    for round in ROUNDS:
        for source in SOURCES:
            shown[f"{RUN}/{folder}/{source}_{round}.parquet"] = start_model(RUN, source, round)
        one = f"{RUN}/round{round}"
        shown[f"{one}/rollout.parquet"] = start_model(RUN, "informative", round)
    if not OWN_VEHICLE:
        shown |= {f"{RUN}/validation/{key}.parquet": f"{RUN}/prior.npz" for key in START}
        for round in ROUNDS:
            one = f"{RUN}/round{round}"
            shown |= {f"{one}/validation/{k}.parquet": f"{one}/models/{k.partition('/')[2]}.npz" for k in VALIDATED}
    return shown


def recording(flight):
    """The recording of a flight table, in a folder of its own."""
    return flight.replace("results/", "results/recordings/").replace(".parquet", ".rrd")


def in_all(name, round):
    """The name of a model or flight with the points in all, as the tables split it: task_plus20 is task_40."""
    if "_plus" not in name:
        return name
    head, added = name.rsplit("_plus", 1)
    return f"{head}_{CONFIG.prior_points + (int(round) - 1) * LARGEST + int(added)}"


def results():
    """What is made when nothing else is asked for; what needs absent data is left out with a line."""
    if CONFIG.execution == "pool":
        if not HAS_POOL:
            print(location.how_to_get("nanobench"), file=sys.stderr)
            sys.exit(1)
        return POOL
    wanted = ["results/prediction.csv", *every_run(f"{RUN}/round{{round}}/figure_costs.pdf", round=ROUNDS)]
    wanted += every_run([recording(flight) for flight in recorded()])
    if not OWN_VEHICLE:
        wanted += [*FIGURES, "results/table_1.md", "results/claims.md"]
    if HAS_POOL:
        wanted += POOL
    else:
        print(f"Skipped: {location.how_to_get('nanobench')}", file=sys.stderr)
    return wanted


AWAITED = "results/logs/own/seed*/receive/*.log"


def forget_awaited():
    """Removes what earlier runs said of flights that they waited for: a run repeats its own words alone."""
    for log in Path().glob(AWAITED):
        log.unlink()


def awaited():
    """Prints the references that wait for a flight, once more and below each other, when a run stops for them."""
    for log in sorted(Path().glob(AWAITED)) if OWN_VEHICLE else ():
        flight = Path(f"results/own/{log.parts[3]}/received/{log.stem}.parquet")
        if log.read_text() and not flight.exists():
            print(f"Waiting: {log.read_text().strip()}", file=sys.stderr)

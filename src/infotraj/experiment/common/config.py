"""The experiment's configuration: typed, closed to unknown keys, with units and defaults in one place.

`config/config.yaml` and `workflow/schemas/config.schema.json` are written from this module.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import AfterValidator, Field, ValidationError, model_validator

from infotraj.control.gains import Gains
from infotraj.errors import UsageError, problem
from infotraj.experiment.common.strict_yaml import Strict, content_of
from infotraj.vehicle import NUMBER, NotNegative, Positive, validation_line

T = TypeVar("T")


def _named_once(values: tuple[T, ...]) -> tuple[T, ...]:
    if twice := [value for value in values if values.count(value) > 1]:
        raise ValueError(f"{twice[0]} is named twice; name it once")
    return values


def _one_folder(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9_-]+", name):
        raise ValueError("a name of letters, digits, _ and - is expected, without a folder or an ending")
    return name


Count = Annotated[int, Field(ge=1), NUMBER]
Number = Annotated[int, Field(ge=0), NUMBER]
Name = Annotated[str, AfterValidator(_one_folder)]  # it becomes a part of paths
Distinct = Annotated[tuple[T, ...], Field(min_length=1), AfterValidator(_named_once)]


class FigureEight(Strict):
    """A figure of eight in attitude at a fixed position."""

    amplitude_deg: Positive = Field(26.0, description="greatest roll and pitch, deg")
    period: Positive = Field(9.0, description="s for one roll and two pitch cycles")
    cycles: Count = Field(2, description="how often the figure is flown")


class Pitch(Strict):
    """The pitching task of Fig. 2."""

    amplitude_deg: Positive = Field(60.0, description="greatest pitch, deg")
    peak_acceleration: Positive = Field(1.0, description="greatest pitch acceleration, rad/s^2")
    cycles: Count = Field(3, description="how often it swings")


class Deviations(Strict):
    """The set that deviations are sampled from (eq. 17), in the vehicle's limits."""

    max_acceleration: Positive = Field(5.0, description="greatest amplitude of a term, rad/s^2")
    min_frequency: Positive = Field(0.1, description="Hz")
    max_frequency: Positive = Field(2.0, description="Hz, the paper's bound")
    max_angle_deg: Positive = Field(25.0, description="greatest deviation an axis, deg")
    max_jerk: Annotated[float, Field(gt=0), NUMBER] = Field(
        8.0, description="greatest rate of the deviation's angular acceleration an axis, rad/s^3 (inf: no limit)"
    )
    terms: Count = Field(2, description="P of eq. 17")

    @model_validator(mode="after")
    def _ordered(self) -> Deviations:
        if self.min_frequency > self.max_frequency:
            raise ValueError(
                f"min_frequency {self.min_frequency:g} Hz is above max_frequency {self.max_frequency:g} Hz; "
                "lower the one or raise the other"
            )
        return self


class Learning(Strict):
    """How a Gaussian process is learned from a flight."""

    window: Positive = Field(0.15, description="s, window of the rate's slope and of the same mean over commands")
    response_of_model: bool = Field(
        True, description="commands pass the declared actuator lags before they are compared with what was achieved"
    )
    ard: bool = Field(True, description="one lengthscale an input, else one for all")
    lengthscale_prior: bool = Field(True, description="log-normal prior on lengthscales: 20 points do not fix six")
    input_scale: tuple[Positive, Positive, Positive, Positive, Positive, Positive] | None = Field(
        (5.0, 5.0, 5.0, 3.0, 3.0, 3.0),
        description="spread that the prior expects of the inputs, m/s^2 and rad/s^2 (half the weight; what attitude "
        "control asks for); null: the spread of the data, which misjudges an input that the flight hardly moved",
    )
    restarts: Number = Field(1, description="further starts of the hyperparameter search")
    prior: Literal["none", "physics"] = Field(
        "none",
        description="what is known before any flight; physics: the catalogue's effects in their usual sizes, as "
        "functions of the wrench, with a small process for the rest",
    )


class Cost(Strict):
    """What the informative cost is made of (eq. 13 to 15)."""

    kernel: Literal["fixed", "fitted"] = Field(
        "fixed",
        description="fixed: one lengthscale for all inputs, signal variance 1 (rad/s^2)^2; fitted: the prior model's",
    )
    lengthscale: Positive = Field(1.0, description="of the fixed kernel, m/s^2 and rad/s^2")
    noise: Positive = Field(0.1, description="of the fixed kernel, rad/s^2")
    region: Literal["visited", "uniform"] = Field(
        "visited", description="visited: the inputs of the simulated task; uniform: all within epsilon of them (eq. 15)"
    )
    epsilon: Positive | None = Field(None, description="m/s^2 and rad/s^2; null: from simulation, as in Sec. V-A")
    subset: Literal["farthest", "medoids"] = Field(
        "farthest", description="points of a candidate that count: farthest-first traversal, or k-medoids"
    )
    points: Count | None = Field(40, description="how many; null: as many as are learned")


LITERAL = Cost(kernel="fitted", region="uniform", subset="medoids", points=None)


class Selection(Strict):
    """How candidates are simulated and scored (eq. 12 to 18)."""

    candidates: Count = Field(20, description="candidate references")
    draws: Count = Field(10, description="draws of the residual a candidate")
    region_points: Count = Field(1000, description="points of the region")
    task_draws: Count = Field(10, description="simulations of the task that span the region (M of eq. 14)")
    estimate_noise: tuple[NotNegative, NotNegative, NotNegative, NotNegative] = Field(
        (0.001, 0.002, 0.01, 0.01), description="white error of the simulated estimate: m, rad, m/s, rad/s"
    )
    cost: Cost = Field(Cost(), description="what chooses the informative flight")
    paper: Cost = Field(LITERAL, description="the paper's cost word for word: chooses in the arm `paper`")


class Correlation(Strict):
    """Fig. 2: does the cost predict the error?"""

    candidates: Count = Field(30, description="candidates flown, learned and evaluated, besides the task itself")
    points: Count = Field(40, description="points learned from each")


class Hindsight(Strict):
    """Which costs are held against the errors of all candidates."""

    costs: Distinct[Literal["configured", "kernel", "no process", "affine", "effects", "propagated"]] = Field(
        ("configured", "kernel", "no process", "affine", "effects", "propagated"),
        description="groups of costs; the last two take longer than all others together",
    )


class Pool(Strict):
    """The scenario on recorded real flights."""

    seeds: Count = Field(5, description="repetitions of the subsets and the hyperparameter search")


class HiddenEffects(Strict):
    """The hidden-effect study: does the diagnosis name what is hidden?"""

    study: str = Field("config/studies/hidden_effects.yaml", description="what is hidden, and how often")
    only: tuple[str, ...] = Field((), description="patterns of case names, such as omav/single/*; none: all cases")
    seeds: Count | None = Field(None, description="at most so many runs a case; null: as many as the study says")
    with_all: bool = Field(
        False, description="whether the default target makes the study too, not only `hidden_effects`"
    )


class ClosedLoop(Strict):
    """Flights with a hidden effect, flown again with what the diagnosis named."""

    folder: str = Field("config/closed_loop", description="a folder a case: truth.yaml and oracle.yaml")
    cases: Distinct[Name] = Field(
        ("com_offset", "rotor_effectiveness", "linear_drag", "com_offset_and_linear_drag"),
        description="hidden effects, folders of `folder`",
    )
    wrong: dict[str, tuple[str, ...]] = Field(
        {
            "com_offset": ("steady_torque", "rotor_effectiveness:5"),
            "rotor_effectiveness": ("thrust_scale", "com_offset"),
            "linear_drag": ("steady_force", "axial_inflow"),
            "com_offset_and_linear_drag": ("steady_torque+steady_force", "mass_offset+inertia_error"),
        },
        description="wrong names a case, each fitted to the same flights; + joins names that are fitted together",
    )
    shown: str = Field("com_offset_and_linear_drag", description="the case of the story's figure (its first seed)")
    seeds: Count = Field(10, description="repetitions: references and noise")
    fit_flights: Count = Field(3, description="flights with the nominal model, to diagnose and to learn from")
    fit_duration: Positive = Field(10.0, description="s")
    test_duration: Positive = Field(16.0, description="s, the reference that every controller flies")
    place: Positive = Field(1.6, description="m, size of the motion in place")
    tempo: Positive = Field(0.5, description="of the motion in place: slow, so that the actuators' lags cost little")
    angle_deg: Positive = Field(25.0, description="deg, size of roll and pitch")
    points: Distinct[Count] = Field((10, 40), description="points of the Gaussian process, flown")
    curve: Distinct[Count] = Field((5, 10, 20, 40, 80), description="points, learned and not flown")
    curve_seeds: Count = Field(3, description="seeds of that curve")
    with_all: bool = Field(False, description="whether the default target flies it too, not only `closed_loop`")

    @model_validator(mode="after")
    def _shown_is_flown(self) -> ClosedLoop:
        if self.shown not in self.cases:
            raise ValueError(f"shown is {self.shown}, which is none of cases; show one of {', '.join(self.cases)}")
        return self


class RealDiagnosis(Strict):
    """What is diagnosed in the flights of a public data set."""

    model: str = Field(description="model or vehicle file, below config")
    fit: tuple[str, ...] = Field(min_length=1, description="logs that the diagnosis is given")
    held_out: tuple[str, ...] = Field((), description="other logs, on which its model is tested; none: no test")
    windows: dict[str, tuple[float, float]] = Field({}, description="s, from and to; a log without it is used whole")
    add: tuple[str, ...] = Field((), description="effects to add by name, each alone; + joins those fitted together")

    @property
    def flights(self) -> tuple[str, ...]:
        """All logs that are used."""
        return (*self.fit, *self.held_out)

    @model_validator(mode="after")
    def _consistent(self) -> RealDiagnosis:
        if twice := [name for name in self.held_out if name in self.fit]:
            raise ValueError(f"{twice[0]} is fitted and held out")
        for name, (start, stop) in self.windows.items():
            if not start < stop:
                raise ValueError(f"the window of {name} ends before it starts")
        return self


class RealFlights(Strict):
    """Which public real flights `diagnose` and `add` are shown on, and with which model."""

    nanobench: RealDiagnosis = RealDiagnosis(
        model="vehicles/nanobench_uncalibrated.yaml",
        fit=(
            "B3_figure8_fast_rep1",
            "B5_helix_medium_rep1",
            "B6_linear_ramp_rep2",
            "B8_star_fast_rep1",
            "B10_lissajous_fast_rep1",
        ),
        held_out=(
            "B2_circle_fast_rep1",
            "B5_helix_fast_rep1",
            "B7_oval_fast_rep2",
            "B9_trefoil_fast_rep1",
            "B8_star_medium_rep1",
        ),
    )
    arpl_crazyflie: RealDiagnosis = RealDiagnosis(
        model="vehicles/crazyflie_arpl_nominal.yaml",
        fit=("log10", "log15"),
        windows={"log10": (35.0, 65.0), "log15": (55.0, 90.0)},
        add=("inertia_error", "rotor_lag", "rotor_lag+inertia_error"),
    )


class RealTable(Strict):
    """The table of real flights of known vehicles: known, answered, not answerable."""

    cases: str = Field("config/studies/real_table.yaml", description="flights, vehicles, and what is known of them")
    only: tuple[str, ...] = Field((), description="patterns of case names, such as acsl_*; none: all cases")


class CheckCorpus(Strict):
    """How `check` is measured: flights of many kinds of logs, and known errors put into some of them."""

    real: str = Field(
        "config/studies/check_corpus.yaml", description="the data sets of real flights, and what is right in them"
    )
    base_seed: Number = Field(
        3, description="of the simulated flights; 0 to 2 were looked at while finding settings, 3 is for reporting"
    )
    flights: Count = Field(18, description="simulated flights a source")
    spoiled: Number = Field(3, description="of these, how many get every error put in")

    @model_validator(mode="after")
    def _spoils_what_flies(self) -> CheckCorpus:
        if self.spoiled > self.flights:
            raise ValueError(f"spoiled {self.spoiled} of only {self.flights} flights; lower spoiled or raise flights")
        return self


class ExperimentConfig(Strict):
    """Everything that the workflow's rules read."""

    vehicle: str = Field("config/vehicles/omav.yaml", description="vehicle file: what is believed")
    plants: Distinct[Name] = Field(
        ("omav_a", "omav_b", "omav_c"), description="plants in config/plants, each flown by all seeds"
    )
    seeds: Count = Field(10, description="repetitions on each plant; a seed varies noise, draws and candidates")
    base_seed: Number = Field(0, description="from which every seed is derived")
    execution: Literal["plant", "log", "pool"] = Field(
        "plant", description="who flies: the MuJoCo plant; you (log); pool: recorded real flights alone, none is flown"
    )
    flights: str = Field("flights", description="with `execution: log`, the folder where flight tables are put")
    iterations: Count = Field(1, description="how often an informative flight is chosen, flown and learned")
    sample_time: Positive = Field(0.01, description="s, period of the controller and of references")
    prior_points: Count = Field(20, description="points of the prior model")
    added_points: Distinct[Count] = Field((20, 40, 60, 80), description="points added, Fig. 4")
    task: FigureEight = FigureEight()
    modified: FigureEight = FigureEight(amplitude_deg=43.0)
    pitch: Pitch = Pitch()
    deviations: Deviations = Deviations()
    learning: Learning = Learning()
    selection: Selection = Selection()
    correlation: Correlation = Correlation()
    hindsight: Hindsight = Hindsight()
    gains: Gains = Gains()
    data_dir: str | None = Field(None, description="folder of the real flights where INFOTRAJ_DATA is not set")
    pool: Pool = Pool()
    real_flights: RealFlights = RealFlights()
    real_table: RealTable = RealTable()
    hidden_effects: HiddenEffects = HiddenEffects()
    closed_loop: ClosedLoop = ClosedLoop()
    check_corpus: CheckCorpus = CheckCorpus()


def load(content: Mapping[str, object] | None, source: str = "config") -> ExperimentConfig:
    """A configuration from the content of its file. UsageError, one line, for a key that does not exist."""
    if not isinstance(content, Mapping):
        raise UsageError(problem(f"{source}: no mapping", "the keys of config/config.yaml", "Correct the file."))
    try:
        return ExperimentConfig.model_validate(dict(content))
    except ValidationError as error:
        raise UsageError(f"{source}: {validation_line(error, ExperimentConfig)}") from error


def read(path: str | Path) -> ExperimentConfig:
    """Reads a configuration file (YAML). UsageError, one line, where it cannot be used."""
    return load(content_of(path), str(path))

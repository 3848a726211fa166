"""The hidden-effect study's configuration (config/studies/hidden_effects.yaml): what is hidden, where, how often."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError

from infotraj.errors import UsageError, problem
from infotraj.experiment.common.strict_yaml import Strict, content_of
from infotraj.experiment.hidden.file_profiles import LEVELS
from infotraj.experiment.hidden.logs import LOGS
from infotraj.vehicle import Positive, validation_line

Count = Annotated[int, Field(ge=0)]
Values = dict[str, Any]
Logging = Literal["full", "mocap", "no_tilts", "50hz"]


def _known(names: Collection[str]) -> AfterValidator:
    def check(value: str) -> str:
        if value not in names:
            raise ValueError(f"one of {', '.join(names)}")
        return value

    return AfterValidator(check)


def _rising(sizes: tuple[float, float]) -> tuple[float, float]:
    if sizes[0] > sizes[1]:
        raise ValueError("the least size comes first, then the most")
    return sizes


Sizes = Annotated[tuple[Positive, Positive], AfterValidator(_rising)]
WrongFile = Annotated[str, _known([level for level in LEVELS if level != "exact"])]
RoughLog = Annotated[str, _known([log for log in LOGS if log != "clean"])]


class Flights(Strict):
    """The references of one vehicle (kinds of `infotraj.trajectories.standard`) and how far they go."""

    train: tuple[str, ...] = Field(min_length=1, description="given to the diagnosis")
    held_out: tuple[str, ...] = Field(min_length=1, description="for the scorer alone")
    seconds: Positive = Field(16.0, description="s, each")
    size: Positive = Field(0.9, description="m, of the paths")
    pace: Positive = Field(1.0, description="multiple of the usual speed")
    low: Positive = Field(0.25, description="m, lowest height")
    tilt: float = Field(0.35, ge=0, description="rad; 0: attitude follows from the acceleration")
    speed: Positive = Field(6.0, description="m/s, of the fast paths")
    faster: Positive = Field(1.0, description="how many times as fast and as wide the held-out fast paths are")
    gains: Literal["calm", "agile"] = Field("calm", description="of the thrust-vector controller")


class Clutter(Strict):
    """What makes every individual a little different, and the air turbulent."""

    rotors: float = Field(0.01, description="standard deviation of a rotor's thrust, share")
    inertia: float = Field(0.02, description="share by which each axis is off")
    center_of_mass: float = Field(0.0004, description="m")
    force: float = Field(0.003, description="of turbulence, standard deviation, share of the weight")
    torque: float = Field(0.001, description="the same, share of the weight times the rotors' mean distance")
    correlation_time: Positive = Field(0.5, description="s, of the turbulence")


class Gusts(Strict):
    """Dryden's gusts (`robots/plant/dryden.py`) in which some runs fly."""

    speed: Positive = Field(5.0, description="m/s, of the mean wind 6 m above the ground: a fresh day")
    height: Positive = Field(6.0, description="m above the ground")
    drag: float = Field(
        0.3, ge=0, description="1/s, times the mass: by which gusts push; small quadrotors have 0.2 to 0.4"
    )


class Effect(Strict):
    """One effect at its usual size. Sizes multiply the change from the value that leaves the model as it was."""

    parameters: Values
    sizes: tuple[float, float, float] = Field((0.25, 1.0, 2.0), description="small, usual, large")
    voltage: float | None = Field(None, description="V: the vehicle file gets this nominal_voltage")
    alone: bool = Field(True, description="false: it acts beside others only, so it is hidden in pairs and triples")


class Nearest(Strict):
    """Physics beyond the catalogue, and the names of the catalogue that come nearest."""

    parameters: Values
    nearest: tuple[str, ...] = ()
    voltage: float | None = None


class VehicleStudy(Strict):
    """What is hidden on one vehicle."""

    file: str
    flights: Flights
    gentle: Flights | None = Field(None, description="instead, where a load swings: its motion stays predictable")
    effects: dict[str, Effect] = Field({})
    cannot_show: dict[str, Values] = Field({}, description="carried, and without any trace: not to be named")
    pairs: tuple[tuple[str, str], ...] = ()
    triples: tuple[tuple[str, str, str], ...] = ()
    richer: dict[str, Nearest] = Field({})
    unlisted: dict[str, Values] = Field({})

    @property
    def voltage(self) -> float | None:
        """V, nominal: of the first effect that needs one."""
        return next((e.voltage for e in self.effects.values() if e.voltage), None)


class Curves(Strict):
    """Where it ends: found rate against one thing at a time, for some effects at usual size."""

    effects: dict[str, tuple[str, ...]] = Field({}, description="by vehicle")
    sizes: tuple[float, ...] = ()
    seconds: tuple[float, ...] = ()
    noise: tuple[float, ...] = Field((), description="multiples of the usual noise of all sensors")
    logging: tuple[Logging, ...] = ()


class Circumstances(Strict):
    """What is done to the vehicle file and to the log, one at a time; hidden physics and paths stay the same."""

    files: tuple[WrongFile, ...] = Field((), description="how wrong the file is: `file_profiles`")
    logs: tuple[RoughLog, ...] = Field((), description="how the flight is logged: `hidden_logs`")


class Runs(Strict):
    """How many seeds each kind of case gets. clutter: how many of the further seeds fly with clutter."""

    single: Count = 10
    single_clutter: Count = 10
    other_size: Count = 10
    nothing: Count = 75
    nothing_clutter: Count = 75
    nothing_voltage: Count = Field(10, description="the log holds a sagging voltage that the thrust does not follow")
    several: Count = Field(5, description="pairs and triples")
    several_clutter: Count = 5
    cannot_show: Count = 5
    richer: Count = 10
    unlisted: Count = 10
    curve: Count = 5
    nothing_file: Count = Field(
        0, description="of each wrong file; the next seven likewise, of each file or log, in gusts"
    )
    single_file: Count = 0
    several_file: Count = 0
    nothing_gusts: Count = 0
    single_gusts: Count = 0
    nothing_log: Count = 0
    single_log: Count = 0
    several_log: Count = 0


class HiddenStudy(Strict):
    """The whole study."""

    base_seed: Count = 0
    batch: int = Field(5, ge=1, description="runs a job: loading the program takes as long as a third of a run")
    vary: float = Field(0.15, ge=0, lt=1, description="each parameter's size varies by this share from seed to seed")
    vehicles: dict[str, VehicleStudy]
    clutter: Clutter = Clutter()
    gusts: Gusts = Gusts()
    runs: Runs = Runs()
    curves: Curves = Curves()
    circumstances: Circumstances = Circumstances()


def load_study(content: Mapping[str, object], source: str) -> HiddenStudy:
    """A study from its file's content. UsageError, one line, for a key that does not exist."""
    try:
        return HiddenStudy.model_validate(dict(content))
    except ValidationError as error:
        raise UsageError(f"{source}: {validation_line(error, HiddenStudy)}") from error


def read_study(path: str | Path) -> HiddenStudy:
    """Reads a study file (YAML); `extends` names a file beside it, whose keys it replaces. UsageError, one line, where
    it cannot be used."""
    content = content_of(path)
    if not isinstance(content, dict):
        raise UsageError(
            problem(f"{path}: no mapping", "the keys of config/studies/hidden_effects.yaml", "Correct it.")
        )
    if "extends" in content:
        whole = read_study(Path(path).parent / str(content.pop("extends")))
        content = {**whole.model_dump(), **content}
    return load_study(content, str(path))

"""The vehicle file: what is believed of the vehicle, and nothing of what is hidden in it."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, get_args

import numpy as np
import yaml
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from infotraj.errors import InputError, problem, swapped, unread
from infotraj.rotations import Array

Vector = Annotated[tuple[float, float, float], Field(description="three numbers, body frame")]


def _no_switch(value: object) -> object:
    if isinstance(value, bool):
        raise ValueError("a number is expected, not true or false")
    return value


NUMBER = BeforeValidator(_no_switch)  # true is no 1
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), NUMBER]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), NUMBER]


def _unit(v: tuple[float, float, float]) -> tuple[float, float, float]:
    norm = float(np.linalg.norm(v))
    if not np.isfinite(norm) or norm == 0.0:
        raise ValueError("an axis needs a direction: three finite numbers, not all zero")
    x, y, z = (float(c) / norm for c in v)
    return x, y, z


Axis = Annotated[Vector, AfterValidator(_unit)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


_MEASURED = 0.05  # of that sum: a flat body's, each moment measured to 2 %, is beyond it once in fifty
_NEARLY_FLAT = 1.25  # times the sum of the other two: moments of a flat body, each off by ten percent, are within it


class Inertia(_Strict):
    """Inertia about the centre of mass (kg m^2), body axes.

    No body has a principal moment larger than the sum of the other two. The file of a flat vehicle whose moments are
    off by ten percent may say so: it is read, and `beyond` says by which share. What is further off is refused.
    """

    xx: Positive
    yy: Positive
    zz: Positive
    xy: float = 0.0
    xz: float = 0.0
    yz: float = 0.0

    @model_validator(mode="after")
    def _physical(self) -> Inertia:
        principal = np.linalg.eigvalsh(self.matrix())
        if principal[0] <= 0 or self.beyond > _NEARLY_FLAT - 1:
            raise ValueError(
                f"no body has the principal moments {principal.round(6).tolist()}: each must be positive and "
                "no larger than the sum of the other two"
            )
        return self

    @property
    def beyond(self) -> float:
        """Share by which the largest principal moment exceeds the sum of the other two; 0 of a body that can be."""
        principal = np.linalg.eigvalsh(self.matrix())
        excess = float(principal[2] / (principal[0] + principal[1]) - 1.0)
        return excess if excess > 1e-9 else 0.0

    @property
    def doubt(self) -> str:
        """Why no body has these moments, in words; empty where one may."""
        more = f"{100 * self.beyond:.2g} % larger than the sum of the other two, which it can at most equal"
        return f"no body has this inertia: one moment is {more}" if self.beyond > _MEASURED else ""

    def matrix(self) -> Array:
        """Inertia matrix, (3, 3), kg m^2."""
        return np.array([[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]])


class Rotor(_Strict):
    """One rotor: its thrust along `axis`, its reaction torque -spin x moment_constant x thrust along it.

    Commands are what `input` says, and follow a first-order lag in it: a speed (rad/s; the thrust is k_F w^2), a
    throttle (0..1; the thrust is a polynomial of it) or the thrust itself (N).
    """

    name: str
    position: Vector = Field(description="m, at zero tilt")
    axis: Axis = Field((0.0, 0.0, 1.0), description="thrust direction at zero tilt")
    spin: Literal[1, -1] = Field(description="+1 turns counter-clockwise seen from above")
    input: Literal["speed", "throttle", "thrust"] = "speed"
    thrust_coefficient: Positive | None = Field(None, description="k_F, N s^2/rad^2")
    thrust_polynomial: tuple[float, float, float] | None = Field(None, description="N, of the throttle")
    moment_constant: NotNegative = Field(description="torque per thrust, m")
    max_speed: Positive | None = Field(None, description="rad/s")
    time_constant: NotNegative = Field(0.0, description="s, first-order lag in the input")
    tilt: int | None = Field(None, ge=0, description="index of the tilt that turns this rotor")
    radius: Positive | None = Field(None, description="m")
    coaxial: Literal["upper", "lower"] | None = None

    @model_validator(mode="after")
    def _keys_fit_the_input(self) -> Rotor:
        if self.input == "speed" and self.thrust_coefficient is None:
            raise ValueError(f"{self.name}: a rotor with a speed input needs `thrust_coefficient`")
        if self.input == "throttle" and self.thrust_polynomial is None:
            raise ValueError(f"{self.name}: a rotor with `input: throttle` needs `thrust_polynomial`")
        if self.input != "throttle" and self.thrust_polynomial is not None:
            raise ValueError(
                f"{self.name}: `thrust_polynomial` is of a throttle, but the input is a {self.input}; remove it, or "
                f"write `input: throttle`"
            )
        if self.input == "thrust" and self.max_speed is not None and self.thrust_coefficient is None:
            raise ValueError(
                f"{self.name}: `max_speed` limits no thrust without `thrust_coefficient`; remove it, or add that"
            )
        return self

    def known_thrust_coefficient(self) -> float:
        """k_F, N s^2/rad^2. InputError where the file leaves it out."""
        if self.thrust_coefficient is None:
            raise InputError(problem(f"rotor {self.name} has no k_F", "`thrust_coefficient` in N s^2/rad^2", "Add it."))
        return self.thrust_coefficient


class Tilt(_Strict):
    """A joint that turns rotors about the line through the body's origin along `axis`, right-handed."""

    name: str
    axis: Axis = Field(description="pointing outward")
    time_constant: NotNegative = Field(0.0, description="s, first-order lag")
    max_rate: Positive = Field(float("inf"), description="rad/s")


class Drive(NamedTuple):
    """What a vehicle's wrench comes from, in words: what pushes, what turns about its axis, what follows commands."""

    force: str
    moment: str
    follows: str


OF_ROTORS = Drive("thrust of all rotors", "moment_constant of all rotors", "the rotors")
OF_WRENCH = Drive("force", "torque about thrust_axis", "the wrench")


class Vehicle(_Strict):
    """First-principles description of a multirotor. SI units, body frame x forward, y left, z up.

    What drives it are its rotors and tilts or, with `inputs: wrench`, the commanded wrench itself (N, N m, about the
    body's origin, body axes): such a file has no rotors.
    """

    name: str
    mass: Positive | None = Field(None, description="kg; left out: unknown")
    inertia: Inertia | None = Field(None, description="kg m^2; left out: unknown")
    center_of_mass: Vector = Field((0.0, 0.0, 0.0), description="m, from the body's origin")
    measured_at: Vector = Field(
        (0.0, 0.0, 0.0),
        description="m, from the body's origin: the accelerometer; without one the point whose path is logged",
    )
    gravity: Positive = 9.81
    nominal_voltage: Positive | None = Field(None, description="V, the reference of battery_sag")
    inputs: Literal["rotors", "wrench"] = "rotors"
    rotors: tuple[Rotor, ...] = ()
    tilts: tuple[Tilt, ...] = ()
    time_constant: NotNegative = Field(0.0, description="s, first-order lag of a commanded wrench")
    thrust_axis: Axis | None = Field(
        None, description="of a commanded wrench: the one direction in which all rotors push; left out: any"
    )

    @model_validator(mode="after")
    def _driven(self) -> Vehicle:
        if self.inputs == "wrench":
            if self.rotors or self.tilts:
                what = "rotors" if self.rotors else "tilts"
                raise ValueError(
                    f"`inputs: wrench` takes the commanded wrench and no {what}; remove the one or the other"
                )
            return self
        if not self.rotors:
            raise ValueError("no rotors; list them, or write `inputs: wrench` where only the commanded wrench is known")
        given = {"time_constant": self.time_constant != 0.0, "thrust_axis": self.thrust_axis is not None}
        for key in (k for k, there in given.items() if there):
            raise ValueError(f"`{key}` is of a vehicle with `inputs: wrench`; write it for each rotor, or remove it")
        return self

    @model_validator(mode="after")
    def _consistent(self) -> Vehicle:
        names = [r.name for r in self.rotors] + [t.name for t in self.tilts]
        twice = sorted({n for n in names if names.count(n) > 1})
        if twice:
            raise ValueError(f"names must differ; {twice} appear twice")
        for rotor in self.rotors:
            if rotor.tilt is not None and rotor.tilt >= len(self.tilts):
                raise ValueError(f"{rotor.name}: tilt {rotor.tilt}, but there are {len(self.tilts)} tilts")
        return self

    @property
    def drive(self) -> Drive:
        """What its wrench comes from, in words."""
        return OF_WRENCH if self.inputs == "wrench" else OF_ROTORS

    @property
    def input_time_constants(self) -> Array:
        """Declared lags (s) of what is commanded beside tilts: one a rotor, or six of the wrench."""
        if self.inputs == "wrench":
            return np.full(6, self.time_constant)
        return np.array([r.time_constant for r in self.rotors])

    def known_mass(self) -> float:
        """Mass, kg. InputError where the file leaves it out."""
        if self.mass is None:
            raise InputError(problem(f"vehicle {self.name} has no mass", "`mass` in kg", "Add it."))
        return self.mass

    def known_inertia(self) -> Inertia:
        """Inertia about the centre of mass. InputError where the file leaves it out."""
        if self.inertia is None:
            raise InputError(
                problem(f"vehicle {self.name} has no inertia", "`inertia: {xx, yy, zz}` in kg m^2", "Add it.")
            )
        return self.inertia

    def inertia_matrix(self) -> Array:
        """Inertia about the centre of mass, (3, 3), kg m^2. InputError where the file leaves it out."""
        return self.known_inertia().matrix()

    @cached_property
    def files(self) -> tuple[Path, ...]:
        """What it was read from, as far as that is known: no model that is saved takes the place of one of these."""
        return ()

    def read_from(self, *files: Path) -> Vehicle:
        """The same vehicle, of these files."""
        made = self.model_copy()
        made.__dict__["files"] = files
        return made


def load_vehicle(path: str | Path) -> Vehicle:
    """Reads a vehicle file (YAML). InputError, one line, where the file is missing, broken or inconsistent."""
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(unread(path, error, "a vehicle file")) from error
    return parse_vehicle(content, source=str(path)).read_from(path)


def parse_vehicle(content: object, source: str = "vehicle") -> Vehicle:
    """A vehicle from the content of its file. InputError, one line, naming `source`, where it is not valid."""
    if not isinstance(content, dict):
        if source.endswith(".csv"):
            raise InputError(swapped(source, "a vehicle file"))
        raise InputError(
            problem(
                f"{source}: holds {type(content).__name__}",
                "a mapping with name, mass, inertia and rotors",
                "`infotraj vehicle new` writes one.",
            )
        )
    try:
        return Vehicle.model_validate(content)
    except ValidationError as error:
        raise InputError(f"{source}: {validation_line(error, Vehicle)}") from error


def validation_line(error: ValidationError, of: type[BaseModel]) -> str:
    """The first complaints of a pydantic validation as one line: where, what, and the value found.

    of: the model that was validated, by which an unknown key is told from the nearest of the known ones.
    """
    parts = []
    complaints = [entry for entry in error.errors() if not _follows(entry)]
    for entry in complaints[:3]:
        where = ".".join(str(p) for p in entry["loc"]) or "the file"
        if entry["type"] == "extra_forbidden":
            parts.append(f"{where}: unknown key; {_instead(str(entry['loc'][-1]), _known_keys(of, entry['loc'][:-1]))}")
        else:
            found = "" if entry["type"] == "missing" else f" (found {str(entry['input'])[:60]!r})"
            parts.append(f"{where}: {_plain(entry)}{found}")
    more = len(complaints) - 3
    return "; ".join(parts) + (f"; and {more} more" if more > 0 else "")


def _follows(entry: Any) -> bool:
    """Whether a list is called short only because the members that are wrong, which are told, were left out."""
    return entry["type"] == "too_short" and len(entry["input"]) >= entry["ctx"]["min_length"]


def _plain(entry: Any) -> str:
    """What pydantic says of one value, in words of the file instead of Python's where they differ."""
    if entry["type"] in ("tuple_type", "list_type"):
        single = isinstance(entry["input"], str | int | float)
        return "a list is expected" + (f"; write [{entry['input']!r}]" if single else "")
    if entry["type"] in ("dict_type", "model_type", "named_tuple_type"):
        return "keys with values are expected"
    if entry["type"] == "too_short":
        return f"a list of at least {entry['ctx']['min_length']} is expected; name what is wanted"
    if entry["type"] == "too_long":
        return f"a list of at most {entry['ctx']['max_length']} is expected"
    return str(entry["msg"]).removeprefix("Value error, ")


def _instead(key: str, known: list[str]) -> str:
    near = get_close_matches(key, known, 1)
    if near:
        return f"did you mean {near[0]}?"
    return f"known: {', '.join(known)}" if known else "misspelt, or from another version: remove or correct it"


def _known_keys(of: Any, place: tuple[int | str, ...]) -> list[str]:
    """The keys that may stand at a place in a file; none where that is not known."""
    for step in place:
        if of is None or step not in getattr(of, "model_fields", ()):
            continue  # a place in a list, or a name that the user gave
        inside = _models(of.model_fields[str(step)].annotation)
        of = inside[0] if len(inside) == 1 else None
    known: Iterable[str] = getattr(of, "model_fields", ()) or getattr(of, "_fields", ())
    return list(known)


def _models(annotation: Any) -> list[type]:
    """The models and records (named tuples) in an annotation."""
    if isinstance(annotation, type) and (issubclass(annotation, BaseModel) or hasattr(annotation, "_fields")):
        return [annotation]
    return [m for inner in get_args(annotation) for m in _models(inner)]

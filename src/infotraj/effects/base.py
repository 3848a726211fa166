"""What an effect is: a name, parameters with units, and one hook at the place where it acts."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from infotraj.effects.channels import NO_ROTORS, missing_channel
from infotraj.effects.laws import ActuatorLaw, AirLaw, BodyLaw, ImuLaw, RotorMove
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

if TYPE_CHECKING:
    from infotraj.effects.along import Along

AXES = ("x", "y", "z")
Place = Literal["actuators", "thrust", "wrench", "rigid body", "measurement"]


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    scale: its usual size, and the step of finite differences; bounds: outside them it is not physical. size: 1 for a
    number, 3 for a vector, "tilts" for one number a tilt. index: a place in a list, chosen and never fitted. optional:
    one of several forms of the effect (see `Effect.form`). absent: the value that leaves the model as it was; None
    says that it depends on the vehicle (`Effect.absent`).
    """

    name: str
    unit: str
    scale: float
    bounds: tuple[float, float]
    absent: float | None = 0.0
    size: int | Literal["tilts"] = 1
    index: bool = False
    optional: bool = False
    meaning: str = ""

    def count(self, vehicle: Vehicle) -> int:
        """How many numbers it holds for this vehicle."""
        return len(vehicle.tilts) if self.size == "tilts" else int(self.size)


@dataclass(frozen=True)
class Load:
    """Something that hangs from the body's origin and pulls along `direction` (N, 3), body axes, unit.

    It pulls with mass x (swing - direction . f), f being the specific force (m/s^2) of the body's origin and swing
    (N,) m/s^2 the part of the load's own motion. `mass` in kg.
    """

    direction: Array
    swing: Array
    mass: float


@dataclass(frozen=True)
class Declared:
    """What an effect's numbers are in the vehicle file, or in the clocks and frames of its log, where they may be off.

    kind: of numbers that are off together; "time" and "clock" are told no better than commands are stamped. deviation:
    standard deviation in a file that is right to 1 %, in usual sizes of the effect. words: what the number is called,
    with {axis}, {place}, {rotor} and the words of `vehicle.Drive`; value: what is declared of it; alone: hardly any
    other does the same; most: of a file that is off by more percent it is no further off.
    """

    kind: str
    deviation: float
    words: str
    value: float = 0.0
    alone: bool = False
    most: float = float("inf")


class Effect(ABC):
    """A named, parametrised change of the model. Subclasses set the class variables and override hooks.

    An instance holds parameter values as attributes: `LinearDrag(d=[0.1, 0.1, 0.2])`. Parameters that are not given
    take the value in `absent`. Hooks get an `Along`: the motion and the actuators at N instants of a flight.
    """

    name: ClassVar[str]
    place: ClassVar[Place]
    parameters: ClassVar[tuple[Parameter, ...]]
    needs: ClassVar[tuple[str, ...]] = ()  # to be seen in a flight (words of `channels.missing_channel`)
    needs_to_act: ClassVar[tuple[str, ...]] = ()  # to be evaluated along a flight at all
    source: ClassVar[str] = ""
    hidden_when: ClassVar[str] = ""
    repeatable: ClassVar[bool] = False
    linear: ClassVar[bool] = False
    beside: ClassVar[tuple[str, ...]] = ()  # without any of these in the model it changes nothing; (): acts by itself
    states: ClassVar[int] = 0  # numbers of each flight's own that are found with it
    exact: ClassVar[bool] = False  # mechanics or a constant, not a formula that approximates what happens
    shifts: ClassVar[bool] = False  # of actuators: at rest they are elsewhere than their commands, not late alone
    damps_turns: ClassVar[bool] = False  # by the air's velocity at the rotors, arm by arm: where they are matters
    built: ClassVar[bool] = False  # of how a vehicle is built: it changes where parts are exchanged, not by itself
    day: ClassVar[float | None] = None  # usual sizes its numbers differ by from day to day; None: as little as most do
    balance: ClassVar[bool] = False  # of a rigid body: changes what torques a vehicle that stays level needs
    like_commands: ClassVar[bool] = False  # scales torques, or goes with rates that are fed back: as noise of inputs
    declared: ClassVar[Declared | None] = None  # its numbers are numbers of the vehicle file or of the log's clocks

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...  # its parameters, by name

    def __init__(self, **values: Any) -> None:
        known = {p.name for p in self.parameters}
        unknown = sorted(set(values) - known)
        if unknown:
            raise InputError(
                problem(f"{self.name}: unknown parameter {unknown[0]}", " or ".join(sorted(known)), "Correct the name.")
            )
        for p in self.parameters:
            value = values.get(p.name, p.absent)
            setattr(self, p.name, None if value is None else self._checked(p, value))

    def _checked(self, p: Parameter, value: Any) -> float | int | Array:
        try:
            array = np.atleast_1d(np.asarray(value, dtype=float))
        except (TypeError, ValueError):
            array = np.array([np.nan])
        if p.size == "tilts":
            good = array.ndim == 1
        elif array.size == 1 and p.size != 1 and p.absent is not None and array[0] == p.absent:
            array, good = np.full(p.size, array[0]), True
        else:
            good = array.shape == (p.size,)
        if not good or not np.isfinite(array).all():
            wanted = f"{p.size if p.size != 1 else 'one'} finite number{'' if p.size == 1 else 's'} ({p.unit})"
            raise InputError(problem(f"{self.name}: {p.name} is {value!r}", wanted, "Correct the value."))
        if p.index:
            if array[0] != int(array[0]) or array[0] < 0:
                raise InputError(problem(f"{self.name}: {p.name} is {value!r}", "a whole number from 0", "Correct it."))
            return int(array[0])
        if p.size == 1:
            return float(array[0])
        array.setflags(write=False)
        return array

    @property
    def label(self) -> str:
        """Name, and which rotor it is of: `rotor_effectiveness 3`."""
        return " ".join([self.name, *(str(int(getattr(self, p.name))) for p in self.parameters if p.index)])

    @classmethod
    def form(cls, vehicle: Vehicle, flight: Flight) -> tuple[Parameter, ...]:
        """The parameters to fit on this vehicle and flight: all that are not an index, unless overridden."""
        return tuple(p for p in cls.parameters if not p.index)

    @classmethod
    def absent(cls, vehicle: Vehicle, parameter: Parameter) -> Array:
        """The value (count,) that leaves this vehicle's model as it was."""
        if parameter.absent is None:
            raise NotImplementedError(f"{cls.name}: override `absent` for {parameter.name}")
        return np.full(parameter.count(vehicle), parameter.absent)

    @classmethod
    def starts(cls, vehicle: Vehicle, parameters: tuple[Parameter, ...]) -> list[dict[str, Any]]:
        """Values (of `parameters`) to start a fit from: one of usual size, more where one would not do."""
        return [{p.name: cls.absent(vehicle, p) + cls.scale(vehicle, p) for p in parameters}]

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float | Array, float | Array]:
        """Lowest and highest physical value on this vehicle; of a vector also one a number."""
        return parameter.bounds

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float | Array:
        """Usual size on this vehicle, as a change from the absent value; of a vector also one a number."""
        return parameter.scale

    @classmethod
    def whole(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        """The positive number of the vehicle file that the parameter adds to or multiplies; 0 where there is none.

        What a file has wrong of such a number is a factor, as likely twice too much as half.
        """
        return 0.0

    @classmethod
    def declared_deviation(cls, vehicle: Vehicle, size: float) -> float:
        """The deviation of `declared` on this vehicle, where a usual size is `size`."""
        return cls.declared.deviation if cls.declared is not None else 0.0

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        """Name of a file number, what is declared, and how much it changes a unit of the parameter.

        place: of the number among those that are fitted; rotor: the effect's own, 0 where it has none.
        """
        axis = AXES[place] if place < len(AXES) else str(place)
        if cls.declared is None:
            return f"{cls.name}.{axis}", 0.0, 1.0
        words = cls.declared.words.format(axis=axis, place=place, rotor=rotor, **vehicle.drive._asdict())
        return words, cls.declared.value, 1.0

    @classmethod
    def cannot_show(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        """Why this effect cannot be seen with this vehicle in this flight, or None where it can."""
        return (
            _without_rotors(cls, vehicle) or _first_missing(cls.needs, vehicle, flight) or cls.hidden(vehicle, flight)
        )

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        """The part of `cannot_show` that is the effect's own, asked when every channel it needs is there."""
        return None

    def missing(self, vehicle: Vehicle, flight: Flight) -> str | None:
        """Why the effect with these values cannot be evaluated along the flight, or None."""
        return _without_rotors(type(self), vehicle) or _first_missing(self.needs_to_act, vehicle, flight)

    @cached_property
    def values(self) -> dict[str, float | int | list[float]]:
        """Parameter values as a file holds them; those of other forms (None) are left out."""
        held = {p.name: getattr(self, p.name) for p in self.parameters}
        return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in held.items() if v is not None}

    @cached_property
    def key(self) -> tuple[Any, ...]:
        """Name and values, to look results up by."""
        return (self.name, type(self), *((k, tuple(v) if isinstance(v, list) else v) for k, v in self.values.items()))

    def check(self, vehicle: Vehicle) -> None:
        """InputError where the values do not fit this vehicle: a rotor that it does not have, a wrong count."""
        for p in self.parameters:
            value = getattr(self, p.name)
            if value is not None and p.size == "tilts" and np.size(value) not in (len(vehicle.tilts), 1):
                raise InputError(
                    problem(
                        f"{self.name}: {p.name} holds {np.size(value)} numbers",
                        f"{len(vehicle.tilts)}, one a tilt of {vehicle.name}",
                        "Correct the list.",
                    )
                )

    def is_absent(self, vehicle: Vehicle) -> bool:
        """True where the values leave this vehicle's model as it was."""
        fitted = [p for p in self.parameters if not p.index]
        held = [(p, getattr(self, p.name)) for p in fitted]
        return all(v is None or np.all(np.asarray(v) == self.absent(vehicle, p)) for p, v in held)

    def __repr__(self) -> str:
        return f"{self.name}({', '.join(f'{k}={v}' for k, v in self.values.items())})"

    # Hooks, in the order in which they act. An effect overrides those that it needs.

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        """How the actuators follow their commands with this effect."""
        return law

    def air(self, law: AirLaw) -> AirLaw:
        """The air with this effect: its wind, and where drag acts on the body."""
        return law

    def moved_rotor(self) -> RotorMove | None:
        """Rotors that are not where the file has them: what the air does there, it does elsewhere."""
        return None

    def thrust_factor(self, along: Along) -> Array | float:
        """What multiplies the rotors' thrust: a number, (rotors,) or (N, rotors)."""
        return 1.0

    def thrust_loss(self, along: Along) -> Array | float:
        """Thrust (N) that the rotors lose, (N, rotors), taken off after all factors."""
        return 0.0

    def reaction_factor(self, along: Along) -> Array | float:
        """What multiplies the rotors' reaction torque: a number, (rotors,) or (N, rotors)."""
        return 1.0

    def rotor_force(self, along: Along) -> Array:
        """A further force (N) at each rotor, (N, rotors, 3), body axes."""
        return np.zeros((along.count, len(along.vehicle.rotors), 3))

    def rotor_momentum(self, along: Along) -> tuple[Array, Array]:
        """Angular momentum of the rotors (N m s) and its rate of change in body axes (N m), each (N, 3)."""
        return np.zeros((along.count, 3)), np.zeros((along.count, 3))

    def wrench(self, along: Along) -> Array:
        """Force (N) and torque (N m) about the body's origin, body axes, (N, 6)."""
        return np.zeros((along.count, 6))

    def load(self, along: Along) -> Load:
        """Something that hangs from the body's origin; without mass where there is none."""
        return Load(np.zeros((along.count, 3)), np.zeros(along.count), 0.0)

    def body(self, law: BodyLaw) -> BodyLaw:
        """The rigid body with this effect."""
        return law

    def imu(self, law: ImuLaw) -> ImuLaw:
        """What the IMU measures with this effect."""
        return law


def _first_missing(needs: tuple[str, ...], vehicle: Vehicle, flight: Flight) -> str | None:
    return next((reason for reason in (missing_channel(n, vehicle, flight) for n in needs) if reason is not None), None)


def _without_rotors(cls: type[Effect], vehicle: Vehicle) -> str | None:
    """The reason where an effect acts on single rotors, by its hooks or a place in their list, and there are none."""
    acts = any(getattr(cls, h) is not getattr(Effect, h) for h in ("thrust_loss", "rotor_force", "rotor_momentum"))
    return NO_ROTORS if not vehicle.rotors and (acts or any(p.index for p in cls.parameters)) else None


def overrides(effect: Effect, hook: str) -> bool:
    """True where the effect's class defines `hook` itself."""
    return _defines(type(effect), hook)


@lru_cache(maxsize=4096)
def _defines(cls: type[Effect], hook: str) -> bool:
    return getattr(cls, hook) is not getattr(Effect, hook)


def labels_in_words(labels: Sequence[str]) -> str:
    """Labels of effects, each name once, with its rotors: `rotor_torque (0 3), mass_offset`."""
    rotors: dict[str, list[str]] = {}
    for label in labels:
        name, *of = label.split()
        rotors.setdefault(name, []).extend(of)
    return ", ".join(f"{name} ({' '.join(sorted(of, key=int))})" if of else name for name, of in rotors.items())

"""The text of a new vehicle file: every number with its source, what is guessed said to be."""

from __future__ import annotations

from dataclasses import dataclass

import yaml

from infotraj import __version__
from infotraj.describing import guesses
from infotraj.describing.guesses import Guess
from infotraj.describing.layouts import drawing, places, position
from infotraj.vehicle import parse_vehicle

GIVEN = "given"
GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Asked:
    """What is known of the vehicle. Lengths in m, mass in kg, speeds in rad/s; None: not known.

    arm: from the middle to a rotor's axis. hover: speed (rad/s) or throttle (0..1) of the rotors in hover, as `input`
    says. moments: (xx, yy, zz), kg m^2.
    """

    name: str
    layout: str
    order: str
    arm: float
    mass: float
    input: str
    propeller: float
    thrust_coefficient: float | None = None
    hover: float | None = None
    moment_constant: float | None = None
    time_constant: float | None = None
    max_speed: float | None = None
    moments: tuple[float, float, float] | None = None


def vehicle_text(asked: Asked) -> str:
    """The vehicle file (YAML with comments). InputError where the numbers make no vehicle."""
    around = places(asked.layout, asked.order)
    spots = [position(place, asked.arm) for place in around]
    names = [f"rotor_{k}" for k in range(len(around))]
    if asked.moments is None:
        xx, yy, zz, whence = guesses.inertia(asked.mass, spots, asked.arm)
    else:
        (xx, yy, zz), whence = asked.moments, GIVEN
    thrust_key, thrust = _thrust(asked, len(around))
    moment = Guess(asked.moment_constant, GIVEN) if asked.moment_constant else guesses.moment_constant(asked.propeller)
    lag = (
        Guess(asked.time_constant, GIVEN)
        if asked.time_constant
        else Guess(0.03, "guessed: small motors have 20 to 80 ms")
    )
    said = {"moment_constant": moment.why, "time_constant": lag.why, "radius": "half of the propeller given"}
    if thrust is not None:
        said = {thrust_key: thrust.why} | said
    if asked.max_speed:
        said["max_speed"] = GIVEN
    lines = [
        f"# Written by `infotraj vehicle new` {__version__}. Replace the guesses: docs/vehicle.md says how.",
        "# From above:",
        *(f"#   {line}".rstrip() for line in drawing(names, around).splitlines()),
        f"name: {yaml.safe_dump(asked.name).splitlines()[0]}",
        f"mass: {asked.mass:g}    # kg, given: with its battery",
        f"inertia: {{xx: {xx:.3e}, yy: {yy:.3e}, zz: {zz:.3e}}}    # kg m^2, {whence}",
        f"gravity: {GRAVITY}    # m/s^2",
        f"# Rotors in the order of {asked.order} ({asked.layout}), {asked.arm:g} m from the middle: given. Per rotor:",
        *(f"#   {key}: {why}" for key, why in said.items()),
        "rotors:",
    ]
    for name, place, spot in zip(names, around, spots, strict=True):
        keys = [f"name: {name}", f"position: [{spot[0]:g}, {spot[1]:g}, {spot[2]:g}]", f"spin: {place.spin}"]
        if asked.input != "speed":
            keys.append(f"input: {asked.input}")
        if thrust is not None:
            value = f"[0, 0, {thrust.value:.4g}]" if thrust_key == "thrust_polynomial" else f"{thrust.value:.4e}"
            keys.append(f"{thrust_key}: {value}")
        keys += [
            f"moment_constant: {moment.value:.4g}",
            f"time_constant: {lag.value:g}",
            f"radius: {asked.propeller / 2:g}",
        ]
        if asked.max_speed:
            keys.append(f"max_speed: {asked.max_speed:g}")
        lines += [f"- {{{', '.join(keys[:3])},", f"   {', '.join(keys[3:])}}}"]
    text = "\n".join(lines) + "\n"
    parse_vehicle(yaml.safe_load(text), source=asked.name)
    return text


def guessed_numbers(text: str) -> int:
    """How many numbers the file of `vehicle_text` says are guessed."""
    return sum("guessed" in line.partition("#")[2] for line in text.splitlines())


def _thrust(asked: Asked, rotors: int) -> tuple[str, Guess | None]:
    """The key of the thrust that the input needs, and its value; None where the log itself holds thrusts."""
    if asked.input == "thrust":
        return "", None
    if asked.input == "throttle":
        assert asked.hover is not None
        return "thrust_polynomial", guesses.thrust_of_throttle(asked.mass, GRAVITY, rotors, asked.hover)
    if asked.thrust_coefficient is not None:
        return "thrust_coefficient", Guess(asked.thrust_coefficient, GIVEN)
    if asked.hover is not None:
        made = guesses.thrust_coefficient_of_hover(asked.mass, GRAVITY, rotors, asked.hover)
        return "thrust_coefficient", made
    return "thrust_coefficient", guesses.thrust_coefficient_of_propeller(asked.propeller)

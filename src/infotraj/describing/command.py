"""`infotraj vehicle new` and `infotraj vehicle check`."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from typing import Any

import click

from infotraj.describing.layouts import LAYOUTS, ORDERS, orders_of, places
from infotraj.errors import UsageError, problem
from infotraj.options import NumberRange, Reading, Several, accept_option, quiet_option, say_next
from infotraj.suggested import again, quoted
from infotraj.terminal import show

# What must be known: option, question. Further ones are guessed, and the file says so.
_NEEDED = {
    "layout": f"Layout ({', '.join(LAYOUTS)})",
    "order": f"Whose motor order ({', '.join(ORDERS)})",
    "arm": "From the middle to a rotor's axis, m",
    "mass": "Mass with its battery, kg",
    "propeller": "Diameter of a propeller, m",
}
# Options of speeds that say nothing of another input.
_NOT_WITH = {
    "speed": (),
    "throttle": ("thrust_coefficient", "max_speed"),
    "thrust": ("thrust_coefficient", "hover", "max_speed"),
}


class _InUnit(float):
    """A number that was given in a unit."""


class _Measured(click.ParamType):
    """A positive number, alone in the unit that is stored or with another: `0.275`, `27.5cm`. units: each in that."""

    def __init__(self, name: str, units: dict[str, float], example: str) -> None:
        self.name, self.units, self.example = name, units, example

    def convert(self, value, param, ctx):
        found = re.fullmatch(r"\s*(\d*\.?\d*(?:e[-+]?\d+)?)\s*([a-z/]*)\s*", str(value), re.IGNORECASE)
        unit = found[2].lower() if found is not None else ""
        try:
            number = float(found[1]) if found is not None else 0.0
        except ValueError:
            number = 0.0
        if not 0.0 < number < float("inf") or (unit and unit not in self.units):
            self.fail(
                f"{value!r} is no positive number, alone or with {' or '.join(self.units)}, such as {self.example}"
            )
        return _InUnit(number * self.units[unit]) if unit else number


_SPEED = _Measured("speed", {"rad/s": 1.0, "rpm": math.pi / 30}, "586 or 5600rpm")
_LENGTH = _Measured("length", {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}, "0.275 or 27.5cm")
_MASS = _Measured("mass", {"kg": 1.0, "g": 0.001}, "0.8 or 800g")
_POSITIVE = NumberRange(min=0, min_open=True)
_FLIGHT = click.option("--flight", type=click.Path(path_type=Path), help="A flight to hold the new file against.")


@click.group("vehicle")
def vehicle_command() -> None:
    """Write a first vehicle file, or hold one against a flight."""


@vehicle_command.command("new")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="The new file, NAME.yaml.")
@click.option("--layout", type=click.Choice(LAYOUTS), help="Where the rotors stand.")
@click.option("--order", type=click.Choice(ORDERS), help="Whose order of motors the log has.")
@click.option("--arm", type=_LENGTH, help="m (or 27.5cm), from the middle to a rotor's axis.")
@click.option("--mass", type=_MASS, help="kg (or 800g), with the battery.")
@click.option("--propeller", type=_LENGTH, help="m (or 10in), diameter.")
@click.option(
    "--input",
    "kind",
    type=click.Choice(["speed", "throttle", "thrust"]),
    help="What the log has of each rotor: rad/s or rpm, 0..1 (PWM, dshot), or N.  [default: speed]",
)
@click.option("--hover", type=_SPEED, help="Speed (586 rad/s, or 5600rpm) or throttle (0..1) of a rotor in hover.")
@click.option("--thrust-coefficient", type=_POSITIVE, help="N s^2/rad^2, from a stand.")
@click.option("--moment-constant", type=_POSITIVE, help="m, torque over thrust, from a stand.")
@click.option("--time-constant", type=_POSITIVE, help="s, of a step on a stand.")
@click.option("--max-speed", type=_SPEED, help="rad/s, or 9000rpm.")
@click.option("--inertia", cls=Several, type=_POSITIVE, metavar="XX YY ZZ", help="kg m^2, from CAD or a pendulum.")
@_FLIGHT
@quiet_option
def new_command(output: Path, kind: str | None, flight: Path | None, quiet: bool, **known: Any) -> None:
    """Write a commented vehicle file from a few numbers; what is guessed is said to be.

    On a terminal it asks for what is missing. A file that is there is never overwritten.
    """
    from infotraj.describing.writing import Asked, guessed_numbers, vehicle_text
    from infotraj.flight import flight_files
    from infotraj.importing.saving import write_text
    from infotraj.outputs import require_outputs

    if output.suffix not in (".yaml", ".yml"):
        raise UsageError(problem(f"-o {output}", "a name that ends in .yaml", "Rename it."))
    if output.exists():
        raise UsageError(problem(f"{output} is there already", "a new file", "Choose another name."))
    require_outputs({"-o": output}, {}, {"the flight": [] if flight is None else flight_files(flight)})
    moments = tuple(known.pop("inertia"))
    if len(moments) not in (0, 3):
        raise UsageError(problem(f"--inertia with {len(moments)} numbers", "three: xx yy zz", "Correct it."))
    kind = _completed(known, kind or "speed")
    text = vehicle_text(Asked(output.stem, input=kind, moments=moments or None, **known))
    write_text(output, text)
    click.echo(text, nl=False)
    if not quiet:
        click.echo(f"{output}: {guessed_numbers(text)} numbers are guessed", err=True)
    if flight is not None:
        _held_against(output, flight, ())
    else:
        say_next(f"infotraj vehicle check {quoted(output)} FLIGHT")


@vehicle_command.command("check")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("flight", required=False, type=click.Path(path_type=Path))
@accept_option
@quiet_option
def check_command(file: Path, flight: Path | None, accept: tuple[str, ...], quiet: bool) -> None:
    """Read FILE and say what is impossible in it; with FLIGHT, whether thrust, order, spins and inertia agree with it.

    A line with ! is to be looked at. Exit status 0 with and without.
    """
    from infotraj.describing.alone import alone
    from infotraj.vehicle import load_vehicle

    vehicle = load_vehicle(file)
    driven = "a wrench" if vehicle.inputs == "wrench" else f"{len(vehicle.rotors)} rotors by {vehicle.rotors[0].input}"
    unknown = [name for name in ("mass", "inertia") if getattr(vehicle, name) is None]
    left_out = f"; unknown: {', '.join(unknown)}" if unknown else ""
    show(f"{file}: {vehicle.name}, {driven}{left_out}")
    for one in alone(vehicle):
        show(f"{'  ' if one.good else '! '}{one.sentence}")
    if flight is not None:
        _held_against(file, flight, accept)
    say_next(f"infotraj compare {quoted(file, flight or 'FLIGHT')}{again('compare')}")


def _completed(known: dict[str, Any], kind: str) -> str:
    """Fills in what is missing by asking, on a terminal. UsageError, naming all of it, elsewhere."""
    from infotraj.describing.plausible import require_agreement, require_sizes, require_speed, require_stand

    missing = [name for name in _NEEDED if known[name] is None]
    if kind == "throttle" and known["hover"] is None:
        missing.append("hover")
    if missing and not sys.stdin.isatty():
        offered = {"layout": " | ".join(LAYOUTS), "order": " | ".join(orders_of(known["layout"]))}
        options = ", ".join(f"--{name}" + (f" ({offered[name]})" if name in offered else "") for name in missing)
        raise UsageError(problem(f"no {options}", "what the file cannot do without", "Add it, or use a terminal."))
    for name in missing:
        kinds = {"layout": click.Choice(LAYOUTS), "order": click.Choice(ORDERS), "mass": _MASS}
        kinds |= dict.fromkeys(("arm", "propeller"), _LENGTH)
        choices = kinds.get(name, _POSITIVE)
        known[name] = click.prompt(
            _NEEDED.get(name, "Throttle in hover, 0..1"), type=choices, show_choices=False, err=True
        )
    if kind == "throttle" and (known["hover"] > 1 or isinstance(known["hover"], _InUnit)):
        given = f"{known['hover']:g}" + (" rad/s" if isinstance(known["hover"], _InUnit) else "")
        raise UsageError(problem(f"--hover {given}", "a throttle of 0..1", "Correct it, or --input."))
    rotors = len(places(known["layout"], known["order"]))
    require_sizes(known["arm"], known["mass"], known["propeller"], rotors)
    if kind == "speed" and known["hover"] is not None:
        require_speed(known["hover"], known["propeller"])
    for name in _NOT_WITH[kind]:
        if known[name] is not None:
            option = f"--{name.replace('_', '-')}"
            raise UsageError(problem(f"{option} with --input {kind}", "one of them", f"Leave {option} out."))
    require_stand(known["moment_constant"], known["time_constant"], known["propeller"])
    if kind == "speed":
        speeds = (known[name] for name in ("thrust_coefficient", "hover", "max_speed"))
        require_agreement(known["mass"], rotors, known["propeller"], *speeds)
    return kind


def _held_against(file: Path, flight: Path, accept: tuple[str, ...]) -> None:
    from infotraj.comparing import files
    from infotraj.comparing.equation_error import equation_error
    from infotraj.describing.against import of_rotors, seen
    from infotraj.models import load_model

    model = load_model(file)
    let_in = files.admitted([flight], model.vehicle, lambda f: equation_error(model, f), Reading(accept=accept))
    error = let_in.found[0]
    for one in seen(error, rotors=of_rotors(model, let_in.flights[0], error)):
        show(f"{'  ' if one.good else '! '}{one.sentence}")
    files.say_unmet(accept, let_in.codes)

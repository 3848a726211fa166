"""What a log cannot answer, whatever its quality, because a channel is not in it."""

from __future__ import annotations

from dataclasses import dataclass

from infotraj.checking.finding import Finding
from infotraj.dynamics.inputs import command_columns, input_columns
from infotraj.flight import (
    ATTITUDE,
    COMMANDED_WRENCH,
    POSITION,
    RATE,
    REFERENCE_ATTITUDE,
    REFERENCE_POSITION,
    SPECIFIC_FORCE,
    VELOCITY,
    Flight,
)
from infotraj.vehicle import Vehicle

Need = tuple[tuple[str, ...], ...]

# What counts only whole. Of a commanded wrench a vehicle file may say that one component is all of it.
_VECTORS = {
    "position": POSITION,
    "attitude": ATTITUDE,
    "velocity": VELOCITY,
    "angular velocity": RATE,
    "specific force": SPECIFIC_FORCE,
    "reference position": REFERENCE_POSITION,
    "reference attitude": REFERENCE_ATTITUDE,
}
_NUMBERED = {
    "rotor commands": "cmd_rotor_",
    "tilt commands": "cmd_tilt_",
    "measured rotors": "rotor_",
    "measured tilts": "tilt_",
}


@dataclass(frozen=True)
class Question:
    """`needs` lists groups of columns, any one of which is enough for that need; all needs must be met."""

    name: str
    needs: tuple[Need, ...]


_POSE = ((POSITION,), (ATTITUDE,))
# What the vehicle's inputs are, the vehicle file says; without one, anything that drives a vehicle will do.
_INPUT = (("cmd_rotor_0",), ("rotor_0",), COMMANDED_WRENCH)
_COMMAND = (("cmd_rotor_0",), COMMANDED_WRENCH)
QUESTIONS: tuple[Question, ...] = (
    Question("rollouts (open-loop prediction from a recorded state)", (*_POSE, _INPUT)),
    Question("whether the attitude means what it says (frame, order, direction)", ((ATTITUDE,), (RATE,))),
    Question("whether rates are in rad/s and in the body frame", ((ATTITUDE,), (RATE,))),
    Question("whether the clocks of pose and IMU agree", ((ATTITUDE, POSITION), (RATE, SPECIFIC_FORCE))),
    Question("force errors", ((SPECIFIC_FORCE, VELOCITY + ATTITUDE), _INPUT)),
    Question("torque errors", ((RATE,), _INPUT)),
    Question("drag and wind (need a velocity and an attitude)", ((VELOCITY, POSITION), (ATTITUDE,), _INPUT)),
    Question("steady_force (needs the world's axes)", ((ATTITUDE,), _INPUT)),
    Question("ground_effect (needs a height)", ((POSITION,), _INPUT)),
    Question("suspended_load (needs the world's axes)", ((ATTITUDE,), _INPUT)),
    Question("gyro_bias (needs an attitude beside the gyro)", ((ATTITUDE,), (RATE,))),
    Question("sensor_lag (needs a gyro or an accelerometer)", ((RATE, SPECIFIC_FORCE),)),
    Question("rotor_lag, servo_lag and actuation_delay (need commands)", (_COMMAND,)),
    Question("the experiment (needs the commanded wrench)", ((COMMANDED_WRENCH,),)),
    Question("battery_sag by voltage", ((("battery",),),)),
    Question("tracking errors", ((REFERENCE_POSITION,), (POSITION,))),
)


def unanswerable(flight: Flight, vehicle: Vehicle | None = None) -> dict[str, list[str]]:
    """For each question that this log cannot answer, the columns that would help (one of each entry).

    With a vehicle its own inputs are asked for, as a prediction does; without one any that drive a vehicle are enough.
    """
    out: dict[str, list[str]] = {}
    for question in QUESTIONS:
        needs = [n for need in question.needs for n in _of_vehicle(need, vehicle)]
        missing = [need for need in needs if not any(flight.has(*g) for g in need)]
        if missing:
            out[question.name] = [" or ".join(_name(g) for g in need) for need in missing]
    return out


def question_findings(flight: Flight, vehicle: Vehicle | None = None) -> list[Finding]:
    """One note that names the unanswerable questions; a rejection where the log holds nothing that a model predicts."""
    missing = unanswerable(flight, vehicle)
    if not missing:
        return []
    nothing = not any(flight.has(*g) for g in (POSITION, ATTITUDE, VELOCITY, RATE, SPECIFIC_FORCE))
    remedy = "map more channels: " + ", ".join(sorted({m for needs in missing.values() for m in needs}))
    if vehicle is not None and vehicle.rotors and input_columns(vehicle, flight) is None and flight.has("cmd_fz"):
        remedy += f"; or write `inputs: wrench` in place of {vehicle.name}'s `rotors`: the commanded wrench is here"
    return [
        Finding(
            "nothing_measured" if nothing else "cannot_answer",
            "reject" if nothing else "note",
            "no motion is in this log" if nothing else "this log cannot answer: " + "; ".join(missing),
            "no model can be compared with it" if nothing else "answers about these will be Not testable here",
            remedy,
            values={"missing": missing},
        )
    ]


def incomplete(flight: Flight) -> dict[str, tuple[str, ...]]:
    """Channels of which some columns hold numbers and others do not: all columns of each."""
    whole = _VECTORS | {word: _up_to_last(flight, prefix) for word, prefix in _NUMBERED.items()}
    return {w: columns for w, columns in whole.items() if any(map(flight.has, columns)) and not flight.has(*columns)}


def incomplete_findings(flight: Flight) -> list[Finding]:
    """A warning for each channel that is incomplete: it counts as not there."""
    found = []
    for word, columns in incomplete(flight).items():
        there = ", ".join(c for c in columns if flight.has(c))
        lacking = [c for c in columns if not flight.has(c)]
        found.append(
            Finding(
                "incomplete",
                "warning",
                f"{word} incomplete: {there} hold numbers, {', '.join(lacking)} not",
                "what is there of it is not used",
                f"add {', '.join(lacking)}, or leave out {there}",
                channels=tuple(columns),
                values={"missing": lacking},
            )
        )
    return found


def missing_input_findings(flight: Flight, vehicle: Vehicle | None) -> list[Finding]:
    """A rejection where the flight has inputs of fewer rotors or tilts than the vehicle: most likely of another one."""
    if vehicle is None or vehicle.inputs == "wrench":
        return []
    found = []
    for kind, parts in (("rotor", vehicle.rotors), ("tilt", vehicle.tilts)):
        wanted = {p: tuple(f"{p}{k}" for k in range(len(parts))) for p in (f"cmd_{kind}_", f"{kind}_")}
        there = {p: [c for c in columns if flight.has(c)] for p, columns in wanted.items()}
        prefix = next((p for p, columns in there.items() if columns), None)
        if prefix is None or any(flight.has(*columns) for columns in wanted.values()):
            continue
        lacking = [c for c in wanted[prefix] if c not in there[prefix]]
        count = len(there[prefix])
        what = "commands" if prefix.startswith("cmd_") else "measurements"
        add = f"map {', '.join(lacking)}"
        another = lacking == list(wanted[prefix][count:])
        found.append(
            Finding(
                "missing_columns",
                "reject",
                f"{vehicle.name} has {len(parts)} {kind}s, the flight {what} of {count}"
                + (": another vehicle's file?" if another else f", without {', '.join(lacking)}"),
                "what drives the vehicle is not known",
                f"give the flight's own vehicle file, or {add}" if another else add,
                channels=tuple(lacking),
                values={"flight": count, "vehicle": len(parts)},
            )
        )
    return found


def _up_to_last(flight: Flight, prefix: str) -> tuple[str, ...]:
    """Numbered columns up to the last that holds a number: empty ones at the end are spare."""
    numbers = [int(n) for c in flight.table if (n := str(c).removeprefix(prefix)) != c and n.isdecimal()]
    used = [k for k in numbers if flight.has(f"{prefix}{k}")]
    return tuple(f"{prefix}{k}" for k in range(max(used, default=-1) + 1))


def _of_vehicle(need: Need, vehicle: Vehicle | None) -> list[Need]:
    """A need in the vehicle's own columns: its inputs, commanded or measured, and its tilts."""
    if vehicle is None or need not in (_INPUT, _COMMAND):
        return [need]
    found, measured = [], need is _INPUT
    for parts, kind in ((vehicle.rotors, "rotor"), (vehicle.tilts, "tilt")):
        if parts:
            prefixes = ("cmd_", "") if measured else ("cmd_",)
            found.append(tuple(tuple(f"{p}{kind}_{i}" for i in range(len(parts))) for p in prefixes))
    return found or [(tuple(command_columns(vehicle)),)]


def _name(group: tuple[str, ...]) -> str:
    return group[0] if len(group) == 1 else f"{group[0]}..{group[-1]}"

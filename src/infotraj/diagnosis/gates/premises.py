"""What must hold before an effect can be named: the log means what it says, the vehicle moves, actuators are known.

An effect is a small correction of a model that otherwise holds. Where commands and motion belong to different flights,
where the actuators are known only now and then, or where nothing moves, a fit still finds numbers that lower the error;
they are no physics. Each premise is tested on the flights as they are, before anything is fitted, by measures that a
missing effect of any usual size leaves alone: correlation, its sign and its lag, never size. One that fails takes out
the axes that it concerns, not the flights.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from infotraj import rotations
from infotraj.checking import examine
from infotraj.checking.admission import admitted
from infotraj.checking.airborne import airborne_rows
from infotraj.comparing.equation_error import AXES, equation_error
from infotraj.diagnosis.gates import agreement, vehicle_faults
from infotraj.diagnosis.gates.doubt import Doubt, as_accepted, reached, refused_axes
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.dynamics.inputs import command_columns, input_columns
from infotraj.effects.channels import tilt_columns
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.importing import row_rate
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

LONGEST_STEP = 0.03  # s between samples of the actuators: no multirotor is controlled more slowly than 33 Hz
_CHANNELS = {
    "commanded rotors": "rotor_command",
    "commanded tilts": "tilt_command",
    "commanded wrench": "commanded_force",
    "measured rotors": "rotor",
    "measured tilts": "tilt",
}
_STILL_RATE = 0.1  # rad/s, root mean square; sensors' noise is below it
_STILL_TILT = 0.05  # rad, standard deviation of the direction of gravity in the body
_STILL_SPEED = 0.25  # m/s, 95 % of the rows
_STILL_FORCE = 0.3  # m/s^2, standard deviation of 0.1 s means, where there is no attitude to see a tilt by


def examined(flight: Flight, vehicle: Vehicle) -> Flight:
    """The flight without the samples that `check` finds dead, stuck or contradicted: these cells are empty.

    InputError where `check` rejects it: no flight, units, frames or conventions other than declared, columns in use of
    more rotors or tilts than the vehicle has.
    """
    return admitted(flight, examine(flight, vehicle))


def doubts(
    model: Model, flights: Sequence[Flight], start: float | None = None, stop: float | None = None
) -> tuple[Doubt, ...]:
    """Why axes of these flights can name no effect: one for each premise that fails, with the axes it concerns.

    The reason that says what to do comes first. Those that every flight's user accepts are marked so.
    """
    return as_accepted(_doubts(model, flights, start, stop), flights)


def _doubts(model: Model, flights: Sequence[Flight], start: float | None, stop: float | None) -> list[Doubt]:
    rows = [_used(f, model.vehicle, start, stop) for f in flights]
    if all(_still(f, r) for f, r in zip(flights, rows, strict=True)):
        return [Doubt("hovers", "motion", AXES, "the vehicle hovers: nothing that moves could show an effect")]
    thin = [w for f, r in zip(flights, rows, strict=True) if (w := _thin(f, r, model.vehicle)) is not None]
    if thin:
        return thin[:1]
    errors = [equation_error(model, f, start=start, stop=stop) for f in flights]
    contrary = agreement.contradictions(errors, model.vehicle)
    shortest = int(np.argmin([len(f.t) for f in flights]))
    contradicted = any(d.about == "commands" for d in contrary)
    fault = vehicle_faults.vehicle_fault(model, flights[shortest], errors[shortest], contradicted)
    return ([] if fault is None else [fault]) + contrary


def remaining(
    found: Sequence[Doubt], names: Iterable[str], known: list[Candidate], hidden: dict[str, str]
) -> tuple[list[Candidate], dict[str, str]]:
    """The candidates and the reasons against the others, as `candidates` gives them, as far as the doubts leave them.

    Where no axis is left there are none. Where it is not known which column belongs to which actuator, there are none
    of single actuators.
    """
    refused = refused_axes(found)
    if len(refused) == len(AXES):
        reason = next(iter(refused.values()))
        return [], {name: hidden.get(name, reason) for name in names}
    unordered = next((d.reason for d in found if d.counts and d.unordered), None)
    if unordered is None:
        return known, hidden
    single = {c.name for c in known if c.fixed or any(p.size == "tilts" for p in c.form)}
    return [c for c in known if c.name not in single], {**hidden, **dict.fromkeys(single, unordered)}


def _used(flight: Flight, vehicle: Vehicle, start: float | None, stop: float | None) -> NDArray:
    t = flight.t
    inside = (t >= (-np.inf if start is None else start)) & (t < (np.inf if stop is None else stop))
    return inside & np.asarray(airborne_rows(flight, vehicle).rows, dtype=bool)


def _still(flight: Flight, rows: NDArray) -> bool:
    """Whether the vehicle stands, or does nothing but hold its place and attitude; False where the flight does not
    tell."""
    if rows.sum() < 50:
        return not rows.any()
    if flight.has(*RATE):
        rate = _fast_noise_off(flight.t[rows], flight.get(*RATE)[rows])
        if _rms(rate - np.nanmean(rate, axis=0)) > _STILL_RATE:
            return False
    if flight.has(*ATTITUDE):
        q = flight.get(*ATTITUDE)[rows]
        known = np.isfinite(q).all(axis=1)
        turn = rotations.matrix(rotations.normalize(q[known]))
        if max(_rms(x - x.mean(axis=0)) for x in (turn[:, 2, :], turn[:, :, 0])) > _STILL_TILT:
            return False
    elif flight.has(*SPECIFIC_FORCE):
        force = _fast_noise_off(flight.t[rows], flight.get(*SPECIFIC_FORCE)[rows])
        if _rms(force - np.nanmean(force, axis=0)) > _STILL_FORCE:
            return False
    if flight.has(*VELOCITY):
        speed = np.linalg.norm(flight.get(*VELOCITY)[rows], axis=1)
        return bool(np.nanquantile(speed, 0.95) < _STILL_SPEED)
    if flight.has(*POSITION):
        place = flight.get(*POSITION)[rows]
        return bool(np.ptp(place[np.isfinite(place).all(axis=1)], axis=0).max() < _STILL_SPEED)
    return flight.has(*RATE) or flight.has(*ATTITUDE) or flight.has(*SPECIFIC_FORCE)


def _fast_noise_off(t: Array, x: Array) -> Array:
    """Means of x (n, 3) over 0.1 s: what is left of white noise there does not pass for motion."""
    cell = np.floor((t - t[0]) / 0.1).astype(int)
    cell -= cell[0]
    good = np.isfinite(x).all(axis=1)
    count = np.bincount(cell[good])
    sums = np.stack([np.bincount(cell[good], x[good, i]) for i in range(x.shape[1])], axis=1)
    return sums[count > 0] / count[count > 0, None]


def _rms(x: Array) -> float:
    return float(np.sqrt(np.nanmean(np.sum(x**2, axis=1))))


def _thin(flight: Flight, rows: NDArray, vehicle: Vehicle) -> Doubt | None:
    """The doubt where the actuators' samples are too far apart, or never change, to say what the vehicle did."""
    for name, step in _steps(flight, rows, vehicle).items():
        if "tilts" not in name and np.isinf(step):
            words = ("never changes", "it") if "wrench" in name else ("never change", "them")
            reason = f"the {name} {words[0]}: the motion does not come from {words[1]}"
            return Doubt("actuators_constant", "actuator log", AXES, reason)
        if LONGEST_STEP < round(step, 6) < np.inf:  # stamps of 30 ms differ by 30 ms but for rounding
            lost = row_rate.denser(flight.meta, flight.t)
            reason = (
                f"the {name} are known every {1000 * step:.0f} ms only ({1 / step:.0f} Hz): what the "
                f"actuators did in between is not in the log, and the motion shows it"
            )
            if _CHANNELS[name] in lost:
                reason = f"{row_rate.in_words(lost, flight.t)}: import the log with {row_rate.rows_option(lost)}"
            return Doubt("actuators_sparse", "actuator log", reached(vehicle), reason)
    return None


def command_step(flight: Flight, vehicle: Vehicle) -> float:
    """s between rows in which the rotors (or the wrench) are known, the median; 0 where they never are."""
    columns = input_columns(vehicle, flight)
    if columns is None:
        return 0.0
    known = np.isfinite(flight.get(*columns)).all(axis=1)
    return float(np.median(np.diff(flight.t[known]))) if known.sum() > 1 else 0.0


def _steps(flight: Flight, rows: NDArray, vehicle: Vehicle) -> dict[str, float]:
    """s between samples in which rotors and tilts changed, the median, by name; inf where they never do."""
    out = {}
    rotors = "wrench" if vehicle.inputs == "wrench" else "rotors"
    tilts = tilt_columns(vehicle) if flight.has(*tilt_columns(vehicle)) else tilt_columns(vehicle, "tilt_")
    for columns, what in ((input_columns(vehicle, flight), rotors), (tilts, "tilts")):
        if columns and flight.has(*columns):
            name = "commanded" if columns[0].startswith("cmd_") else "measured"
            step = _between_new(flight.t[rows], flight.get(*columns)[rows])
            if step is not None:
                out[f"{name} {what}"] = step
    return out


def new_command_step(flight: Flight, vehicle: Vehicle) -> float:
    """s between commands of the rotors (or of the wrench) that differ, the median; inf where there are none."""
    columns = command_columns(vehicle)
    step = _between_new(flight.t, flight.get(*columns)) if flight.has(*columns) else None
    return np.inf if step is None else step


def _between_new(t: Array, x: Array) -> float | None:
    """s between new values of x (n, c) at t (n,), the median; inf where they never change, None where too few do."""
    known = np.isfinite(x).all(axis=1)
    t = t[known]
    changed = _new_values(np.any(np.diff(x[known], axis=0) != 0.0, axis=1))
    if len(t) > 1 and len(changed) == 0:
        return np.inf
    return float(np.median(np.diff(t[1:][changed]))) if len(changed) > 10 else None


def _new_values(differs: NDArray) -> NDArray:
    """Where a new value begins; differs (n - 1,): whether a row's values are not those of the row before.

    A value that comes between two rows changes two of them: the one that holds the mean of old and new, and the next.
    """
    at = np.flatnonzero(differs)
    if len(at) < 2:
        return at
    apart = np.diff(at) > 1
    after, before = np.append(apart, True), np.insert(apart, 0, True)
    mean_of_two = ~after & before & np.append(after[1:], False)
    return at[~mean_of_two]

"""The codes of all findings, so that a user's word about one can be held against those that exist."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from infotraj.errors import UsageError, problem

# Of `check`, in the order of docs/check.md.
CHECKED = (
    "attitude_order", "attitude_inverse", "attitude_unit", "attitude_sign", "attitude_frame",
    "rate_unit", "rate_frame", "rate_axes", "rate_sign",
    "velocity_unit", "velocity_frame", "velocity_axes", "velocity_sign",
    "position_unit", "position_frame", "world_z_down",
    "acceleration_unit", "acceleration_frame", "acceleration_axes", "acceleration_sign", "acceleration_without_gravity",
    "time_unit", "rotor_unit", "command_unit", "surplus_columns", "missing_columns", "unused_columns",
    "commands_unread", "signed_speeds", "reversing_rotors",
    "rate_impossible", "speed_impossible", "force_impossible", "attitude_norm",
    "imu_clock_offset", "imu_clock_varies", "imu_clock_drift",
    "velocity_clock_offset", "velocity_clock_varies", "velocity_clock_drift",
    "accelerometer_clock_offset", "accelerometer_clock_varies", "accelerometer_clock_drift",
    "response_before_command", "response_too_late", "response_lag",
    "dead_stream", "stuck", "held", "dead_column", "wrapped", "sign_flips", "quantised", "contradiction",
    "rates_unexplained", "velocity_unexplained", "acceleration_unexplained", "estimate_diverged",
    "time_backwards", "duplicate_times", "time_not_finite", "gaps", "jitter", "slow_rows", "spikes", "saturated",
    "impossible_command", "pose_jump", "no_flight", "airborne_flag", "low_flight",
    "reference_not_followed",
    "clock_varies_between_logs", "copy", "own_reference", "unreadable", "incomplete", "cannot_answer",
    "nothing_measured", "not_excited",
)  # fmt: skip
# Of `diagnose`: why it refuses axes, and what it says without, in the order of docs/diagnosis.md
# (response_before_command is check's too).
REFUSED = (
    "hovers", "actuators_constant", "actuators_sparse", "commands_unrelated", "wrong_vehicle_file",
    "axis_disagrees", "rotor_saturated", "impossible_inertia", "accelerometer_shaken",
)  # fmt: skip
CODES = CHECKED + REFUSED
# Where nothing could be read, nothing drives the vehicle, or nothing lies between a flight and its reference, there is
# nothing to go on with: what is needed instead.
NEVER = {
    "unreadable": "a log that can be read",
    "missing_columns": "inputs of all rotors and tilts",
    "own_reference": "healthy flights other than those in question",
}


def known(words: Iterable[str]) -> tuple[str, ...]:
    """The codes in words such as "rate_unit,copy", each once. UsageError, with the nearest codes, for any other."""
    found: dict[str, None] = {}
    for word in words:
        for code in filter(None, (part.strip() for part in word.split(","))):
            if code in NEVER:
                raise UsageError(problem(f"{code} cannot be accepted", NEVER[code], "Leave it out."))
            if code not in CODES:
                near = get_close_matches(code, CODES, 4, 0.5) or [c for c in CODES if code in c][:4]
                expected = f"a code such as {', '.join(near)}" if near else "a finding's code"
                raise UsageError(problem(f"no finding has the code {code}", expected, "docs/check.md lists all."))
            found[code] = None
    return tuple(found)


def unmet(accept: Iterable[str], found: Iterable[str]) -> list[str]:
    """A line for each accepted code that no finding had."""
    had = set(found)
    return [f"--accept {code}: no such finding here" for code in accept if code not in had]

"""What is said of each way in which a log's conventions differ from what is declared: code, sentence, settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from infotraj.checking.attitude import READINGS
from infotraj.checking.likelihood import AXES
from infotraj.checking.readings import DEGREE, Joint
from infotraj.checking.settings import axes_setting, scale_setting

NAMES = {"rate": ("wx", "wy", "wz"), "velocity": ("vx", "vy", "vz"), "force": ("ax", "ay", "az")}
WORDS = {"rate": "angular velocity", "velocity": "velocity", "force": "specific force"}
UNITS = {"rate": "rad/s", "velocity": "m/s", "force": "m/s^2"}
_CODES = {"rate": "rate", "velocity": "velocity", "force": "acceleration"}
_CHANNELS = {"rate": "rate", "velocity": "velocity", "force": "specific_force"}
_WORLDS = {"NED": "NED", "z down": "[x, -y, -z]"}


@dataclass(frozen=True)
class Sentence:
    """The finding's code, what is wrong, the columns, and the settings that would mend it on import."""

    code: str
    what: str
    channels: tuple[str, ...]
    settings: tuple[str, ...]


def sentence(factor: str, joint: Joint) -> Sentence:
    """What `joint` says of one factor ("rate.unit", "pose.attitude", ..) that it changes."""
    return _SENTENCES[factor](joint)


def _attitude(joint: Joint) -> Sentence:
    reading = READINGS[joint.pose.attitude]
    return Sentence(reading.code, f"the attitude {reading.what}", ("qw", "qx", "qy", "qz"), reading.settings)


def _pose_axes(joint: Joint) -> Sentence:
    axes = {"NED": "north-east-down", "z down": "z-down"}.get(joint.pose.axes, joint.pose.axes)
    return Sentence(
        "position_frame",
        f"positions are given in {axes} axes, not in those of the attitude",
        ("px", "py", "pz"),
        (f"position.world={_WORLDS[joint.pose.axes]}",),
    )


def _pose_unit(joint: Joint) -> Sentence:
    return Sentence(
        "position_unit",
        f"positions are {joint.pose.unit:g} times too large for metres",
        ("px", "py", "pz"),
        (scale_setting("position", joint.pose.unit),),
    )


def _pose_down(joint: Joint) -> Sentence:
    return Sentence(
        "world_z_down",
        "the world's z axis points down (gravity acts along +z)",
        ("pz", "vz", "qw", "qx", "qy", "qz"),
        (
            *(f"{channel}.world=NED" for channel in ("position", "velocity", "attitude")),
            *(f"{channel}.body=FRD" for channel in ("attitude", "rate", "specific_force")),
        ),
    )


def _turn(channel: str) -> Callable[[Joint], Sentence]:
    word, code, names = WORDS[channel], _CODES[channel], NAMES[channel]
    own, other = ("world", "body") if channel == "velocity" else ("body", "world")

    def say(joint: Joint) -> Sentence:
        once = (getattr(joint, channel).turn < 0) == (own == "world")
        what = (
            f"{word} is in the {other} frame, not the {own}'s"
            if once
            else f"{word} was in the {own} frame already and was turned from {other} to {own} once too often"
        )
        setting = f"{_CHANNELS[channel]}.expressed_in={other if once else own}"
        return Sentence(f"{code}_frame", what, names, (setting,))

    return say


def _unit(channel: str) -> Callable[[Joint], Sentence]:
    word, code, names = WORDS[channel], _CODES[channel], NAMES[channel]

    def say(joint: Joint) -> Sentence:
        unit = getattr(joint, channel).unit
        special = {
            ("rate", True): "is in deg/s, not rad/s",
            ("rate", False): "was in rad/s and was converted from deg/s",
            ("force", False): "is in g, not m/s^2",
            ("force", True): "was in m/s^2 and was multiplied by g",
        }.get((channel, unit > 1), f"is {unit:.4g} times that of m/s")
        odd = channel == "rate" and not np.isclose(unit, DEGREE, rtol=0.1) and not np.isclose(unit * DEGREE, 1, 0.1)
        text = f"is {unit:.4g} times that of rad/s" if odd else special
        return Sentence(f"{code}_unit", f"{word} {text}", names, (scale_setting(_CHANNELS[channel], unit),))

    return say


def _axes(channel: str) -> Callable[[Joint], Sentence]:
    word, code, names = WORDS[channel], _CODES[channel], NAMES[channel]

    def say(joint: Joint) -> Sentence:
        axes = AXES[getattr(joint, channel).axes]
        setting = axes_setting(_CHANNELS[channel], axes)
        if np.array_equal(axes, -np.eye(3)):
            return Sentence(f"{code}_sign", f"{word} has the opposite sign", names, (setting,))
        where = "world" if channel == "velocity" else "body"
        held = ", ".join(("+" if row[k] > 0 else "-") + "xyz"[k] for row in axes for k in [int(np.argmax(np.abs(row)))])
        what = f"{word} has other axes than the {where}: its columns hold {held} of the {where}"
        if axes[1, 1] == axes[2, 2] == -1:
            what += " (front-right-down)" if where == "body" else " (z down)"
        return Sentence(f"{code}_axes", what, names, (setting,))

    return say


def _removed(joint: Joint) -> Sentence:
    return Sentence(
        "acceleration_without_gravity",
        "ax, ay, az hold the acceleration without gravity, not the specific force",
        NAMES["force"],
        ("specific_force.gravity_removed=true",),
    )


_SENTENCES: dict[str, Callable[[Joint], Sentence]] = {
    "pose.attitude": _attitude,
    "pose.axes": _pose_axes,
    "pose.unit": _pose_unit,
    "pose.down": _pose_down,
    "force.removed": _removed,
    **{f"{c}.turn": _turn(c) for c in NAMES},
    **{f"{c}.unit": _unit(c) for c in NAMES},
    **{f"{c}.axes": _axes(c) for c in NAMES},
}
FACTORS: tuple[str, ...] = (
    *(f"pose.{k}" for k in ("attitude", "axes", "unit", "down")),
    *(f"{c}.{k}" for c in ("rate", "velocity", "force") for k in ("turn", "axes", "unit")),
    "force.removed",
)
CODES = frozenset(
    {r.code for r in READINGS if r.code}
    | {f"{c}_{kind}" for c in _CODES.values() for kind in ("frame", "unit", "axes", "sign")}
    | {"position_frame", "position_unit", "world_z_down", "acceleration_without_gravity"}
)

"""The channels of a log as they should have been, once it is known what they hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infotraj import rotations
from infotraj.checking.attitude import READINGS
from infotraj.checking.kinematics import WORLD_AXES, Channels
from infotraj.checking.likelihood import AXES
from infotraj.checking.readings import NOISE, Joint, Vector
from infotraj.checking.streams import Stream, attitude_stream


def corrected(ch: Channels, joint: Joint) -> Channels:
    """The channels as the reading `joint` says they should have been declared. A world with z down stays so."""
    attitude, position = ch.attitude, ch.position
    if attitude is not None and joint.pose.attitude:
        attitude = attitude_stream(replace(attitude, x=READINGS[joint.pose.attitude].true(attitude.x)))
    if position is not None:
        unit = 1.0 if joint.pose.unit == NOISE else joint.pose.unit
        position = replace(position, x=position.x @ WORLD_AXES[joint.pose.axes].T / unit)
    return replace(
        ch,
        attitude=attitude,
        position=position,
        rate=_vector(ch.rate, joint.rate, attitude),
        velocity=_vector(ch.velocity, joint.velocity, attitude),
        force=None if joint.force.removed else _vector(ch.force, joint.force, attitude),
    )


def _vector(stream: Stream | None, reading: Vector, attitude: Stream | None) -> Stream | None:
    # declared = unit x axes x R^turn (true)
    if stream is None or reading == Vector():
        return stream
    x = stream.x @ AXES[reading.axes] / reading.unit
    if reading.turn and attitude is not None:
        q = rotations.normalize(attitude.at(stream.t))
        x = (rotations.to_body if reading.turn > 0 else rotations.to_world)(q, x)
    good = np.isfinite(x).all(axis=1)
    return Stream(stream.t[good], x[good], stream.gap)

"""From a log's numbers to the table's: units, axes, quaternion order, and vectors turned between world and body."""

from __future__ import annotations

from typing import Any

import numpy as np

from infotraj import rotations
from infotraj.errors import InputError, problem
from infotraj.importing.channel_map import Axes, ChannelMap, dimension_of, frame_matrix, unit_of
from infotraj.importing.channels import CHANNELS
from infotraj.importing.flags import as_flags
from infotraj.importing.frames import axes_matrix, rotate_attitudes, rotate_vectors
from infotraj.importing.log import Samples
from infotraj.importing.mapping import Mapping, StreamMap
from infotraj.importing.units import STANDARD_GRAVITY, conversion
from infotraj.rotations import Array


@np.errstate(over="ignore", invalid="ignore")  # damaged numbers become inf or NaN, and are refused as such
def channel_values(name: str, mapped: ChannelMap, stream: StreamMap, mapping: Mapping, samples: Samples) -> Array:
    """One channel's samples (n, columns) in SI and in the table's axes, but vectors still `expressed_in` as logged."""
    channel = CHANNELS[name]
    raw = logged_numbers(mapped, samples)
    if mapped.states is not None:
        return as_flags(raw, mapped.states)
    factor, zero = conversion(dimension_of(name, mapped), unit_of(name, mapped))
    values = _combined(name, mapped, _affine(raw, factor, zero))
    if mapped.absolute:
        values = np.abs(values)
    values = _affine(values, mapped.scale, mapped.offset)
    if mapped.clip is not None:
        values = np.clip(values, *mapped.clip)
    if channel.frame == "attitude":
        return _attitude(mapped, values, *(frame_of(mapped, stream, mapping, w) for w in ("world", "body")))
    if channel.frame in ("world", "body"):
        values = rotate_vectors(frame_of(mapped, stream, mapping, expressed_in(name, mapped)), values)
        return values if mapped.axes is None else rotate_vectors(axes_matrix(mapped.axes, mirrored=True), values)
    return values


def expressed_in(name: str, mapped: ChannelMap) -> str:
    """'world' or 'body': the axes of a vector as it is logged."""
    return mapped.expressed_in or CHANNELS[name].frame


def needs_attitude(name: str, mapped: ChannelMap) -> bool:
    """True where a vector has to be turned by the vehicle's attitude to be in the table's axes."""
    channel = CHANNELS[name]
    turned = channel.frame in ("world", "body") and expressed_in(name, mapped) != channel.frame
    return turned or mapped.gravity_removed


@np.errstate(over="ignore", invalid="ignore")
def turn(name: str, mapped: ChannelMap, values: Array, q: Array) -> Array:
    """Vectors (n, 3) with attitudes q (n, 4) in the axes of the table; gravity put back where it was removed."""
    logged, wanted = expressed_in(name, mapped), CHANNELS[name].frame
    if mapped.gravity_removed and logged == "world":
        values = values + np.array([0.0, 0.0, STANDARD_GRAVITY])
    if logged != wanted:
        values = rotations.to_world(q, values) if wanted == "world" else rotations.to_body(q, values)
    if mapped.gravity_removed and logged == "body":
        values = values + rotations.to_body(q, np.broadcast_to([0.0, 0.0, STANDARD_GRAVITY], values.shape))
    return values


def logged_numbers(mapped: ChannelMap, samples: Samples) -> Array:
    """The channel's fields (n, k) as they are logged, without the unused places at their end."""
    if any("*" in f for f in mapped.fields):
        values = samples.numbers[mapped.fields[0]]
        if mapped.count is not None and len(values):
            values = values[:, : max(int(np.nanmax(samples.numbers[mapped.count])), 1)]
        # A fixed-size message array reports the unused places as NaN (PX4's actuator_motors).
        used = np.flatnonzero(np.isfinite(values).any(axis=0)) if values.size else np.zeros(0, int)
        return values[:, : int(used[-1]) + 1] if used.size else values
    return np.stack([samples.numbers[f] for f in mapped.fields], axis=-1)


def _combined(name: str, mapped: ChannelMap, values: Array) -> Array:
    """The picked and mixed fields (n, outputs). InputError where the log has not as many as the mapping says."""
    wanted = max(mapped.pick) + 1 if mapped.pick is not None else len(mapped.mix[0]) if mapped.mix is not None else 0
    if values.shape[1] < wanted:
        raise InputError(
            problem(
                f"{name}: the log has {values.shape[1]} of {mapped.fields[0]}",
                f"at least {wanted}, as `{'pick' if mapped.pick is not None else 'mix'}` says",
                "Correct the mapping.",
            )
        )
    if mapped.pick is not None:
        values = values[:, list(mapped.pick)]
    if mapped.mix is None:
        return values
    weights = np.array(mapped.mix)
    if values.shape[1] != weights.shape[1]:
        raise InputError(
            problem(
                f"{name}: the log has {values.shape[1]} of {mapped.fields[0]}",
                f"{weights.shape[1]}, as `mix` says",
                "Correct the mapping.",
            )
        )
    # A field of weight 0 is not asked: where it holds no number, the others still count.
    return np.stack([values[:, row != 0] @ row[row != 0] for row in weights], axis=-1)


def _affine(values: Array, factor: float, shift: float) -> Array:
    if factor != 1.0:
        values = values * factor
    return values + shift if shift != 0.0 else values


def _attitude(mapped: ChannelMap, values: Array, world: Array, body: Array) -> Array:
    if mapped.euler:
        q = rotations.from_euler(values[:, 0], values[:, 1], values[:, 2])
    else:
        q = values if mapped.order == "wxyz" else values[:, [mapped.order.index(letter) for letter in "wxyz"]]
    # All zeros is how estimators and trackers say "not yet"; it is no attitude.
    q = np.where((q == 0).all(axis=-1, keepdims=True), np.nan, q)
    if mapped.rotates == "world_to_body":
        q = rotations.conjugate(q)
    endless = np.isinf(q).any(axis=-1, keepdims=True)
    turned = rotate_attitudes(world, body, np.where(endless, np.nan, q) if endless.any() else q)
    if mapped.angle_signs is not None:
        turned = _signed(turned, mapped.angle_signs)
    if endless.any():
        turned = np.where(endless, np.inf, turned)  # kept, to be refused as no number that a log of a flight holds
    return turned if turned is q and not mapped.euler else _one_sign(turned)


def _signed(q: Array, signs: tuple[int, int, int]) -> Array:
    """Quaternions (n, 4), as long as they are, with roll, pitch and yaw times these signs."""
    length = np.linalg.norm(q, axis=-1, keepdims=True)
    return length * rotations.from_euler(*(rotations.to_euler(rotations.normalize(q)) * signs).T)


def _one_sign(q: Array) -> Array:
    """The same attitudes with signs that do not jump, and qw >= 0 in the first one."""
    good = np.isfinite(q).all(axis=-1)
    if good.any():
        kept = rotations.continuous(q[good])
        q[good] = -kept if kept[0, 0] < 0 else kept
    return q


def frame_name(mapped: ChannelMap, stream: StreamMap, mapping: Mapping, which: Any) -> Axes:
    """The world or body frame of a channel: its own, else its stream's, else the mapping's."""
    return getattr(mapped, which) or getattr(stream, which) or getattr(mapping, which)


def frame_of(mapped: ChannelMap, stream: StreamMap, mapping: Mapping, which: Any) -> Array:
    """(3, 3) from that frame's axes to the table's."""
    matrix = frame_matrix(frame_name(mapped, stream, mapping, which), which)
    assert matrix is not None
    return matrix

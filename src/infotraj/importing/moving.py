"""Which of several equal topics of motors holds the motors: the one of which most numbers change."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from infotraj.errors import InputError
from infotraj.importing.channel_map import ChannelMap
from infotraj.importing.channels import CHANNELS
from infotraj.importing.log import Log, Request, Topic


def numbered_fields(channels: dict[str, ChannelMap]) -> tuple[str, ...]:
    """The fields of the channels that count rotors or tilts."""
    return tuple(field for name, mapped in channels.items() if CHANNELS[name].numbered for field in mapped.fields)


def moving_count(log: Log, topic: Topic, fields: Iterable[str]) -> int:
    """How many of the topic's fields take two values. None of a topic that cannot be read does."""
    try:
        samples = log.read([Request(topic, tuple(fields))])[0]
    except InputError:
        return 0
    known = (np.where(np.isfinite(v).any(axis=0), v, 0.0) for v in samples.numbers.values() if v.size)
    return sum(int(np.sum(np.nanmax(v, axis=0) > np.nanmin(v, axis=0))) for v in known)

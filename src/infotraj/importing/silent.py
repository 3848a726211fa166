"""Channels whose feed says nothing: the log's next feed of them is taken."""

from __future__ import annotations

import numpy as np

from infotraj.importing.streams import Feed, Plan, label
from infotraj.rotations import Array


def pass_over_silent(
    found: Plan, values: dict[str, dict[str, Array]], passed: dict[str, list[Feed]], notes: list[str]
) -> bool:
    """Moves every silent channel on to the log's next feed of it; True where one was moved.

    A tracker that sends no attitude logs zeros, and so does the instance of a topic that drives nothing. Where all
    feeds are silent, the first one is kept. values: (n, columns) by stream and channel; passed: the feeds found silent
    so far, by channel, added to.
    """
    moved = False
    for channel in found.channels:
        feed = found.feed_of(channel)
        assert feed is not None
        silent = passed.get(channel, [])
        if feed in silent or channel == "airborne":
            continue
        samples = values[feed.stream.name][channel]
        if np.any(np.isfinite(samples) & (samples != 0.0)):
            if silent:
                note = f"{channel}: {_source(silent[0])} holds only zeros; {_source(feed)} is taken"
                found.notes.append(note)
                notes.append(note)
            continue
        passed.setdefault(channel, []).append(feed)
        if _pass_over(found, channel, passed[channel]):
            moved = True
        elif len(passed[channel]) > 1:
            _give_back(found, channel, passed[channel][0])
            moved = True
    return moved


def _source(feed: Feed) -> str:
    return f"{feed.stream.name} ({label(feed.topic)})"


def _pass_over(found: Plan, channel: str, silent: list[Feed]) -> bool:
    """Takes a channel from the next feed that carries it and is not among `silent`; False where there is none.

    First other topics of the same stream (another instance), then the streams after it, then those before it.
    """
    feed = found.feed_of(channel)
    if feed is None:
        return False
    place = found.feeds.index(feed)
    kin = [s for s in found.spares if s.stream.name.startswith(feed.stream.name)]
    order = [*kin, *found.feeds[place + 1 :], *found.feeds[:place], *found.spares]
    following = next((f for f in order if channel in f.channels and f not in silent and f is not feed), None)
    if following is None:
        return False
    _move(found, channel, feed, following)
    return True


def _give_back(found: Plan, channel: str, first: Feed) -> None:
    """Takes a channel from `first` again."""
    feed = found.feed_of(channel)
    if feed is not None and feed is not first:
        _move(found, channel, feed, first)


def _move(found: Plan, channel: str, feed: Feed, following: Feed) -> None:
    feed.used.remove(channel)
    following.used.append(channel)
    if following in found.spares:
        found.spares.remove(following)
        found.feeds.append(following)

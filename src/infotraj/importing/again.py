"""A flight table that is imported once more, with settings: what it said of itself is kept, and what it had derived is
derived again, from channels that may have changed."""

from __future__ import annotations

from typing import Any

from infotraj.errors import InputError
from infotraj.flight import Flight, read_flight
from infotraj.importing import derive
from infotraj.importing.channels import CHANNELS
from infotraj.importing.reading import Streams

FLIGHT_TABLE = "flight_table"
_DERIVED = (("velocity", "position", derive.VELOCITY_RULE), ("rate", "attitude", derive.RATE_RULE))
_ORIGIN = ("source_file", "source_sha256", "kind", "mapping", "mapping_sha256", "settings", "origin")


def own_metadata(read: Streams) -> dict[str, Any]:
    """What a flight table says of itself; empty for any other log."""
    if read.mapping.name != FLIGHT_TABLE:
        return {}
    try:
        meta = read_flight(read.path).meta
    except InputError:
        return {}
    return {key: value for key, value in meta.items() if key != "source"}


def leave_derived(read: Streams, own: dict[str, Any]) -> None:
    """Leaves out of the plan what the table has derived by the rules of `derive`, unless a setting is about it."""
    how = own.get("derived_how")
    for channel, source, rule in _DERIVED:
        feed, from_feed = read.plan.feed_of(channel), read.plan.feed_of(source)
        if feed is None or from_feed is None or not isinstance(how, dict) or channel in read.mapping.set:
            continue
        if all(how.get(column) == rule for column in CHANNELS[channel].columns):
            feed.used.remove(channel)


def with_own_metadata(flight: Flight, own: dict[str, Any]) -> Flight:
    """The flight with what its table said beside: what was derived elsewhere, `accept` and the like, and its origin."""
    if not own:
        return flight
    meta = {key: value for key, value in own.items() if key not in flight.meta and key not in _ORIGIN} | flight.meta
    derived = own.get("derived")
    if isinstance(derived, list):
        meta["derived"] = sorted({*meta["derived"], *(c for c in derived if c in flight.table)})
    how = own.get("derived_how")
    if isinstance(how, dict):
        meta["derived_how"] = {c: h for c, h in how.items() if c in flight.table} | meta["derived_how"]
    meta["origin"] = {key: own[key] for key in _ORIGIN if key in own}
    return Flight(flight.table, meta)

"""Recordings of flights and of simulated rollouts for the rerun viewer. The only room that imports rerun."""

from infotraj.recording.flight import record_flight
from infotraj.recording.reading import content_hash, read_back

__all__ = ["content_hash", "read_back", "record_flight"]
